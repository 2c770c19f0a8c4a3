typedef int (*Evaluate)(const V **arg, V **res, casadi_int *iw, V *w, int mem);

// One generated function; sizes count the numbers of each argument and result.
struct Function {
    Evaluate evaluate;
    int n_in, n_out;
    const int *in, *out;
};
