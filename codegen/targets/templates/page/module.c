#define CASADI_SYMBOL_EXPORT static inline

#define NAN __builtin_nan("")
#define INFINITY __builtin_inf()

/* one instruction each */
#define sqrt __builtin_sqrt
#define fabs __builtin_fabs
#define floor __builtin_floor
#define ceil __builtin_ceil
#define fmax __builtin_wasm_max_f64
#define fmin __builtin_wasm_min_f64

/* from the page */
double acos(double), acosh(double), asin(double), asinh(double), atan(double), atan2(double, double), atanh(double),
    cos(double), cosh(double), exp(double), expm1(double), hypot(double, double), log(double), log1p(double),
    pow(double, double), sin(double), sinh(double), tan(double), tanh(double);

$code

/* arguments and results are places in memory, counted in doubles; none is at 0 */
#define AT(place) ((double *)(8 * (place)))
#define GIVEN(place) do { if (!(place)) __builtin_unreachable(); } while (0)
#define EXPORTED(name) __attribute__((export_name(name)))

$functions
