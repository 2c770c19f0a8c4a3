// Philox4x32-10 (Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011), all lanes at once.
// The noise of a run depends on (seed, channel, sample) alone, so any order, any step and any lane give the same numbers.
struct Words {
    uint64_t w[4][LANES];  // 32 bits of each
};

static inline void philox(Words &counter, uint64_t *key0, uint64_t *key1) {
    const uint64_t low = 0xFFFFFFFFull;
    for (int round = 0; round < 10; ++round)
        for (int l = 0; l < LANES; ++l) {
            const uint64_t a = 0xD2511F53ull * counter.w[0][l], b = 0xCD9E8D57ull * counter.w[2][l];
            counter.w[0][l] = (b >> 32) ^ counter.w[1][l] ^ key0[l];
            counter.w[1][l] = b & low;
            counter.w[2][l] = (a >> 32) ^ counter.w[3][l] ^ key1[l];
            counter.w[3][l] = a & low;
            key0[l] = (key0[l] + 0x9E3779B9ull) & low;
            key1[l] = (key1[l] + 0xBB67AE85ull) & low;
        }
}

// Uniform in (−1, 1]: U = 2((w₀ ≫ 5)·2²⁶ + (w₁ ≫ 6) + ½)/2⁵³ − 1
static __attribute__((noinline)) void noise(const uint64_t *seeds, uint64_t channel, uint64_t sample, V *value) {
    Words words = {};
    uint64_t key0[LANES], key1[LANES];
    for (int l = 0; l < LANES; ++l) {
        words.w[0][l] = sample & 0xFFFFFFFFull;
        words.w[1][l] = channel;
        key0[l] = seeds[l] & 0xFFFFFFFFull;
        key1[l] = seeds[l] >> 32;
    }
    philox(words, key0, key1);
    for (int l = 0; l < LANES; ++l) {
        const double high = (double)(int32_t)(words.w[0][l] >> 5), rest = (double)(int32_t)(words.w[1][l] >> 6);
        set_lane(*value, l, 2.0 * (high * 67108864.0 + rest + 0.5) / 9007199254740992.0 - 1.0);
    }
}

HILLOBS_EXPORT void hillobs_philox(const uint32_t *counter, const uint32_t *key, uint32_t *result) {
    Words words = {};
    uint64_t key0[LANES] = {key[0]}, key1[LANES] = {key[1]};
    for (int i = 0; i < 4; ++i) words.w[i][0] = counter[i];
    philox(words, key0, key1);
    for (int i = 0; i < 4; ++i) result[i] = (uint32_t)words.w[i][0];
}

HILLOBS_EXPORT void hillobs_noise(uint64_t seed, uint32_t channel, uint32_t first, int64_t n, double *values) {
    uint64_t seeds[LANES];
    for (int l = 0; l < LANES; ++l) seeds[l] = seed;
    for (int64_t i = 0; i < n; ++i) {
        V value;
        noise(seeds, channel, first + (uint32_t)i, &value);
        values[i] = lane(value, 0);
    }
}
