// Any generated function at many points: the arguments of a point lie one after the other, so do its results.
HILLOBS_EXPORT int hillobs_call(int64_t index, int64_t points, const double *in, double *out) {
    const Function &function = FUNCTIONS[index];
    const real *arg[MAX_ARGUMENTS];
    real *res[MAX_ARGUMENTS], w[MAX_WORK];
    casadi_int iw[MAX_WORK];
    for (int64_t point = 0; point < points; ++point) {
        for (int i = 0; i < function.n_in; ++i) { arg[i] = in; in += function.in[i]; }
        for (int i = 0; i < function.n_out; ++i) { res[i] = out; out += function.out[i]; }
        if (int status = function.evaluate(arg, res, iw, w, 0)) return status;
    }
    return 0;
}
