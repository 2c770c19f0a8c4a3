// exp, sin, cos of all lanes by the same operations, so that no libm decides their bits; the rest lane by lane.

// adding and taking away 1.5·2⁵² rounds to a whole number, which is then in the last bits
static const double ROUNDER = 6755399441055744.0;

// 2ⁿ, −1022 ≤ n ≤ 1023; the shift is one without a sign, which is defined for any n
INLINE Reals power_of_two(Wholes n) { return real((Wholes)((Bits)(n + 1023) << 52)); }

// e^x = 2ⁿ e^r, |r| ≤ ln 2/2; ≤ 2 ulp
INLINE Reals exp_of(Reals x) {
    x = pick(x > all(710), all(710), pick(x < all(-746), all(-746), x));
    const Reals shifted = x * 1.4426950408889634 + ROUNDER, n = shifted - ROUNDER;
    const Reals r = (x - n * 6.93147180369123816490e-01) - n * 1.90821492927058770002e-10;
    Reals e = all(1 / 6227020800.0);
    const double inverse_factorials[] = {1 / 479001600.0, 1 / 39916800.0, 1 / 3628800.0, 1 / 362880.0, 1 / 40320.0,
                                         1 / 5040.0, 1 / 720.0, 1 / 120.0, 1 / 24.0, 1 / 6.0, 0.5};
    for (double c : inverse_factorials) e = e * r + c;
    e = (e * r * r + r) + 1.0;
    // 2ⁿ in two factors: n may be below −1022 or 1024; of NaN it is any number
    const Wholes whole = bits(shifted) - bits(all(ROUNDER)), half = whole >> 1;
    return e * power_of_two(half) * power_of_two(whole - half);
}

// sin (shift 0) and cos (shift 1): x = n π/2 + r, |r| ≤ π/4, for |x| ≤ 10⁵; ≤ 2 ulp of the larger of the two
INLINE Reals sine_of(Reals x, int64_t shift) {
    const Reals shifted = x * 6.36619772367581382433e-01 + ROUNDER, n = shifted - ROUNDER;
    const Reals r = ((x - n * 1.57079632673412561417e+00) - n * 6.07710050630396597660e-11) - n * 2.02226624879595063154e-21;
    const Reals z = r * r;
    // fdlibm's minimax polynomials on ±π/4
    Reals s = all(1.58969099521155010221e-10), c = all(-1.13596475577881948265e-11);
    const double sines[] = {-2.50507602534068634195e-08, 2.75573137070700676789e-06, -1.98412698298579493134e-04,
                            8.33333333332248946124e-03, -1.66666666666666324348e-01};
    const double cosines[] = {2.08757232129817482790e-09, -2.75573143513906633035e-07, 2.48015872894767294178e-05,
                              -1.38888888888741095749e-03, 4.16666666666666019037e-02};
    for (double a : sines) s = s * z + a;
    for (double a : cosines) c = c * z + a;
    s = s * z * r + r;
    c = (c * z - 0.5) * z + 1.0;  // one way to fuse products and sums, the same for one lane and for many
    const Wholes quadrant = bits(shifted) + shift;
    const Reals value = pick((quadrant & 1) != 0, c, s);
    return pick((quadrant & 2) != 0, -value, value);
}

// the reduction of a larger angle is not exact
static const double LARGEST_ANGLE = 1e5;

#define LANE_BY_LANE(f, x)                                       \
    V r;                                                         \
    for (int l = 0; l < LANES; ++l) set_lane(r, l, f(lane(x, l))); \
    return r

static __attribute__((noinline)) V far_sin(V x) { LANE_BY_LANE(sin, x); }
static __attribute__((noinline)) V far_cos(V x) { LANE_BY_LANE(cos, x); }

UNARY(exp, exp_of(a))

UNARY(near_sin, sine_of(a, 0))
UNARY(near_cos, sine_of(a, 1))

INLINE V sin(V x) {
    const V far = V(LARGEST_ANGLE) < fabs(x);
    const V near = near_sin(x);
    return any(far) ? select(far, far_sin(x), near) : near;
}

INLINE V cos(V x) {
    const V far = V(LARGEST_ANGLE) < fabs(x);
    const V near = near_cos(x);
    return any(far) ? select(far, far_cos(x), near) : near;
}

INLINE V sqrt(V x) {
    V r;
    for (int i = 0; i < GROUPS; ++i)
        for (int j = 0; j < WIDTH; ++j) set_lane(r, i * WIDTH + j, __builtin_sqrt(lane(x, i * WIDTH + j)));
    return r;
}

#define LIBM(f) \
    INLINE V f(V x) { LANE_BY_LANE(::f, x); }
#define LIBM2(f)                                                                  \
    INLINE V f(V x, V y) {                                                        \
        V r;                                                                      \
        for (int l = 0; l < LANES; ++l) set_lane(r, l, ::f(lane(x, l), lane(y, l))); \
        return r;                                                                 \
    }

LIBM(tan) LIBM(asin) LIBM(acos) LIBM(atan) LIBM(sinh) LIBM(cosh) LIBM(tanh) LIBM(asinh) LIBM(acosh) LIBM(atanh)
LIBM(log) LIBM(log1p) LIBM(expm1) LIBM(floor) LIBM(ceil) LIBM(erf)
LIBM2(pow) LIBM2(atan2) LIBM2(fmod) LIBM2(hypot) LIBM2(copysign)
