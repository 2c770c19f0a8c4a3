/* The closed loop of a study over one array of numbers `m`, pass by pass: first the truth, then what the sensors show of
 * it, then each observer with its score. No observer acts back, so what has not changed is not computed again.
 *
 * All equations are functions of CasADi; here is only what they are given, in the order of the studies' own kernel. What
 * is called a place is one in `m`.
 */

/** The places of all arrays, from `begin` on; `end` is behind them. */
function arranged(study, begin) {
  let end = begin;
  const room = (size) => (end += size) - size;
  const { blocks, grid, roles, stages } = study;
  const points = grid.steps + 1, kept = grid.steps / grid.record + 1;
  const [truth, sensors, front, near, score] = ["truth", "sensors", "front", "near", "score"].map((role) => blocks[roles[role]]);
  const part = (block) => ({
    p: room(block.p.length), c: room(block.constants), x: room(block.x.length), moved: room(block.x.length),
    at: room(block.x.length), dx: room(block.x.length), node: room(1),
    y: room(block.y.length), domain: room(block.domain.length), scales: room(block.x.length + block.y.length),
  });
  const of = Object.fromEntries(Object.entries(blocks).map(([name, block]) => [name, part(block)]));
  for (const name of Object.keys(study.observers))
    Object.assign(of[name], {
      front: part(front), near: near && part(near), staged: room(points * stages * (sensors.y.length + front.y.length)),
      sums: room(score.x.length), summed: room(score.x.length), kept: room(kept * blocks[name].y.length),
      measures: room(Object.keys(study.measures).length * study.quantities.length),
    });
  const widest = Math.max(...Object.keys(study.observers).map((name) => blocks[name].y.length));
  return {
    of, ruled: room(study.ruled.length), sides: room(2 * study.rules.length), t: room(1), h: room(1), steps: room(1), window: room(1), held: room(study.held), nothing: room(1),
    noise: room(points * study.noise), seen: room(points * stages * study.seen), true: room(points * truth.y.length),
    measured: room(points * stages * sensors.y.length), scored: room(truth.y.length + widest), kept: room(kept * truth.y.length),
    end,
  };
}

