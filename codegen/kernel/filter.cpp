// Observers that follow a recording, sample by sample; all lanes compute the same, so a scalar build is fastest.

// One observer under way. All arrays are the caller's, those of V aligned for it.
struct Filter {
    V *p, *c, *x;         // parameters, what follows from them and the step, states
    V *scales;            // 1 over the largest magnitude of each state, then output
    FrontPart front;
    double h;             // the step that the constants are for; 0 at first
    int64_t substeps;     // from sample to sample
    int64_t begun, n;     // samples passed before these, of which the last comes first; samples
    const double *t, *y;  // their times; N_MEASURED numbers each
    double *results;      // n × (outputs, guards); untouched from a failure on
    int64_t failed, cause;  // sample of a failure or −1; what failed, counted over x, y, domain
};

// Measurements are interpolated linearly from sample i − 1 to sample i: nothing later is used.
INLINE void between(const Filter &f, int64_t i, int64_t step, Sight &sight) {
    const double *from = f.y + (i > 0 ? i - 1 : 0) * N_MEASURED, *to = f.y + i * N_MEASURED;
    for (int s = 0; s < 4; ++s)
        for (int m = 0; m < N_MEASURED; ++m)
            sight.staged[s * N_STAGED + m] = from[m] + (to[m] - from[m]) * (((double)step + NODES[s]) / (double)f.substeps);
    see<Near>(f.front, 1, &sight);
}

// Sample i alone.
INLINE void look(const Filter &f, int64_t i, Sight &sight) {
    V nothing[Front::N_DOMAIN + 1];
    for (int m = 0; m < N_MEASURED; ++m) sight.staged[m] = f.y[i * N_MEASURED + m];
    Front::out(&NEVER, f.front.c, 0, &NEVER, sight.staged, sight.staged + N_MEASURED, nothing);
}

template <class B> static __attribute__((noinline)) void prepare(Filter &f, double step) {
    const V h = f.h = step;
    B::constants(&h, f.p, f.c);
    B::scales(&h, f.p, f.scales);
    Front::constants(&h, f.front.p, f.front.c);
    Near::constants(&h, f.front.p, f.front.c_near);
}

template <class B> static FLAT void leave(Filter &f, int64_t i, const V *staged) {
    V y[B::NY + 1], domain[B::N_DOMAIN + 1], guards[B::N_GUARDS + 1];
    const V t = f.t[i];
    if constexpr (B::HAS_SAMPLE) {
        V after[B::NX + 1];
        B::sample(&t, f.c, f.x, &NEVER, staged, after);
        copy<B::NX>(after, f.x);
    }
    B::out(&t, f.c, f.x, &NEVER, staged, y, domain);
    if (any(suspect<B>(f.x, y, domain, f.scales)) && (f.cause = failing<B>(f.x, y, domain, f.scales, 0)) >= 0) {
        f.failed = i;
        return;
    }
    B::watch(&t, f.c, f.x, &NEVER, staged, guards);
    double *row = f.results + i * (B::NY + B::N_GUARDS);
    for (int j = 0; j < B::NY; ++j) row[j] = lane(y[j], 0);
    for (int j = 0; j < B::N_GUARDS; ++j) row[B::NY + j] = lane(guards[j], 0);
}

template <class B> static FLAT void follow(Filter &f) {
    Sight sight;
    V x[B::NX + 1], after[B::NX + 1];
    int64_t i = f.begun > 0;
    if (!i && f.n > 0) {
        const V t = f.t[0];
        prepare<B>(f, f.n > 1 ? (f.t[1] - f.t[0]) / (double)f.substeps : 1.0);
        between(f, 0, 0, sight);
        B::init(&t, f.p, &NEVER, sight.staged, f.x);
        leave<B>(f, i++, sight.staged);
    }
    for (; i < f.n && f.failed < 0; ++i) {
        const double step = (f.t[i] - f.t[i - 1]) / (double)f.substeps;
        if (step != f.h) prepare<B>(f, step);
        // what moves at samples only has no use for the stages before
        if constexpr (B::SAMPLED) {
            look(f, i, sight);
            leave<B>(f, i, sight.staged);
            continue;
        }
        copy<B::NX>(f.x, x);
        for (int64_t s = 0; s < f.substeps; ++s) {
            const V t = f.t[i - 1] + (double)s * step;
            between(f, i, s, sight);
            B::step(&t, f.c, x, &NEVER, sight.staged, after, 0);
            copy<B::NX>(after, x);
        }
        copy<B::NX>(x, f.x);
        leave<B>(f, i, sight.staged + 3 * N_STAGED);
    }
}

static void follow_one(List<>, int64_t, Filter &) {}

template <class B, class... Rest> static void follow_one(List<B, Rest...>, int64_t which, Filter &f) {
    if (which == 0) return follow<B>(f);
    follow_one(List<Rest...>(), which - 1, f);
}

HILLOBS_EXPORT void hillobs_follow(int64_t which, Filter *f) { follow_one(Observers(), which, *f); }

HILLOBS_EXPORT void hillobs_sizes(int64_t *sizes) {
    *sizes++ = LANES;
    *sizes++ = sizeof(Filter);
    sizes_of_all(Everything(), sizes);
}
