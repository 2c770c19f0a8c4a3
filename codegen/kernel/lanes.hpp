// A number of several runs at once: the C that CasADi writes is compiled with V in the place of double.
#include <math.h>
#include <stdint.h>
#include <string.h>

#define HILLOBS_EXPORT extern "C" __attribute__((visibility("default")))
#define INLINE static inline __attribute__((always_inline))

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

// One register: so many numbers, and whole numbers or masks of the same width.
#if HILLOBS_BYTES == 8
enum { GROUPS = 1 };
typedef double Reals;
typedef int64_t Wholes;
typedef bool Mask;
INLINE Wholes bits(Reals x) { Wholes n; memcpy(&n, &x, sizeof n); return n; }
INLINE Reals real(Wholes n) { Reals x; memcpy(&x, &n, sizeof x); return x; }
#else
enum { GROUPS = 2 };  // one register per value leaves the latencies uncovered, four spill
typedef double Reals __attribute__((vector_size(HILLOBS_BYTES)));
typedef int64_t Wholes __attribute__((vector_size(HILLOBS_BYTES)));
typedef Wholes Mask;
INLINE Wholes bits(Reals x) { return (Wholes)x; }
INLINE Reals real(Wholes n) { return (Reals)n; }
#endif

enum { WIDTH = HILLOBS_BYTES / 8, LANES = GROUPS * WIDTH };

INLINE Reals all(double x) { return x - Reals{}; }
INLINE Reals pick(Mask mask, Reals yes, Reals no) { return mask ? yes : no; }
INLINE Reals magnitude(Reals x) { return real(bits(x) & INT64_MAX); }

struct V {
    Reals v[GROUPS];
    V() {}
    __attribute__((always_inline)) V(double x) {
        for (int i = 0; i < GROUPS; ++i) v[i] = all(x);
    }
};

INLINE double lane(const V &x, int l) {
    double value;
    memcpy(&value, (const char *)&x + 8 * l, sizeof value);
    return value;
}

INLINE void set_lane(V &x, int l, double value) { memcpy((char *)&x + 8 * l, &value, sizeof value); }

#define EACH(expression)                              \
    V r;                                              \
    for (int i = 0; i < GROUPS; ++i) r.v[i] = expression; \
    return r

INLINE V operator+(V a, V b) { EACH(a.v[i] + b.v[i]); }
INLINE V operator-(V a, V b) { EACH(a.v[i] - b.v[i]); }
INLINE V operator*(V a, V b) { EACH(a.v[i] * b.v[i]); }
INLINE V operator/(V a, V b) { EACH(a.v[i] / b.v[i]); }
INLINE V operator-(V a) { EACH(-a.v[i]); }
// a comparison is 1 or 0, as in C
INLINE V operator<(V a, V b) { EACH(pick(a.v[i] < b.v[i], all(1), all(0))); }
INLINE V operator<=(V a, V b) { EACH(pick(a.v[i] <= b.v[i], all(1), all(0))); }
INLINE V operator==(V a, V b) { EACH(pick(a.v[i] == b.v[i], all(1), all(0))); }
INLINE V operator!=(V a, V b) { EACH(pick(a.v[i] != b.v[i], all(1), all(0))); }
INLINE V operator!(V a) { return a == 0.0; }
INLINE V operator&&(V a, V b) { return (a != 0.0) * (b != 0.0); }
INLINE V operator||(V a, V b) { return !(!a && !b); }
// a first argument that is no number stays visible
INLINE V fmax(V a, V b) { EACH(pick(b.v[i] > a.v[i], b.v[i], a.v[i])); }
INLINE V fmin(V a, V b) { EACH(pick(b.v[i] < a.v[i], b.v[i], a.v[i])); }
INLINE V fabs(V a) { EACH(magnitude(a.v[i])); }

// where `mask` is not 0: yes, elsewhere no, whatever it is
INLINE V select(V mask, V yes, V no) { EACH(pick(mask.v[i] != all(0), yes.v[i], no.v[i])); }
// is it other than 0 in any lane?
INLINE bool any(V mask) {
    int64_t found = 0;
    for (int i = 0; i < GROUPS; ++i)
        for (int j = 0; j < WIDTH; ++j) found |= (int64_t)(lane(mask, i * WIDTH + j) != 0);
    return found != 0;
}
