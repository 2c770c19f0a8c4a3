// One run of the closed loop: the truth, then every observer and its score, grid point by grid point.

// A Block at work. All arrays are the caller's.
struct Part {
    int64_t block;               // its row in BLOCKS
    const double *p;             // parameters
    double *x, *y, *guards;      // state, outputs, steps that each guard was active
    double *score;               // state of its score; null for the truth
    double *record_x, *record_y; // a row per recorded point
    int64_t failed, cause;       // grid point of the failure or −1; what failed, counted over x, y, domain
};

struct Run {
    double h;
    uint64_t seed;
    int64_t k, steps;                     // next grid point; the last one
    int64_t hold, window, record;         // steps per noise sample (0: none), first scored point, steps per record
    const int64_t *pulse_on, *pulse_off;  // in steps
    const double *p_score;
    Part *parts;                          // the truth first
    int64_t n_parts;
    double *held;                         // noise, pulses, window, sample
};

static const Block &SCORE = BLOCKS[SCORE_BLOCK];

static void draw_held(Run &run) {
    const int64_t k = run.k;
    const bool sample = run.hold > 0 && k % run.hold == 0;
    double *held = run.held;
    if (sample)
        for (int i = 0; i < N_NOISE; ++i) held[i] = noise(run.seed, (uint32_t)i, (uint32_t)(k / run.hold));
    for (int i = 0; i < N_PULSES; ++i) held[N_NOISE + i] = run.pulse_on[i] <= k && k < run.pulse_off[i];
    held[N_NOISE + N_PULSES] = k >= run.window;
    held[N_NOISE + N_PULSES + 1] = sample;
}

// The jumps of a block at a grid point.
static void jump(Evaluate by, const Block &block, const double *t, const double *p, const double *held,
                 const double *staged, double *x) {
    if (!by) return;
    double after[MAX_STATES];
    const double *arg[] = {t, x, p, held, staged};
    double *res[] = {after};
    by(arg, res, 0, 0, 0);
    memcpy(x, after, (size_t)block.nx * sizeof *x);
}

static bool all_finite(const double *values, int n) {
    for (int i = 0; i < n; ++i)
        if (!isfinite(values[i])) return false;
    return true;
}

// Marks the part as failed at grid point k if a number is not finite or the domain is left.
static void check(Part &part, const double *domain, int64_t k) {
    const Block &block = BLOCKS[part.block];
    for (int i = 0; i < block.nx + block.ny + block.n_domain; ++i) {
        const double value = i < block.nx              ? part.x[i]
                             : i < block.nx + block.ny ? part.y[i - block.nx]
                                                       : domain[i - block.nx - block.ny];
        if (!isfinite(value) || (i >= block.nx + block.ny && value <= 0)) {
            part.failed = k;
            part.cause = i;
            return;
        }
    }
}

// Jumps, outputs, guards, record of one part at grid point k; `staged` are its inputs there.
static void visit(Run &run, Part &part, const double *t, const double *staged) {
    const Block &block = BLOCKS[part.block];
    if (run.held[N_NOISE + N_PULSES + 1] != 0) jump(block.sample, block, t, part.p, run.held, staged, part.x);
    jump(block.each, block, t, part.p, run.held, staged, part.x);
    double active[MAX_GUARDS], domain[MAX_GUARDS];
    const double *arg[] = {t, part.x, part.p, run.held, staged};
    double *res[] = {part.y, active, domain};
    block.out(arg, res, 0, 0, 0);
    check(part, domain, run.k);
    if (part.failed >= 0) return;
    if (run.k < run.steps)
        for (int i = 0; i < block.n_guards; ++i) part.guards[i] += active[i];
    if (run.k % run.record == 0) {
        const int64_t row = run.k / run.record;
        memcpy(part.record_x + row * block.nx, part.x, (size_t)block.nx * sizeof *part.x);
        memcpy(part.record_y + row * block.ny, part.y, (size_t)block.ny * sizeof *part.y);
    }
}

static void visit_all(Run &run) {
    draw_held(run);
    const double t = (double)run.k * run.h;
    Part &truth = run.parts[0];
    visit(run, truth, &t, 0);
    if (truth.failed >= 0) return;
    const int n_truth = BLOCKS[truth.block].ny;
    double measured[N_STAGED], scored[MAX_SCORED];
    for (int i = 0; i < N_STAGED; ++i) measured[i] = truth.y[STAGED[i]];
    memcpy(scored, truth.y, (size_t)n_truth * sizeof *scored);
    for (int64_t i = 1; i < run.n_parts; ++i) {
        Part &part = run.parts[i];
        if (part.failed >= 0) continue;
        visit(run, part, &t, measured);
        if (part.failed >= 0) continue;
        memcpy(scored + n_truth, part.y, (size_t)BLOCKS[part.block].ny * sizeof *scored);
        jump(SCORE.each, SCORE, &t, run.p_score, run.held, scored, part.score);
    }
}

static void step(Run &run, Part &part, const double *staged, double *stages) {
    const Block &block = BLOCKS[part.block];
    const double t = (double)run.k * run.h;
    double after[MAX_STATES];
    const double *arg[] = {&t, &run.h, part.x, part.p, run.held, staged};
    double *res[] = {after, stages};
    block.step(arg, res, 0, 0, 0);
    memcpy(part.x, after, (size_t)block.nx * sizeof *after);
    if (!all_finite(part.x, block.nx)) {
        part.failed = run.k + 1;
        for (part.cause = 0; isfinite(part.x[part.cause]);) ++part.cause;
    }
}

HILLOBS_EXPORT void hillobs_start(Run *run) {
    const double t = 0;
    double measured[N_STAGED] = {0};
    run->k = 0;
    draw_held(*run);
    for (int64_t i = 0; i < run->n_parts; ++i) {
        Part &part = run->parts[i];
        const Block &block = BLOCKS[part.block];
        const double *arg[] = {&t, part.p, run->held, measured};
        double *res[] = {part.x};
        block.init(arg, res, 0, 0, 0);
        part.failed = -1;
        if (i > 0) continue;
        double active[MAX_GUARDS], domain[MAX_GUARDS];
        const double *at[] = {&t, part.x, part.p, run->held, 0};
        double *out[] = {part.y, active, domain};
        block.out(at, out, 0, 0, 0);
        for (int j = 0; j < N_STAGED; ++j) measured[j] = part.y[STAGED[j]];
    }
}

// Grid points up to, not including, `until`; the run is over at steps + 1.
HILLOBS_EXPORT void hillobs_advance(Run *run, int64_t until) {
    for (; run->k < until && run->k <= run->steps; ++run->k) {
        visit_all(*run);
        double stages[4 * N_STAGED];
        Part &truth = run->parts[0];
        if (truth.failed < 0 && run->k < run->steps) {
            step(*run, truth, 0, stages);
            for (int64_t i = 1; i < run->n_parts; ++i)
                if (run->parts[i].failed < 0) step(*run, run->parts[i], stages, 0);
        }
        if (truth.failed >= 0) {
            run->k = run->steps;  // nothing can be known about a truth that is not there
        }
    }
}

// Sizes as compiled, so that the caller can compare them with what it believes.
HILLOBS_EXPORT void hillobs_sizes(int64_t *sizes) {
    *sizes++ = (int64_t)sizeof(Run);
    *sizes++ = (int64_t)sizeof(Part);
    for (const Block &block : BLOCKS) {
        *sizes++ = block.nx;
        *sizes++ = block.ny;
        *sizes++ = block.n_guards;
        *sizes++ = block.n_domain;
    }
}
