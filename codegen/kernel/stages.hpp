// A step of RK4 out of its stages, where one function for all four would be too large for a compiler.

// k_i = f(t + c_i h, x + c_i h k_{i−1}),  x⁺ = x + h Σ b_i k_i; B::stage gives h k_i
template <class B>
static __attribute__((noinline)) void by_stages(const V *t, const V *c, const V *x, const V *held, const V *staged,
                                                V *x_next, V *stages) {
    V at[B::NX + 1], dx[B::NX + 1], seen[B::N_SEEN_AT_STAGE + 1];
    for (int j = 0; j < B::NX; ++j) x_next[j] = at[j] = x[j];
    for (int i = 0; i < 4; ++i) {
        const V node = NODES[i];
        for (int j = 0; i > 0 && j < B::NX; ++j) at[j] = x[j] + NODES[i] * dx[j];
        B::stage(t, &node, c, at, held, staged + i * B::N_AT_STAGE, dx, seen);
        for (int j = 0; j < B::NX; ++j) x_next[j] = x_next[j] + WEIGHTS[i] * dx[j];
        for (int j = 0; j < B::N_SEEN_AT_STAGE; ++j) stages[i * B::N_SEEN_AT_STAGE + j] = seen[j];
    }
}
