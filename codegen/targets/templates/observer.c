/* $label: see $name.h. The functions are CasADi's, unchanged; the few lines behind them call these. */
#include "$name.h"

#include <math.h>
$mathematics
#define CASADI_SYMBOL_EXPORT static

#ifdef __GNUC__
#pragma GCC diagnostic push
/* CasADi gives all functions the same arguments, and describes them by others that nobody calls here */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#pragma GCC diagnostic ignored "-Wunused-function"
/* and constants as doubles, which become floats where they are assigned, and conditions as numbers */
#pragma GCC diagnostic ignored "-Wfloat-conversion"
#ifdef __clang__
#pragma GCC diagnostic ignored "-Wimplicit-float-conversion"
#endif
#endif

$code

#ifdef __GNUC__
#pragma GCC diagnostic pop
#endif

/* the structs are arrays to CasADi */
typedef char ${prefix}_check_state[sizeof(${prefix}_state) == $n_state * sizeof(${prefix}_real) ? 1 : -1];
typedef char ${prefix}_check_params[sizeof(${prefix}_params) == $n_params * sizeof(${prefix}_real) ? 1 : -1];
typedef char ${prefix}_check_input[sizeof(${prefix}_input) == $n_input * sizeof(${prefix}_real) ? 1 : -1];
typedef char ${prefix}_check_estimate[sizeof(${prefix}_estimate) == $n_estimate * sizeof(${prefix}_real) ? 1 : -1];

const ${prefix}_params ${prefix}_defaults = {
$defaults
};

/* Looks at the sample at which `from` arrives after so many periods, moved by `motion`, and keeps what comes of it if all is well. */
static int ${prefix}_keep(${prefix}_real periods, const ${prefix}_state *from, const ${prefix}_real *motion,
    ${prefix}_state *state, const ${prefix}_params *params, const ${prefix}_input *input, ${prefix}_estimate *estimate) {
    ${prefix}_state arrived;
    ${prefix}_estimate told;
    ${prefix}_real fine = 0, limited = 0;
    const ${prefix}_real *arg[$n_arg] = {&periods, (const ${prefix}_real *)params, (const ${prefix}_real *)from,
        (const ${prefix}_real *)input, motion};
    ${prefix}_real *res[$n_res] = {(${prefix}_real *)&arrived, (${prefix}_real *)&told, &fine, &limited};
    ${prefix}_arrive(arg, res, 0, 0, 0);
    if (!(fine > 0)) return ${PREFIX}_FAILED;
    *state = arrived;
    *estimate = told;
    return limited > 0 ? ${PREFIX}_LIMITED : ${PREFIX}_OK;
}

/* No motion yet. */
static void ${prefix}_rest(const ${prefix}_state *state, ${prefix}_real *motion) {
    const ${prefix}_real *arg[$n_arg] = {(const ${prefix}_real *)state};
    ${prefix}_real *res[$n_res] = {motion};
    ${prefix}_depart(arg, res, 0, 0, 0);
}

int ${prefix}_init(${prefix}_state *state, const ${prefix}_params *params, const ${prefix}_input *first,
    ${prefix}_estimate *estimate) {
    ${prefix}_state begun;
    ${prefix}_real motion[$n_motion];
    const ${prefix}_real *arg[$n_arg] = {(const ${prefix}_real *)params, (const ${prefix}_real *)first};
    ${prefix}_real *res[$n_res] = {(${prefix}_real *)&begun};
    ${prefix}_start(arg, res, 0, 0, 0);
    ${prefix}_rest(&begun, motion);
    return ${prefix}_keep(0, &begun, motion, state, params, first, estimate);
}

int ${prefix}_step(${prefix}_state *state, const ${prefix}_params *params, const ${prefix}_input *input,
    ${prefix}_estimate *estimate) {
    ${prefix}_real motion[2][$n_motion];
    int i = 0;
    ${prefix}_rest(state, motion[0]);
$advance    return ${prefix}_keep(1, state, motion[i % 2], state, params, input, estimate);
}
