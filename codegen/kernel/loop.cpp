// Many closed loops at once: the truth, then every observer and its score, grid point by grid point.

enum { N_HELD = N_NOISE + N_PULSES + 2, N_STAGED = N_MEASURED + N_FRONT, N_ROW = 4 * N_SEEN + N_TRUTH };

// A block at work in all lanes. All arrays are the caller's, aligned for V.
struct Part {
    V *p, *c, *x;                // parameters, what follows from them alone, states; x is null if it does not run
    V *sums;                     // states of its score; observers only
    V *guards;                   // steps that each guard was active, or null
    double *record_x, *record_y; // a row per run and recorded point, or null
    int64_t *failed, *cause;     // per lane: grid point of the failure or −1; what failed, counted over x, y, domain
    int64_t front;               // which front it sees; observers only
};

// What observers compute from the measurements alone, with one set of numbers.
struct FrontPart {
    V *p, *c, *c_near;
};

// So many runs as fit in the lanes; spare lanes repeat the last one.
struct Runs {
    int64_t n;
    const uint64_t *seeds;
    Part *parts;  // the truth, the sensors, the observers, the score
    FrontPart *fronts;
    int64_t n_fronts;
    V *held;      // noise, pulses, window, sample
};

// Runs on one time grid. If they share the truth, it runs once, in `truth`, and leaves a row per step.
struct Batch {
    double h;
    int64_t k, steps;                     // next grid point; the last one
    int64_t hold, window, record;         // steps per noise sample (0: none), first scored point, steps per record
    const int64_t *pulse_on, *pulse_off;  // in steps
    int64_t n_runs;
    Runs *runs;
    Runs *truth;   // or null: each has its own
    double *rows;  // tile × N_ROW
    int64_t tile;
};

// What one step of the truth shows: what sensors see at each stage; its outputs, with room for estimates behind.
struct Row {
    V seen[4 * N_SEEN];
    V y[N_TRUTH + N_ESTIMATES];
};

// all that it calls becomes part of it: then CasADi's questions whether a pointer is null are answered at compile time
#define FLAT __attribute__((flatten, noinline))

static const double NODES[] = {0, 0.5, 0.5, 1};

static __attribute__((noinline)) void draw(const Batch &batch, Runs &runs, int64_t k) {
    const bool sample = batch.hold > 0 && k % batch.hold == 0;
    if (sample)
        for (int i = 0; i < N_NOISE; ++i) noise(runs.seeds, (uint64_t)i, (uint64_t)(k / batch.hold), runs.held + i);
    for (int i = 0; i < N_PULSES; ++i) runs.held[N_NOISE + i] = batch.pulse_on[i] <= k && k < batch.pulse_off[i];
    runs.held[N_NOISE + N_PULSES] = k >= batch.window;
    runs.held[N_NOISE + N_PULSES + 1] = sample;
}

template <int N> INLINE void copy(const V *from, V *to) {
#pragma GCC unroll 64  // or it becomes a call of memmove
    for (int i = 0; i < N; ++i) to[i] = from[i];
}

// not 0 in the lanes where a number is not finite or the domain is left
template <class B> INLINE V wrong(const V *x, const V *y, const V *domain) {
    V sum = 0.0;
    for (int i = 0; i < B::NX; ++i) sum = x[i] * 0.0 + sum;
    for (int i = 0; i < B::NY; ++i) sum = y[i] * 0.0 + sum;
    for (int i = 0; i < B::N_DOMAIN; ++i) sum = !(V(0.0) < domain[i]) + sum;
    return sum;
}

template <class B>
static __attribute__((noinline)) void fail(Part &part, const Part &truth, int64_t k, const V *x, const V *y, const V *domain) {
    for (int l = 0; l < LANES; ++l)
        for (int i = 0; i < B::NX + B::NY + B::N_DOMAIN; ++i) {
            if (part.failed[l] >= 0 || truth.failed[l] >= 0) break;  // nothing is known of a truth that is not there
            const double value = lane(i < B::NX ? x[i] : i < B::NX + B::NY ? y[i - B::NX] : domain[i - B::NX - B::NY], l);
            if (isfinite(value) && (i < B::NX + B::NY || value > 0)) continue;
            part.failed[l] = k;
            part.cause[l] = i;
        }
}

