// What the generated functions are made of, and the tables that describe them.
#include <math.h>
#include <stdint.h>
#include <string.h>

typedef double real;

#define casadi_real real
#define casadi_int long long int
#define CASADI_SYMBOL_EXPORT static
#define HILLOBS_EXPORT extern "C" __attribute__((visibility("default")))

HILLOBS_EXPORT int hillobs_abi(void) { return HILLOBS_ABI; }

typedef int (*Evaluate)(const real **arg, real **res, casadi_int *iw, real *w, int mem);

// One generated function; sizes count the numbers of each argument and result.
struct Function {
    const char *name;
    Evaluate evaluate;
    int n_in, n_out;
    const int *in, *out;
};

// A Block as functions; a role that it does not have is null.
struct Block {
    const char *name;
    int nx, ny, n_guards, n_domain;
    Evaluate init, step, sample, each, out;
};

// CasADi leaves what a function does not need unused
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wunused-function"
