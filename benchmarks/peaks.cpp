// What this core can do at most: chains of operations that do not wait for each other, in the widest registers.
#include <stdint.h>

#if defined __AVX512F__
enum { BYTES = 64, CHAINS = 24 };
#elif defined __AVX__
enum { BYTES = 32, CHAINS = 12 };  // 16 registers
#elif defined __ARM_NEON
enum { BYTES = 16, CHAINS = 24 };
#else
enum { BYTES = 16, CHAINS = 12 };
#endif
enum { WIDTH = BYTES / 8 };
typedef double Reals __attribute__((vector_size(BYTES)));

#define EXPORT extern "C" __attribute__((visibility("default"), noinline))

// n times `change` of every chain; returns operations done, numbers times flops of each
#define MEASURED(name, flops, change)                                            \
    EXPORT double name(int64_t n, double start, double factor, double *result) { \
        Reals a[CHAINS], b = factor - Reals{}, c = start - Reals{};              \
        for (int i = 0; i < CHAINS; ++i) a[i] = start + i - Reals{};             \
        for (int64_t k = 0; k < n; ++k) {                                        \
            _Pragma("GCC unroll 64") for (int i = 0; i < CHAINS; ++i) { change; } \
        }                                                                        \
        for (int i = 1; i < CHAINS; ++i) a[0] += a[i];                           \
        *result = a[0][0] + b[0] + c[0];                                         \
        return (double)n * CHAINS * WIDTH * flops;                               \
    }

static inline __attribute__((always_inline)) Reals root(Reals x) {
    Reals r;
    for (int j = 0; j < WIDTH; ++j) r[j] = __builtin_sqrt(x[j]);
    return r;
}

MEASURED(multiply_add, 2, a[i] = a[i] * b + c)
MEASURED(divide, 1, a[i] = c / a[i])
MEASURED(square_root, 1, a[i] = root(a[i]))
