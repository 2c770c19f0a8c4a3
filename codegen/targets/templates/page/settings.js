/* The numbers of a study as they are set on the page, and the link that carries them. */
function settingsOf(study) {
  const known = new Map(study.numbers.map((number) => [number.path, number]));
  const chosen = new Map();
  let seed = study.seed;

  /** The number at a path: chosen here, given by the scenario, or that of the path which it shares. */
  function value(path) {
    const own = chosen.get(path) ?? study.given[path];
    if (own !== undefined) return own;
    const shared = study.shared[path];
    return shared && shared !== path ? value(shared) : known.get(path).value;
  }

  /** What a number must be and is not, or an empty text. */
  function objection(path, number) {
    const { above, least, below, most, whole } = known.get(path);
    if (!Number.isFinite(number)) return "a number";
    if (above !== null && !(number > above)) return `above ${above}`;
    if (least !== null && !(number >= least)) return `at least ${least}`;
    if (below !== null && !(number < below)) return `below ${below}`;
    if (most !== null && !(number <= most)) return `at most ${most}`;
    return whole && !Number.isInteger(number) ? "a whole number" : "";
  }

  /** Sets a number, unless there is an objection, which is returned. */
  function set(path, number) {
    const wrong = objection(path, number);
    if (wrong) return wrong;
    if (number === known.get(path).value) chosen.delete(path);
    else chosen.set(path, number);
    return "";
  }

  const seedObjection = (number) => (Number.isSafeInteger(number) && number >= 0 ? "" : "a whole number, at least 0");

  /** The link's part behind #, with `more` words. */
  const link = (more) =>
    new URLSearchParams([...more, ...(seed === study.seed ? [] : [["seed", seed]]), ...chosen]).toString();

  /** Takes what a link carries; returns what it makes no sense of, and other words as they are. */
  function take(words) {
    const unknown = [],
      others = {};
    chosen.clear();
    seed = study.seed;
    for (const [name, text] of new URLSearchParams(words)) {
      const number = text.trim() === "" ? NaN : Number(text);
      if (name === "seed" && !seedObjection(number)) seed = number;
      else if (known.has(name) && !set(name, number)) continue;
      else if (known.has(name) || name === "seed") unknown.push(`${name}=${text}`);
      else others[name] = text;
    }
    return { unknown, others };
  }

  return {
    value,
    set,
    link,
    take,
    seedObjection,
    seed: () => seed,
    setSeed: (number) => {
      seed = number;
    },
    reset: () => {
      chosen.clear();
      seed = study.seed;
    },
    changed: (path) => chosen.has(path),
  };
}
