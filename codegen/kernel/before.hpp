// What the generated functions are made of.
HILLOBS_EXPORT int hillobs_abi(void) { return HILLOBS_ABI; }

#define casadi_real V
#define casadi_int long long int
#ifndef __STDC_VERSION__
#define __STDC_VERSION__ 201112L  // or CasADi's helpers compare numbers where they could call fmin and fmax
#endif

// CasADi leaves what a function does not need unused
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wunused-function"
