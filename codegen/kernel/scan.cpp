// A generated function carried from row to row of a recording: (p, carry, rows …) → (carry, result).

// All arrays are the caller's. Row i of the r-th table begins at rows[r] + i · (its width).
struct Scan {
    const double *p;
    double *carry;
    const double *const *rows;
    double *results;  // n × (width of the result)
    int64_t n, backwards;
    int64_t window;  // of a pass backwards: rows ahead, from which each row is reached anew; 0: all
};

INLINE void put(const double *from, int n, V *to) {
    for (int i = 0; i < n; ++i) to[i] = from[i];
}

HILLOBS_EXPORT int hillobs_scan(int64_t index, Scan *s) {
    const Function &f = FUNCTIONS[index];
    const int carried = f.in[1], told = f.out[1];
    const V *arg[MAX_ARGUMENTS];
    V *res[MAX_ARGUMENTS], numbers[MAX_NUMBERS], work[MAX_WORK], *place[MAX_ARGUMENTS], *next = numbers;
    casadi_int whole[MAX_WORK];
    for (int i = 0; i < f.n_in; ++i) { arg[i] = place[i] = next; next += f.in[i]; }
    for (int i = 0; i < f.n_out; ++i) { res[i] = next; next += f.out[i]; }
    put(s->p, f.in[0], place[0]);
    put(s->carry, carried, place[1]);
    for (int64_t k = 0; k < s->n; ++k) {
        // each row once, or from the end of its window back to it
        const int64_t last = s->backwards && !s->window ? s->n - 1 - k : k, end = last + s->window;
        if (s->window) put(s->carry, carried, place[1]);
        for (int64_t row = end < s->n ? end : s->n - 1; row >= last; --row) {
            for (int r = 2; r < f.n_in; ++r) put(s->rows[r - 2] + row * f.in[r], f.in[r], place[r]);
            if (int status = f.evaluate(arg, res, whole, work, 0)) return status;
            for (int i = 0; i < carried; ++i) place[1][i] = res[0][i];
        }
        for (int i = 0; i < told; ++i) s->results[last * told + i] = lane(res[1][i], 0);
    }
    if (!s->window)
        for (int i = 0; i < carried; ++i) s->carry[i] = lane(place[1][i], 0);
    return 0;
}
