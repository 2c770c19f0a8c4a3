// A number of several runs at once: the C that CasADi writes is compiled with V in the place of double.
#include <math.h>
#include <stdint.h>
#include <string.h>

#define HILLOBS_EXPORT extern "C" __attribute__((visibility("default")))
// no library uses all of these functions
#define INLINE static inline __attribute__((always_inline, unused))

#if defined HILLOBS_SCALAR
#define HILLOBS_BYTES 8
#elif defined __AVX512F__
#define HILLOBS_BYTES 64
#elif defined __AVX__
#define HILLOBS_BYTES 32
#elif defined __SSE2__ || defined __ARM_NEON
#define HILLOBS_BYTES 16
#else
#define HILLOBS_BYTES 8
#endif

// One register: WIDTH numbers, and whole numbers, with a sign or without, or masks of the same width.
#if HILLOBS_BYTES == 8
enum { GROUPS = 1 };
#define SECOND(...)
typedef double Reals;
typedef int64_t Wholes;
typedef uint64_t Bits;
typedef bool Mask;
INLINE Wholes bits(Reals x) { Wholes n; memcpy(&n, &x, sizeof n); return n; }
INLINE Reals real(Wholes n) { Reals x; memcpy(&x, &n, sizeof x); return x; }
#else
enum { GROUPS = 2 };  // one register per value leaves the latencies uncovered, four spill
#define SECOND(...) __VA_ARGS__
typedef double Reals __attribute__((vector_size(HILLOBS_BYTES)));
typedef int64_t Wholes __attribute__((vector_size(HILLOBS_BYTES)));
typedef uint64_t Bits __attribute__((vector_size(HILLOBS_BYTES)));
typedef Wholes Mask;
INLINE Wholes bits(Reals x) { return (Wholes)x; }
INLINE Reals real(Wholes n) { return (Reals)n; }
#endif

enum { WIDTH = HILLOBS_BYTES / 8, LANES = GROUPS * WIDTH };

INLINE Reals all(double x) { return x - Reals{}; }
INLINE Reals pick(Mask mask, Reals yes, Reals no) { return mask ? yes : no; }
INLINE Reals magnitude(Reals x) { return real(bits(x) & INT64_MAX); }

// b > a ? b : a and b < a ? b : a. The instruction is just that, for signed zeros and what is no number too; compilers
// make it of the words only where no operand is a constant.
#if HILLOBS_BYTES == 64 && !defined __clang__
INLINE Reals larger(Reals a, Reals b) { return __builtin_ia32_maxpd512_mask(b, a, a, 255, 4); }
INLINE Reals smaller(Reals a, Reals b) { return __builtin_ia32_minpd512_mask(b, a, a, 255, 4); }
#elif HILLOBS_BYTES == 64
INLINE Reals larger(Reals a, Reals b) { return __builtin_ia32_maxpd512(b, a, 4); }
INLINE Reals smaller(Reals a, Reals b) { return __builtin_ia32_minpd512(b, a, 4); }
#elif HILLOBS_BYTES == 32
INLINE Reals larger(Reals a, Reals b) { return __builtin_ia32_maxpd256(b, a); }
INLINE Reals smaller(Reals a, Reals b) { return __builtin_ia32_minpd256(b, a); }
#elif defined __SSE2__ && HILLOBS_BYTES == 16
INLINE Reals larger(Reals a, Reals b) { return __builtin_ia32_maxpd(b, a); }
INLINE Reals smaller(Reals a, Reals b) { return __builtin_ia32_minpd(b, a); }
#else
INLINE Reals larger(Reals a, Reals b) { return pick(b > a, b, a); }
INLINE Reals smaller(Reals a, Reals b) { return pick(b < a, b, a); }
#endif

