/* A study that is run again and again with other numbers. No observer acts back on the truth, so what has not changed is
 * not computed again.
 */

function runnerOf(study, f, m, places) {
  const { blocks, roles } = study;
  const passes = passesOf(study, f, m, places);
  const failures = {};
  // pass → the numbers that it was made with
  const made = new Map();
  // observer → the one whose front it shares, itself mostly
  const sharing = new Map();

  const same = (one, other) => one.length === other.length && one.every((number, i) => Object.is(number, other[i]));

  /** Whether a pass must be made again, since it was made with other numbers. */
  function outdated(pass, numbers) {
    if (made.has(pass) && same(made.get(pass), numbers)) return false;
    made.set(pass, numbers);
    return true;
  }

  /** The first rule that numbers break, in words; an empty text if none is broken. */
  function broken(value) {
    m.set(study.ruled.map(value), places.ruled);
    f.sides(places.ruled, places.sides);
    const holds = (i) => m[places.sides + 2 * i] < m[places.sides + 2 * i + 1];
    return study.rules.find((_, i) => !holds(i)) ?? "";
  }

  /** Runs what has changed: `value` tells the number at a path; steps are so many `times` as large. */
  function run(value, seed, times) {
    const numbers = (name) => study.paths[name].map(value);
    passes.coarsen(times);
    const moved = outdated("truth", [times, ...numbers(roles.truth)]);
    if (moved) failures.truth = passes.move(numbers(roles.truth));
    const measured = outdated("sensors", [times, seed, ...numbers(roles.sensors)]) || moved;
    if (measured) passes.measure(numbers(roles.sensors), seed);
    const rated = outdated("score", [times, ...numbers(roles.score)]);
    if (rated) passes.prepare(roles.score, numbers(roles.score));
    const fronts = [];
    for (const name of Object.keys(study.observers)) {
      const p = numbers(name);
      const front = frontOf(name, p, measured, fronts);
      const another = sharing.get(name) !== front.owner;
      sharing.set(name, front.owner);
      if (outdated(name, p) || another || front.renewed || rated)
        failures[name] = passes.observe(name, p, places.of[front.owner].staged, failures.truth);
    }
  }

  /** What an observer sees, among `fronts`: that of another one with the same numbers, or its own. */
  function frontOf(name, p, measured, fronts) {
    const numbers = blocks[roles.front].p.map((number) => p[blocks[name].p.indexOf(number)]);
    const shared = fronts.find((front) => same(front.numbers, numbers));
    const pass = `front of ${name}`;
    if (shared) {
      made.delete(pass);
      return shared;
    }
    const own = { owner: name, numbers, renewed: outdated(pass, numbers) || measured };
    if (own.renewed) passes.look(numbers, places.of[name]);
    fronts.push(own);
    return own;
  }

  /** A view of what was kept of an output for the charts. */
  const series = (begin, output) =>
    m.subarray(begin + output * passes.points(), begin + (output + 1) * passes.points());

  /** A measure of a quantity, as the table shows it. */
  function measure(observer, name, quantity) {
    const row = Object.keys(study.measures).indexOf(name);
    return m[places.of[observer].measures + row * study.quantities.length + quantity];
  }

  return {
    run,
    broken,
    failures,
    measure,
    times: passes.times,
    truth: (name) => series(places.kept, blocks[roles.truth].y.indexOf(name)),
    estimate: (observer, name) => series(places.of[observer].kept, blocks[observer].y.indexOf(`${name}_hat`)),
  };
}
