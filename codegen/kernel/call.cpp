// Any generated function at many points: the arguments of a point lie one after the other, so do its results.
static int total(const int *sizes, int n) {
    int sum = 0;
    for (int i = 0; i < n; ++i) sum += sizes[i];
    return sum;
}

HILLOBS_EXPORT int hillobs_call(int64_t index, int64_t points, const double *in, double *out) {
    const Function &function = FUNCTIONS[index];
    const int n_in = total(function.in, function.n_in), n_out = total(function.out, function.n_out);
    const V *arg[MAX_ARGUMENTS];
    V *res[MAX_ARGUMENTS], numbers[MAX_NUMBERS], work[MAX_WORK], *next = numbers;
    casadi_int whole[MAX_WORK];
    for (int i = 0; i < function.n_in; ++i) { arg[i] = next; next += function.in[i]; }
    for (int i = 0; i < function.n_out; ++i) { res[i] = next; next += function.out[i]; }
    for (int64_t first = 0; first < points; first += LANES) {
        const int64_t last = points - first - 1;  // the lanes beyond it repeat it
        for (int l = 0; l < LANES; ++l)
            for (int i = 0; i < n_in; ++i) set_lane(numbers[i], l, in[(first + (l < last ? l : last)) * n_in + i]);
        if (int status = function.evaluate(arg, res, whole, work, 0)) return status;
        for (int l = 0; l < LANES && l <= last; ++l)
            for (int i = 0; i < n_out; ++i) out[(first + l) * n_out + i] = lane(numbers[n_in + i], l);
    }
    return 0;
}
