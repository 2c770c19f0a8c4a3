/* Philox4x32-10, as in the studies: the noise of (seed, channel, sample), so that a seed is the same run here and there. */
const noise = (() => {
  /** The upper 32 bits of a product of two whole numbers of 32 bits. */
  const high = (a, b) => {
    const a1 = a >>> 16,
      a0 = a & 0xffff,
      b1 = b >>> 16,
      b0 = b & 0xffff;
    const middle = a1 * b0 + ((a0 * b0) >>> 16);
    return (a1 * b1 + Math.floor(middle / 65536) + Math.floor(((middle % 65536) + a0 * b1) / 65536)) >>> 0;
  };
  /** Uniform in (−1, 1]. */
  return (seed, channel, sample) => {
    let w0 = sample >>> 0,
      w1 = channel,
      w2 = 0,
      w3 = 0,
      key0 = seed >>> 0,
      key1 = Math.floor(seed / 4294967296) >>> 0;
    for (let round = 0; round < 10; ++round) {
      const a0 = Math.imul(0xd2511f53, w0) >>> 0,
        a1 = high(0xd2511f53, w0);
      const b0 = Math.imul(0xcd9e8d57, w2) >>> 0,
        b1 = high(0xcd9e8d57, w2);
      [w0, w1, w2, w3] = [(b1 ^ w1 ^ key0) >>> 0, b0, (a1 ^ w3 ^ key1) >>> 0, a0];
      key0 = (key0 + 0x9e3779b9) >>> 0;
      key1 = (key1 + 0xbb67ae85) >>> 0;
    }
    // U = 2((w₀ ≫ 5)·2²⁶ + (w₁ ≫ 6) + ½)/2⁵³ − 1
    return (2 * ((w0 >>> 5) * 67108864 + (w1 >>> 6) + 0.5)) / 9007199254740992 - 1;
  };
})();
