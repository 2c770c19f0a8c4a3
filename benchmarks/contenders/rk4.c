// RK4 around a function that CasADi exported: ẋ = f(t, x, p, w).
int F(const double **arg, double **res, long long *iw, double *w, int mem);

static void rates(double t, const double *x, const double *p, const double *noise, double *dx) {
    const double *arg[] = {&t, x, p, noise};
    double *res[] = {dx};
    F(arg, res, 0, 0, 0);
}

void march(double *x, const double *p, const double *noise, double h, long steps, long hold) {
    double k1[STATES], k2[STATES], k3[STATES], k4[STATES], s[STATES];
    for (long k = 0; k < steps; ++k) {
        const double t = k * h, *w = noise + k / hold * CHANNELS;
        rates(t, x, p, w, k1);
        for (int i = 0; i < STATES; ++i) s[i] = x[i] + h / 2 * k1[i];
        rates(t + h / 2, s, p, w, k2);
        for (int i = 0; i < STATES; ++i) s[i] = x[i] + h / 2 * k2[i];
        rates(t + h / 2, s, p, w, k3);
        for (int i = 0; i < STATES; ++i) s[i] = x[i] + h * k3[i];
        rates(t + h, s, p, w, k4);
        for (int i = 0; i < STATES; ++i) x[i] += h / 6 * (k1[i] + 2 * k2[i] + 2 * k3[i] + k4[i]);
    }
}
