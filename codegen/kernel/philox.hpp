// Philox4x32-10 (Salmon, Moraes, Dror, Shaw, "Parallel random numbers: as easy as 1, 2, 3", SC 2011).
// The noise of a run depends on (seed, channel, sample) alone, so any order and any step give the same numbers.
struct Words {
    uint32_t w[4];
};

static Words philox(Words counter, uint32_t key0, uint32_t key1) {
    for (int round = 0; round < 10; ++round) {
        const uint64_t a = 0xD2511F53ull * counter.w[0], b = 0xCD9E8D57ull * counter.w[2];
        counter = {{(uint32_t)(b >> 32) ^ counter.w[1] ^ key0, (uint32_t)b,
                    (uint32_t)(a >> 32) ^ counter.w[3] ^ key1, (uint32_t)a}};
        key0 += 0x9E3779B9u;
        key1 += 0xBB67AE85u;
    }
    return counter;
}

// Uniform in (−1, 1]: U = 2((w₀ ≫ 5)·2²⁶ + (w₁ ≫ 6) + ½)/2⁵³ − 1
static double noise(uint64_t seed, uint32_t channel, uint32_t sample) {
    const Words words = philox({{sample, channel, 0, 0}}, (uint32_t)seed, (uint32_t)(seed >> 32));
    const double high = (double)(words.w[0] >> 5), low = (double)(words.w[1] >> 6);
    return 2.0 * (high * 67108864.0 + low + 0.5) / 9007199254740992.0 - 1.0;
}

HILLOBS_EXPORT void hillobs_philox(const uint32_t *counter, const uint32_t *key, uint32_t *words) {
    const Words result = philox({{counter[0], counter[1], counter[2], counter[3]}}, key[0], key[1]);
    memcpy(words, result.w, sizeof result.w);
}

HILLOBS_EXPORT void hillobs_noise(uint64_t seed, uint32_t channel, uint32_t first, int64_t n, double *values) {
    for (int64_t i = 0; i < n; ++i) values[i] = noise(seed, channel, first + (uint32_t)i);
}