/** A study that can be run again and again with other numbers, by functions `f` over the array `m`. */
function runnable(study, f, m, places) {
  const { blocks, roles, stages, nodes, weights } = study;
  const [truth, sensors, front, score] = ["truth", "sensors", "front", "score"].map((role) => blocks[roles[role]]);
  const nTruth = truth.y.length, nMeasured = sensors.y.length, nFront = front.y.length, nStaged = nMeasured + nFront;
  const names = Object.keys(study.observers);
  const failures = {}, computedWith = {}, sight = {};
  let grid = study.grid;

  const copy = (from, size, to) => { for (let i = 0; i < size; ++i) m[to + i] = m[from + i]; };
  const kept = () => grid.steps / grid.record + 1;
  const sampled = (k) => grid.hold > 0 && k % grid.hold === 0;

  /** Sets the time, and what is held over the step from k on. */
  function hold(k) {
    m[places.t] = k * grid.h;
    let place = places.held;
    for (let i = 0; i < study.noise; ++i) m[place++] = grid.hold ? m[places.noise + Math.floor(k / grid.hold) * study.noise + i] : 0;
    for (const [on, off] of grid.pulses) m[place++] = +(on <= k && k < off);
    m[place++] = +(k >= grid.window);
    m[place] = +sampled(k);
  }

  /** Sets what follows from the numbers `p` of a block alone. */
  function prepare(name, p, part = places.of[name]) {
    m.set(p, part.p);
    m[places.h] = grid.h;
    f[`${name}_constants`](places.h, part.p, part.c);
    f[`${name}_scales`](places.h, part.p, part.scales);
  }

  /** What is beyond its limit: the name of a state, an output or a limit; an empty one if all is well. */
  function beyond(block, x, part) {
    const nX = block.x.length, n = nX + block.y.length;
    for (let i = 0; i < n; ++i)
      if (!(Math.abs(m[i < nX ? x + i : part.y + i - nX]) * m[part.scales + i] <= 1)) return i < nX ? block.x[i] : block.y[i - nX];
    for (let i = 0; i < block.domain.length; ++i) if (!(m[part.domain + i] > 0)) return block.domain[i];
    return "";
  }

  /** Keeps outputs for the charts, if k is a point of theirs: output by output. */
  function keep(k, outputs, size, to) {
    if (k % grid.record === 0) for (let i = 0; i < size; ++i) m[to + i * kept() + k / grid.record] = m[outputs + i];
  }

  /** A step of RK4 by what a block's function of one stage tells, if that of a whole step would be too large. */
  function byStages(name) {
    const stage = f[`${name}_stage`], n = blocks[name].x.length, { at, dx, node } = places.of[name];
    return (t, c, x, held, staged, next, seen) => {
      copy(x, n, at);
      copy(x, n, next);
      for (let i = 0; i < stages; ++i) {
        // k_i = f(t + c_i h, x + c_i h k_{i−1}),  x⁺ = x + h Σ b_i k_i; the function tells h k_i
        m[node] = nodes[i];
        if (i) for (let j = 0; j < n; ++j) m[at + j] = m[x + j] + nodes[i] * m[dx + j];
        stage(t, node, c, at, held, staged + i * stagedOf(name), dx, seen + i * study.seen);
        for (let j = 0; j < n; ++j) m[next + j] += weights[i] * m[dx + j];
      }
    };
  }
  const stepOf = (name) => f[`${name}_step`] ?? byStages(name);
  const stagedOf = (name) => (name === roles.truth ? 0 : nStaged);

  /** What the truth does. Returns its failure, if there is one. */
  function move(p) {
    const name = roles.truth, part = places.of[name], step = stepOf(name), out = f[`${name}_out`];
    let { x, moved } = part;
    prepare(name, p);
    hold(0);
    m.fill(NaN, places.kept, places.kept + kept() * nTruth);
    f[`${name}_init`](places.t, part.p, places.held, places.nothing, x);
    for (let k = 0; k <= grid.steps; ++k) {
      const now = places.true + k * nTruth;
      hold(k);
      out(places.t, part.c, x, places.held, places.nothing, now, part.domain);
      copy(now, nTruth, part.y);
      const wrong = beyond(truth, x, part);
      if (wrong) return { k, time: k * grid.h, name: wrong };
      keep(k, now, nTruth, places.kept);
      step(places.t, part.c, x, places.held, places.nothing, moved, places.seen + k * stages * study.seen);
      [x, moved] = [moved, x];
    }
    return null;
  }

  /** What the sensors show of it at all stages. */
  function measure(p, seed) {
    const name = roles.sensors, part = places.of[name], out = f[`${name}_out`];
    prepare(name, p);
    for (let sample = 0; grid.hold && sample * grid.hold <= grid.steps; ++sample)
      for (let i = 0; i < study.noise; ++i) m[places.noise + sample * study.noise + i] = noise(seed, i, sample);
    for (let k = 0; k <= grid.steps; ++k) {
      hold(k);
      for (let i = 0; i < stages; ++i) {
        const stage = k * stages + i;
        m[places.t] = (k + nodes[i]) * grid.h;
        out(places.t, part.c, part.x, places.held, places.seen + stage * study.seen, places.measured + stage * nMeasured, part.domain);
      }
    }
  }

  /** What an observer's front makes of the measurements, before any state: at all stages. */
  function look(p, part) {
    const { near, staged } = part, full = f[`${roles.front}_out`], quick = f[`${roles.near}_out`];
    prepare(roles.front, p, part.front);
    if (near) prepare(roles.near, p, near);
    for (let k = 0; k <= grid.steps; ++k) {
      const here = staged + k * stages * nStaged;
      for (let i = 0; i < stages; ++i) copy(places.measured + (k * stages + i) * nMeasured, nMeasured, here + i * nStaged);
      // the quick one tells all stages at once, and whether it doubts that
      if (near) quick(places.t, near.c, near.x, places.held, here, near.y, near.domain);
      const sure = near && m[near.y + stages * nFront] === 0;
      for (let i = 0; i < stages; ++i) {
        const stage = here + i * nStaged;
        if (sure) copy(near.y + i * nFront, nFront, stage + nMeasured);
        else full(places.t, part.front.c, part.front.x, places.held, stage, stage + nMeasured, part.front.domain);
      }
    }
  }

  /** What an observer makes of what it sees, and its score. Returns its failure, if there is one. */
  function observe(name, p, staged) {
    const block = blocks[name], part = places.of[name], n = block.y.length, ofScore = places.of[roles.score];
    const step = stepOf(name), [out, jump, each] = ["out", "sample", "each"].map((role) => f[`${name}_${role}`]);
    const [account, accountOfSample] = ["each", "sample"].map((role) => f[`${roles.score}_${role}`]);
    let { x, moved, sums, summed } = part;
    prepare(name, p);
    hold(0);
    m.fill(NaN, part.kept, part.kept + kept() * n);
    m.fill(NaN, part.measures, part.measures + Object.keys(study.measures).length * study.quantities.length);
    m.fill(0, sums, sums + score.x.length);
    f[`${name}_init`](places.t, part.p, places.held, staged, x);
    // nothing is known of a truth that is not there
    const last = failures.truth ? failures.truth.k - 1 : grid.steps;
    for (let k = 0; k <= last; ++k) {
      const here = staged + k * stages * nStaged, atSample = sampled(k), counts = atSample || !block.sampled;
      if (!counts && k % grid.record) continue;
      hold(k);
      if (jump && atSample) jump(places.t, part.c, x, places.held, here, moved), ([x, moved] = [moved, x]);
      if (each) each(places.t, part.c, x, places.held, here, moved), ([x, moved] = [moved, x]);
      out(places.t, part.c, x, places.held, here, part.y, part.domain);
      const wrong = beyond(block, x, part);
      if (wrong) return { k, time: k * grid.h, name: wrong };
      keep(k, part.y, n, part.kept);
      if (counts) {
        copy(places.true + k * nTruth, nTruth, places.scored);
        copy(part.y, n, places.scored + nTruth);
        if (atSample) accountOfSample(places.t, ofScore.c, sums, places.held, places.scored, summed), ([sums, summed] = [summed, sums]);
        account(places.t, ofScore.c, sums, places.held, places.scored, summed);
        [sums, summed] = [summed, sums];
      }
      if (block.sampled || k === grid.steps) continue;
      step(places.t, part.c, x, places.held, here, moved, places.nothing);
      [x, moved] = [moved, x];
    }
    if (failures.truth) return null;
    // errors of what moves at samples only are counted there
    const every = block.sampled && grid.hold ? grid.hold : 1;
    m[places.h] = grid.h * every;
    m[places.steps] = Math.floor(grid.steps / every);
    m[places.window] = Math.ceil(grid.window / every);
    f.measures(sums, places.h, places.steps, places.window, part.measures);
    return null;
  }

  /** Whether a pass must be done again, since it was done with other numbers. */
  function outdated(pass, numbers) {
    const old = computedWith[pass];
    if (old && old.length === numbers.length && old.every((number, i) => Object.is(number, numbers[i]))) return false;
    computedWith[pass] = numbers;
    return true;
  }

  /** The first rule that numbers break, in words; an empty text if none is broken. */
  function broken(value) {
    m.set(study.ruled.map(value), places.ruled);
    f.sides(places.ruled, places.sides);
    return study.rules.find((_, i) => !(m[places.sides + 2 * i] < m[places.sides + 2 * i + 1])) ?? "";
  }

  /** Runs what has changed: `value` tells the number at a path; steps are so many times `coarser`. */
  function run(value, seed, coarser) {
    const whole = study.grid, about = [coarser, seed];
    grid = { ...whole, h: whole.h * coarser, pulses: whole.pulses.map((edges) => edges.map((edge) => edge / coarser)) };
    for (const name of ["steps", "record", "hold", "window"]) grid[name] = whole[name] / coarser;
    const numbers = (name) => study.paths[name].map(value);
    const later = outdated("truth", [coarser, ...numbers(roles.truth)]);
    if (later) failures.truth = move(numbers(roles.truth));
    const moved = outdated("sensors", [...about, ...numbers(roles.sensors)]) || later;
    if (moved) measure(numbers(roles.sensors), seed);
    const ofScore = outdated("score", [coarser, ...numbers(roles.score)]);
    if (ofScore) prepare(roles.score, numbers(roles.score));
    const looked = [];
    for (const name of names) {
      const p = numbers(name), ofFront = front.p.map((number) => p[blocks[name].p.indexOf(number)]);
      // observers with the same numbers share what they see
      const same = looked.find((other) => ofFront.every((number, i) => Object.is(number, other.ofFront[i])));
      const own = same ?? { name, ofFront, renewed: outdated(`${name}'s front`, ofFront) || moved };
      if (same) delete computedWith[`${name}'s front`];
      else {
        looked.push(own);
        if (own.renewed) look(ofFront, places.of[name]);
      }
      const other = sight[name] !== own.name;
      sight[name] = own.name;
      if (outdated(name, p) || own.renewed || other || ofScore) failures[name] = observe(name, p, places.of[own.name].staged);
    }
  }

  /** A view of what was kept of an output for the charts. */
  const series = (begin, output) => m.subarray(begin + output * kept(), begin + (output + 1) * kept());

  return {
    run, broken, failures,
    times: () => Float64Array.from({ length: kept() }, (_, i) => i * grid.record * grid.h),
    truth: (name) => series(places.kept, truth.y.indexOf(name)),
    estimate: (observer, name) => series(places.of[observer].kept, blocks[observer].y.indexOf(`${name}_hat`)),
    measure: (observer, measure, quantity) =>
      m[places.of[observer].measures + Object.keys(study.measures).indexOf(measure) * study.quantities.length + quantity],
  };
}