template <class B>
static __attribute__((noinline)) void keep(const Batch &batch, const Runs &runs, Part &part, int64_t k, const V *y) {
    const int64_t points = batch.steps / batch.record + 1, row = k / batch.record;
    for (int64_t l = 0; l < runs.n; ++l) {
        if (part.failed[l] >= 0 || runs.parts[0].failed[l] >= 0) continue;
        for (int i = 0; i < B::NX; ++i) part.record_x[(l * points + row) * B::NX + i] = lane(part.x[i], (int)l);
        for (int i = 0; i < B::NY; ++i) part.record_y[(l * points + row) * B::NY + i] = lane(y[i], (int)l);
    }
}

template <class B>
static FLAT void watch(Part &part, const Part &truth, const V *t, const V *held, const V *staged) {
    V active[B::N_GUARDS + 1];
    B::watch(t, part.c, part.x, held, staged, active);
    for (int l = 0; l < LANES; ++l)
        for (int i = 0; i < B::N_GUARDS && part.failed[l] < 0 && truth.failed[l] < 0; ++i)
            set_lane(part.guards[i], l, lane(part.guards[i], l) + lane(active[i], l));
}

// Jumps, outputs, checks and records at grid point k.
template <class B>
INLINE void visit(const Batch &batch, Runs &runs, Part &part, int64_t k, const V *t, const V *staged, V *y) {
    V after[B::NX + 1], domain[B::N_DOMAIN + 1];
    if constexpr (B::HAS_SAMPLE)
        if (batch.hold > 0 && k % batch.hold == 0) {
            B::sample(t, part.c, part.x, runs.held, staged, after);
            copy<B::NX>(after, part.x);
        }
    if constexpr (B::HAS_EACH) {
        B::each(t, part.c, part.x, runs.held, staged, after);
        copy<B::NX>(after, part.x);
    }
    B::out(t, part.c, part.x, runs.held, staged, y, domain);
    if (any(wrong<B>(part.x, y, domain))) fail<B>(part, runs.parts[0], k, part.x, y, domain);
    if (part.record_x && k % batch.record == 0) keep<B>(batch, runs, part, k, y);
    if (part.guards && k < batch.steps) watch<B>(part, runs.parts[0], t, runs.held, staged);
}

// one function for both kinds of batches, so that sharing the truth changes no bit of it
static FLAT void advance_truth(const Batch &batch, Runs &runs, int64_t k, Row &row) {
    Part &part = runs.parts[0];
    const V t = (double)k * batch.h;
    visit<Truth>(batch, runs, part, k, &t, 0, row.y);
    V after[Truth::NX + 1];
    Truth::step(&t, part.c, part.x, runs.held, 0, after, row.seen);
    if (k < batch.steps) copy<Truth::NX>(after, part.x);
}

static void spread(const double *values, Row &row) {
    for (int i = 0; i < 4 * N_SEEN; ++i) row.seen[i] = values[i];
    for (int i = 0; i < N_TRUTH; ++i) row.y[i] = values[4 * N_SEEN + i];
}

static void collect(const Row &row, double *values) {
    for (int i = 0; i < 4 * N_SEEN; ++i) values[i] = lane(row.seen[i], 0);
    for (int i = 0; i < N_TRUTH; ++i) values[4 * N_SEEN + i] = lane(row.y[i], 0);
}

