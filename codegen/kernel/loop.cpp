// Many closed loops at once: the truth, then every observer and its score, grid point by grid point.

enum { N_HELD = N_NOISE + N_PULSES + 2, N_ROW = 4 * N_SEEN + N_TRUTH };
// Grid points that each observer computes in a row: its code stays in the nearest cache. What they see is on the stack,
// in so many bytes at most.
enum { LEAST = 4, MOST = 32, STACK = 1 << 19 };
constexpr int tile(int points) {
    return points > LEAST && points * (N_OBSERVERS * sizeof(Sight)) > STACK ? tile(points / 2) : points;
}
enum { TILE = tile(MOST) };

// A block at work in all lanes. All arrays are the caller's, aligned for V.
struct Part {
    V *p, *c, *x;                // parameters, what follows from them alone, states; x is null if it does not run
    V *scales;                   // 1 over the largest magnitude of each state, then output
    V *sums;                     // states of its score; observers only
    V *guards;                   // steps that each guard was active, or null
    double *record_x, *record_y; // a row per run and recorded point, or null
    int64_t *failed, *cause;     // per lane: grid point of the failure or −1; what failed, counted over x, y, domain
    int64_t front;               // which front it sees; observers only
};

// As many runs as there are lanes; spare lanes repeat the last one.
struct Runs {
    int64_t n;
    const uint64_t *seeds;
    Part *parts;  // the truth, the sensors, the observers, the score
    FrontPart *fronts;
    int64_t n_fronts;
    V *noise;     // of the newest sample, a number per channel
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

// What the truth shows at one grid point and during the step that begins there.
struct Moment {
    V seen[4 * N_SEEN];  // what sensors look at, stage by stage
    V y[N_TRUTH];
};

typedef V Outputs[N_TRUTH];

INLINE bool sampled(const Batch &batch, int64_t k) { return batch.hold > 0 && k % batch.hold == 0; }

INLINE V time_at(const Batch &batch, int64_t k, int stage = 0) { return ((double)k + NODES[stage]) * batch.h; }

static __attribute__((noinline)) void draw(const Batch &batch, Runs &runs, int64_t k) {
    for (int i = 0; i < N_NOISE; ++i) noise(runs.seeds, (uint64_t)i, (uint64_t)(k / batch.hold), runs.noise + i);
}

// What is held over the step from k; the noise is that of now.
INLINE void hold(const Batch &batch, const Runs &runs, int64_t k, V *held) {
    copy<N_NOISE>(runs.noise, held);
    for (int i = 0; i < N_PULSES; ++i) held[N_NOISE + i] = batch.pulse_on[i] <= k && k < batch.pulse_off[i];
    held[N_NOISE + N_PULSES] = k >= batch.window;
    held[N_NOISE + N_PULSES + 1] = sampled(batch, k);
}

// Nothing is known from where the truth has failed. It may be ahead of its observers by a tile.
INLINE bool gone(const Part &truth, int64_t k, int l) { return truth.failed[l] >= 0 && truth.failed[l] <= k; }

template <class B>
static __attribute__((noinline)) void fail(Part &part, const Part &truth, int64_t k, const V *y, const V *domain) {
    for (int l = 0; l < LANES; ++l) {
        if (part.failed[l] >= 0 || gone(truth, k, l)) continue;
        const int cause = failing<B>(part.x, y, domain, part.scales, l);
        if (cause < 0) continue;
        part.failed[l] = k;
        part.cause[l] = cause;
    }
}

template <class B>
static __attribute__((noinline)) void keep(const Batch &batch, const Runs &runs, Part &part, int64_t k, const V *y) {
    const int64_t points = batch.steps / batch.record + 1, row = k / batch.record;
    for (int64_t l = 0; l < runs.n; ++l) {
        if (part.failed[l] >= 0 || gone(runs.parts[0], k, (int)l)) continue;
        for (int i = 0; i < B::NX; ++i) part.record_x[(l * points + row) * B::NX + i] = lane(part.x[i], (int)l);
        for (int i = 0; i < B::NY; ++i) part.record_y[(l * points + row) * B::NY + i] = lane(y[i], (int)l);
    }
}

template <class B>
static FLAT void watch(Part &part, const Part &truth, int64_t k, const V *t, const V *held, const V *staged) {
    V active[B::N_GUARDS + 1];
    B::watch(t, part.c, part.x, held, staged, active);
    for (int l = 0; l < LANES; ++l)
        for (int i = 0; i < B::N_GUARDS && part.failed[l] < 0 && !gone(truth, k, l); ++i)
            set_lane(part.guards[i], l, lane(part.guards[i], l) + lane(active[i], l));
}

// Failures, records and guards, at few grid points: only for them are states written back from registers to `part`.
template <class B>
static __attribute__((noinline)) void attend(const Batch &batch, Runs &runs, Part &part, int64_t k, const V *t,
                                             const V *staged, const V *y, const V *domain, bool wrong) {
    if (wrong) fail<B>(part, runs.parts[0], k, y, domain);
    if (part.record_x && k % batch.record == 0) keep<B>(batch, runs, part, k, y);
    if (part.guards && k < batch.steps) {
        V held[N_HELD];
        hold(batch, runs, k, held);
        watch<B>(part, runs.parts[0], k, t, held, staged);
    }
}

// Jumps, outputs, checks and records at grid point k.
template <class B>
INLINE void visit(const Batch &batch, Runs &runs, Part &part, int64_t k, const V *t, const V *held, const V *staged,
                  V *x, V *y) {
    V after[B::NX + 1], domain[B::N_DOMAIN + 1];
    if constexpr (B::HAS_SAMPLE)
        if (sampled(batch, k)) {
            B::sample(t, part.c, x, held, staged, after);
            copy<B::NX>(after, x);
        }
    if constexpr (B::HAS_EACH) {
        B::each(t, part.c, x, held, staged, after);
        copy<B::NX>(after, x);
    }
    B::out(t, part.c, x, held, staged, y, domain);
    const bool wrong = any(suspect<B>(x, y, domain, part.scales));
    if (__builtin_expect(wrong || part.record_x || part.guards, 0)) {
        // copies: a variable whose address is passed on cannot stay in a register
        V outputs[B::NY + 1], limits[B::N_DOMAIN + 1], time[B::N_TIME + 1];
        copy<B::N_TIME>(t, time);
        copy<B::NX>(x, part.x);
        copy<B::NY>(y, outputs);
        copy<B::N_DOMAIN>(domain, limits);
        attend<B>(batch, runs, part, k, time, staged, outputs, limits, wrong);
    }
}

// What the truth takes for the time, the same in all runs.
typedef double Row[Truth::N_TIME + 1];

// The rows of TILE grid points from k on, one in each lane.
static FLAT void tick(const Batch &batch, const Part &truth, int64_t k, Row *rows) {
    for (int i = 0; i < TILE; i += LANES) {
        V t, row[Truth::N_TIME + 1];
        for (int l = 0; l < LANES; ++l) set_lane(t, l, (double)(k + i + l) * batch.h);
        Truth::clock(&t, truth.c, row);
        for (int l = 0; l < LANES && i + l < TILE; ++l)
            for (int j = 0; j < Truth::N_TIME; ++j) rows[i + l][j] = lane(row[j], l);
    }
}

template <int N> INLINE void spread(const double *values, V *to) {
#pragma GCC unroll 128
    for (int i = 0; i < N; ++i) to[i] = values[i];
}

// one function for both kinds of batches, so that sharing the truth changes no bit of it
static FLAT void advance_truth(const Batch &batch, Runs &runs, int64_t k, const Row &row, Moment &now) {
    Part &part = runs.parts[0];
    V x[Truth::NX + 1], after[Truth::NX + 1], y[N_TRUTH], held[N_HELD], t[Truth::N_TIME + 1];
    spread<Truth::N_TIME>(row, t);
    hold(batch, runs, k, held);
    copy<Truth::NX>(part.x, x);
    visit<Truth>(batch, runs, part, k, t, held, 0, x, y);
    copy<N_TRUTH>(y, now.y);
    Truth::step(t, part.c, x, held, 0, after, now.seen);
    if (k < batch.steps) copy<Truth::NX>(after, part.x);
}

static void spread(const double *values, Moment &now) {
    spread<4 * N_SEEN>(values, now.seen);
    spread<N_TRUTH>(values + 4 * N_SEEN, now.y);
}

static void collect(const Moment &now, double *values) {
    for (int i = 0; i < 4 * N_SEEN; ++i) values[i] = lane(now.seen[i], 0);
    for (int i = 0; i < N_TRUTH; ++i) values[4 * N_SEEN + i] = lane(now.y[i], 0);
}

// What the sensors show at the four stages of a step.
static FLAT void measure(const Batch &batch, Runs &runs, int64_t k, const Moment &now, Sight &sight) {
    Part &part = runs.parts[1];
    V held[N_HELD], nothing[Sensors::N_DOMAIN + 1];
    hold(batch, runs, k, held);
    for (int i = 0; i < 4; ++i) {
        const V t = time_at(batch, k, i);
        Sensors::out(&t, part.c, 0, held, now.seen + i * N_SEEN, sight.staged + i * N_STAGED, nothing);
    }
    if (part.record_x && k % batch.record == 0) keep<Sensors>(batch, runs, part, k, sight.staged);
}

template <class S>
INLINE void account(const Batch &batch, const V *c, int64_t k, const V *held, const V *scored, V *sums) {
    V after[S::NX + 1];
    const V t = time_at(batch, k);
    if constexpr (S::HAS_SAMPLE)
        if (sampled(batch, k)) {
            S::sample(&t, c, sums, held, scored, after);
            copy<S::NX>(after, sums);
        }
    if constexpr (S::HAS_EACH) {
        S::each(&t, c, sums, held, scored, after);
        copy<S::NX>(after, sums);
    }
}

// One observer and its score at the grid points from `from` to `until`, exclusive. What moves at samples only is scored
// there: in between it claims nothing new.
template <class B, class S>
static FLAT void observe(const Batch &batch, Runs &runs, Part &part, int64_t from, int64_t until, const Outputs *truth,
                         const Sight *sights) {
    V x[B::NX + 1], sums[S::NX + 1], after[B::NX + 1];
    copy<B::NX>(part.x, x);
    copy<S::NX>(part.sums, sums);
    for (int64_t k = from; k < until; ++k) {
        if (B::SAMPLED && !sampled(batch, k) && !part.record_x && !part.guards) continue;
        const V *staged = sights[k - from].staged, t = time_at(batch, k);
        V held[N_HELD], scored[N_TRUTH + B::NY];  // of the outputs, the first N_ESTIMATES
        hold(batch, runs, k, held);
        copy<N_TRUTH>(truth[k - from], scored);
        visit<B>(batch, runs, part, k, &t, held, staged, x, scored + N_TRUTH);
        if (!B::SAMPLED || sampled(batch, k)) account<S>(batch, runs.parts[2 + N_OBSERVERS].c, k, held, scored, sums);
        if (B::SAMPLED || k == batch.steps) continue;
        B::step(&t, part.c, x, held, staged, after, 0);
        copy<B::NX>(after, x);
    }
    copy<B::NX>(x, part.x);
    copy<S::NX>(sums, part.sums);
}

template <class B> static void prepare(const Batch &batch, Part &part) {
    const V h = batch.h;
    B::constants(&h, part.p, part.c);
    B::scales(&h, part.p, part.scales);
    for (int l = 0; l < LANES; ++l) part.failed[l] = -1;
}

// An observer may start from what is measured then.
template <class B> static void begin(const Batch &batch, Runs &runs, Part &part, const Sight &sight) {
    const V t = 0.0;
    V held[N_HELD];
    hold(batch, runs, 0, held);
    B::init(&t, part.p, held, sight.staged, part.x);
}

// The observers that run, one by one.
static void prepare_all(List<>, const Batch &, Part *) {}

template <class B, class... Rest> static void prepare_all(List<B, Rest...>, const Batch &batch, Part *part) {
    if (part->x) prepare<B>(batch, *part);
    prepare_all(List<Rest...>(), batch, part + 1);
}

typedef Sight Sights[N_OBSERVERS][TILE];

static void observe_all(List<>, const Batch &, Runs &, Part *, int64_t, int64_t, const Outputs *, const Sights &) {}

template <class B, class... Rest>
static void observe_all(List<B, Rest...>, const Batch &batch, Runs &runs, Part *part, int64_t from, int64_t until,
                        const Outputs *truth, const Sights &sights) {
    if (part->x) {
        const Sight *own = sights[part->front];
        if (from == 0) begin<B>(batch, runs, *part, own[0]);
        observe<B, Score>(batch, runs, *part, from, until, truth, own);
    }
    observe_all(List<Rest...>(), batch, runs, part + 1, from, until, truth, sights);
}

// At most TILE grid points; `rows` are those of a truth that all share, or null.
static void advance(const Batch &batch, Runs &runs, int64_t from, int64_t until, const double *rows) {
    Moment now;
    Outputs truth[TILE];
    Sights sights;
    Row clock[TILE];
    if (!rows) tick(batch, runs.parts[0], from, clock);
    for (int64_t k = from; k < until; ++k) {
        if (sampled(batch, k)) draw(batch, runs, k);
        if (rows)
            spread(rows + (k - from) * N_ROW, now);
        else
            advance_truth(batch, runs, k, clock[k - from], now);
        copy<N_TRUTH>(now.y, truth[k - from]);
        measure(batch, runs, k, now, sights[0][k - from]);
        for (int64_t i = 1; i < runs.n_fronts; ++i) copy<4 * N_STAGED>(sights[0][k - from].staged, sights[i][k - from].staged);
    }
    for (int64_t i = 0; i < runs.n_fronts; ++i) see<Near>(runs.fronts[i], until - from, sights[i]);
    observe_all(Observers(), batch, runs, runs.parts + 2, from, until, truth, sights);
}

HILLOBS_EXPORT void hillobs_start(Batch *batch) {
    const V t = 0.0, h = batch->h;
    batch->k = 0;
    for (int64_t i = batch->truth ? -1 : 0; i < batch->n_runs; ++i) {
        Runs &runs = i < 0 ? *batch->truth : batch->runs[i];
        if (i < 0 || !batch->truth) {
            V held[N_HELD];
            if (sampled(*batch, 0)) draw(*batch, runs, 0);
            hold(*batch, runs, 0, held);
            prepare<Truth>(*batch, runs.parts[0]);
            Truth::init(&t, runs.parts[0].p, held, 0, runs.parts[0].x);
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
            Moment now;
            Row clock[TILE];
            for (int64_t k = from; k < to; ++k) {
                if ((k - from) % TILE == 0) tick(*batch, batch->truth->parts[0], k, clock);
                advance_truth(*batch, *batch->truth, k, clock[(k - from) % TILE], now);
                collect(now, batch->rows + (k - from) * N_ROW);
            }
        }
        for (int64_t i = 0; i < batch->n_runs; ++i)
            for (int64_t k = from; k < to; k += TILE)
                advance(*batch, batch->runs[i], k, k + TILE < to ? k + TILE : to,
                        batch->truth ? batch->rows + (k - from) * N_ROW : 0);
        batch->k = to;
    }
}

// Lanes, and sizes as compiled, so that the caller can compare them with what it believes.
HILLOBS_EXPORT void hillobs_sizes(int64_t *sizes) {
    const int64_t own[] = {LANES, N_ROW, sizeof(Batch), sizeof(Runs), sizeof(Part), sizeof(FrontPart)};
    for (int64_t size : own) *sizes++ = size;
    sizes_of_all(Everything(), sizes);
}