// in any lane?
#if HILLOBS_BYTES == 64
typedef long long Longs __attribute__((vector_size(64)));  // what compilers call it here
INLINE bool some(Mask mask) { return __builtin_ia32_cmpq512_mask((Longs)mask, Longs{}, 4, 255) != 0; }
#elif HILLOBS_BYTES == 32
INLINE bool some(Mask mask) { return __builtin_ia32_movmskpd256((Reals)mask) != 0; }
#elif HILLOBS_BYTES == 16
INLINE bool some(Mask mask) { return (mask[0] | mask[1]) != 0; }
#else
INLINE bool some(Mask mask) { return mask; }
#endif

struct V {
    Reals low;
#if HILLOBS_BYTES > 8
    Reals high;
#endif
    V() {}
    __attribute__((always_inline)) V(double x) : low(all(x)) { SECOND(high = low;) }
};

INLINE double lane(const V &x, int l) {
    double value;
    memcpy(&value, (const char *)&x + 8 * l, sizeof value);
    return value;
}

INLINE void set_lane(V &x, int l, double value) { memcpy((char *)&x + 8 * l, &value, sizeof value); }

// Functions of V by what they do to the registers a, b, c of their arguments.
#define UNARY(name, result)                          \
    INLINE V name(V x) {                             \
        V r;                                         \
        { const Reals a = x.low; r.low = result; }   \
        SECOND({ const Reals a = x.high; r.high = result; }) \
        return r;                                    \
    }
#define BINARY(name, result)                                           \
    INLINE V name(V x, V y) {                                          \
        V r;                                                           \
        { const Reals a = x.low, b = y.low; r.low = result; }          \
        SECOND({ const Reals a = x.high, b = y.high; r.high = result; }) \
        return r;                                                      \
    }
#define TERNARY(name, result)                                                        \
    INLINE V name(V x, V y, V z) {                                                   \
        V r;                                                                         \
        { const Reals a = x.low, b = y.low, c = z.low; r.low = result; }             \
        SECOND({ const Reals a = x.high, b = y.high, c = z.high; r.high = result; }) \
        return r;                                                                    \
    }

BINARY(operator+, a + b)
BINARY(operator-, a - b)
BINARY(operator*, a * b)
#if defined HILLOBS_SLOW_DIVISION && HILLOBS_BYTES == 64
// a/b by one Newton step for 1/b and one for the quotient, ≤ 1 ulp, in a third of the divider's time
INLINE Reals quotient(Reals a, Reals b) {
    const Reals r0 = __builtin_ia32_rcp14pd512_mask(b, b, 255), r = r0 + r0 * (1.0 - b * r0);
    const Reals q0 = a * r, q = q0 + r * (a - b * q0);
    // zeros and infinities have no remainder; the first guess is exact for them
    return pick(q == q, q, a * r0);
}
#else
INLINE Reals quotient(Reals a, Reals b) { return a / b; }
#endif
BINARY(operator/, quotient(a, b))
UNARY(operator-, -a)
// a comparison is 1 or 0, as in C
BINARY(operator<, pick(a < b, all(1), all(0)))
BINARY(operator<=, pick(a <= b, all(1), all(0)))
BINARY(operator==, pick(a == b, all(1), all(0)))
BINARY(operator!=, pick(a != b, all(1), all(0)))
INLINE V operator!(V x) { return x == 0.0; }
INLINE V operator&&(V x, V y) { return (x != 0.0) * (y != 0.0); }
INLINE V operator||(V x, V y) { return !(!x && !y); }
// a first argument that is no number stays visible
BINARY(fmax, larger(a, b))
BINARY(fmin, smaller(a, b))
UNARY(fabs, magnitude(a))
// b where a is not 0, elsewhere c, whatever the other is
TERNARY(select, pick(a != all(0), b, c))

// is it other than 0 in any lane?
INLINE bool any(V x) {
    Mask found = x.low != all(0);
    SECOND(found |= x.high != all(0);)
    return some(found);
}

INLINE void given(const V *pointer) {
    if (!pointer) __builtin_unreachable();
}
INLINE void unused(const V *) {}