// What the sensors show at the four stages of a step.
static FLAT void measure(const Batch &batch, Runs &runs, int64_t k, const Row &row, V *measured) {
    Part &part = runs.parts[1];
    V nothing[Sensors::N_DOMAIN + 1];
    for (int i = 0; i < 4; ++i) {
        const V t = ((double)k + NODES[i]) * batch.h;
        Sensors::out(&t, part.c, 0, runs.held, row.seen + i * N_SEEN, measured + i * N_STAGED, nothing);
    }
    if (part.record_x && k % batch.record == 0) keep<Sensors>(batch, runs, part, k, measured);
}

// What observers see at the four stages of a step: the measurements and what a front makes of them.
template <class N>
static FLAT void see(const Batch &batch, Runs &runs, const FrontPart &part, int64_t k, const V *measured, V *staged) {
    V near[4 * N_FRONT + 1], front[N_FRONT], nothing[N::N_DOMAIN + 1], doubt = 1.0;
    copy<4 * N_STAGED>(measured, staged);
    if constexpr (HAS_NEAR) {
        const V t = (double)k * batch.h;
        N::out(&t, part.c_near, 0, runs.held, measured, near, nothing);
        doubt = near[4 * N_FRONT];
    }
    const bool check = any(doubt);
    for (int i = 0; i < 4; ++i) {
        const V t = ((double)k + NODES[i]) * batch.h;
        if (check) Front::out(&t, part.c, 0, runs.held, measured + i * N_STAGED, front, nothing);
        for (int j = 0; j < N_FRONT; ++j) {
            const V quick = near[i * N_FRONT + j];
            staged[i * N_STAGED + N_MEASURED + j] = check ? select(doubt, front[j], quick) : quick;
        }
    }
}

template <class S>
INLINE void account(const Batch &batch, Runs &runs, Part &part, int64_t k, const V *t, const V *scored) {
    const V *c = runs.parts[2 + N_OBSERVERS].c;
    V sums[S::NX];
    if constexpr (S::HAS_SAMPLE)
        if (batch.hold > 0 && k % batch.hold == 0) {
            S::sample(t, c, part.sums, runs.held, scored, sums);
            copy<S::NX>(sums, part.sums);
        }
    S::each(t, c, part.sums, runs.held, scored, sums);
    copy<S::NX>(sums, part.sums);
}

template <class B>
INLINE void observe(const Batch &batch, Runs &runs, Part &part, int64_t k, Row &row, const V (*seen)[4 * N_STAGED]) {
    if (!part.x) return;
    const V *staged = seen[part.front], t = (double)k * batch.h;
    visit<B>(batch, runs, part, k, &t, staged, row.y + N_TRUTH);
    account<Score>(batch, runs, part, k, &t, row.y);
    if (k == batch.steps) return;
    V after[B::NX + 1];
    B::step(&t, part.c, part.x, runs.held, staged, after, 0);
    copy<B::NX>(after, part.x);
}

INLINE void observe_all(List<>, const Batch &, Runs &, Part *, int64_t, Row &, const V (*)[4 * N_STAGED]) {}

template <class B, class... Rest>
INLINE void observe_all(List<B, Rest...>, const Batch &batch, Runs &runs, Part *part, int64_t k, Row &row,
                        const V (*seen)[4 * N_STAGED]) {
    observe<B>(batch, runs, *part, k, row, seen);
    observe_all(List<Rest...>(), batch, runs, part + 1, k, row, seen);
}

template <class B> static void prepare(const Batch &batch, Part &part) {
    const V h = batch.h;
    B::constants(&h, part.p, part.c);
    for (int l = 0; l < LANES; ++l) part.failed[l] = -1;
}

static void prepare_all(List<>, const Batch &, Part *) {}

template <class B, class... Rest> static void prepare_all(List<B, Rest...>, const Batch &batch, Part *part) {
    if (part->x) prepare<B>(batch, *part);
    prepare_all(List<Rest...>(), batch, part + 1);
}

// An observer may start from what is measured then.
static void begin_all(List<>, Runs &, Part *, const V *, const V (*)[4 * N_STAGED]) {}

template <class B, class... Rest>
static void begin_all(List<B, Rest...>, Runs &runs, Part *part, const V *t, const V (*seen)[4 * N_STAGED]) {
    if (part->x) B::init(t, part->p, runs.held, seen[part->front], part->x);
    begin_all(List<Rest...>(), runs, part + 1, t, seen);
}

static FLAT void advance(const Batch &batch, Runs &runs, int64_t from, int64_t until) {
    Row row;
    V measured[4 * N_STAGED], seen[N_OBSERVERS][4 * N_STAGED];
    for (int64_t k = from; k < until; ++k) {
        draw(batch, runs, k);
        if (batch.truth)
            spread(batch.rows + (k - from) * N_ROW, row);
        else
            advance_truth(batch, runs, k, row);
        measure(batch, runs, k, row, measured);
        for (int64_t i = 0; i < runs.n_fronts; ++i) see<Near>(batch, runs, runs.fronts[i], k, measured, seen[i]);
        if (k == 0) {
            const V t = 0.0;
            begin_all(Observers(), runs, runs.parts + 2, &t, seen);
        }
        observe_all(Observers(), batch, runs, runs.parts + 2, k, row, seen);
    }
}

HILLOBS_EXPORT void hillobs_start(Batch *batch) {
    const V t = 0.0, h = batch->h;
    batch->k = 0;
    for (int64_t i = batch->truth ? -1 : 0; i < batch->n_runs; ++i) {
        Runs &runs = i < 0 ? *batch->truth : batch->runs[i];
        if (i < 0 || !batch->truth) {
            draw(*batch, runs, 0);
            prepare<Truth>(*batch, runs.parts[0]);
            Truth::init(&t, runs.parts[0].p, runs.held, 0, runs.parts[0].x);
        }
        if (i < 0) continue;
        prepare<Sensors>(*batch, runs.parts[1]);
        prepare_all(Observers(), *batch, runs.parts + 2);
        prepare<Score>(*batch, runs.parts[2 + N_OBSERVERS]);
        for (int64_t j = 0; j < runs.n_fronts; ++j) {
            const FrontPart &front = runs.fronts[j];
            Front::constants(&h, front.p, front.c);
            Near::constants(&h, front.p, front.c_near);
        }
    }
}

// Grid points up to, not including, `until`; a run is over at steps + 1.
HILLOBS_EXPORT void hillobs_advance(Batch *batch, int64_t until) {
    if (until > batch->steps + 1) until = batch->steps + 1;
    while (batch->k < until) {
        const int64_t from = batch->k, to = until < from + batch->tile ? until : from + batch->tile;
        if (batch->truth) {
            Row row;
            for (int64_t k = from; k < to; ++k) {
                draw(*batch, *batch->truth, k);
                advance_truth(*batch, *batch->truth, k, row);
                collect(row, batch->rows + (k - from) * N_ROW);
            }
        }
        for (int64_t i = 0; i < batch->n_runs; ++i) advance(*batch, batch->runs[i], from, to);
        batch->k = to;
    }
}

// Lanes, and sizes as compiled, so that the caller can compare them with what it believes.
template <class B> static int64_t *sizes_of(int64_t *sizes) {
    const int64_t own[] = {B::NX, B::NP, B::NC, B::NY, B::N_GUARDS, B::N_DOMAIN};
    for (int64_t size : own) *sizes++ = size;
    return sizes;
}

static int64_t *sizes_of_all(List<>, int64_t *sizes) { return sizes; }

template <class B, class... Rest> static int64_t *sizes_of_all(List<B, Rest...>, int64_t *sizes) {
    return sizes_of_all(List<Rest...>(), sizes_of<B>(sizes));
}

HILLOBS_EXPORT void hillobs_sizes(int64_t *sizes) {
    const int64_t own[] = {LANES, N_ROW, sizeof(Batch), sizeof(Runs), sizeof(Part), sizeof(FrontPart)};
    for (int64_t size : own) *sizes++ = size;
    sizes_of_all(Everything(), sizes);
}
