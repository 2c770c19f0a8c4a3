/* The closed loop of a study, pass by pass: what the truth does, what the sensors show of it, what an observer makes of
 * that and how it scores. All equations are functions `f` of CasADi; here is what they are given, in the order of the
 * studies' own kernel.
 */

function passesOf(study, f, m, places) {
  const { blocks, roles, stages, nodes, weights } = study;
  const truth = blocks[roles.truth];
  const sensors = blocks[roles.sensors];
  const score = blocks[roles.score];
  const nTruth = truth.y.length;
  const nMeasured = sensors.y.length;
  const nFront = blocks[roles.front].y.length;
  const nStaged = nMeasured + nFront;
  let grid = study.grid;

  const points = () => grid.steps / grid.record + 1;
  const sampled = (k) => grid.hold > 0 && k % grid.hold === 0;

  function copy(from, size, to) {
    for (let i = 0; i < size; ++i) m[to + i] = m[from + i];
  }

  /** Sets the time, and what is held over the step from k on. */
  function hold(k) {
    const sample = grid.hold ? Math.floor(k / grid.hold) : 0;
    let place = places.held;
    m[places.t] = k * grid.h;
    for (let i = 0; i < study.noise; ++i) m[place++] = grid.hold ? m[places.noise + sample * study.noise + i] : 0;
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

  /** A block's step: its function, or RK4 of what it tells of one stage, where that of a whole step would be too large. */
  function stepOf(name) {
    const stage = f[`${name}_stage`];
    if (!stage) return f[`${name}_step`];
    const n = blocks[name].x.length;
    const size = name === roles.truth ? 0 : nStaged;
    const { at, dx, node } = places.of[name];
    return (t, c, x, held, staged, next, seen) => {
      copy(x, n, at);
      copy(x, n, next);
      for (let i = 0; i < stages; ++i) {
        // k_i = f(t + c_i h, x + c_i h k_{i−1}),  x⁺ = x + h Σ b_i k_i; the function tells h k_i
        m[node] = nodes[i];
        if (i > 0) for (let j = 0; j < n; ++j) m[at + j] = m[x + j] + nodes[i] * m[dx + j];
        stage(t, node, c, at, held, staged + i * size, dx, seen + i * study.seen);
        for (let j = 0; j < n; ++j) m[next + j] += weights[i] * m[dx + j];
      }
    };
  }

  /** The failure at k, if something is beyond its limit: a state, an output, or what must stay positive. */
  function failure(k, block, x, part) {
    const nX = block.x.length;
    const failed = (name) => ({ k, time: k * grid.h, name });
    for (let i = 0; i < nX; ++i) if (!(Math.abs(m[x + i]) * m[part.scales + i] <= 1)) return failed(block.x[i]);
    for (let i = 0; i < block.y.length; ++i)
      if (!(Math.abs(m[part.y + i]) * m[part.scales + nX + i] <= 1)) return failed(block.y[i]);
    for (let i = 0; i < block.domain.length; ++i) if (!(m[part.domain + i] > 0)) return failed(block.domain[i]);
    return null;
  }

  /** Keeps outputs for the charts, output by output, if k is a point of theirs. */
  function keep(k, outputs, size, to) {
    if (k % grid.record) return;
    for (let i = 0; i < size; ++i) m[to + i * points() + k / grid.record] = m[outputs + i];
  }

  /** What the truth does. Returns its failure, if there is one. */
  function move(p) {
    const name = roles.truth;
    const part = places.of[name];
    const step = stepOf(name);
    const out = f[`${name}_out`];
    let { x, next } = part;
    prepare(name, p);
    hold(0);
    m.fill(NaN, places.kept, places.kept + points() * nTruth);
    f[`${name}_init`](places.t, part.p, places.held, places.nothing, x);
    for (let k = 0; k <= grid.steps; ++k) {
      hold(k);
      out(places.t, part.c, x, places.held, places.nothing, part.y, part.domain);
      const failed = failure(k, truth, x, part);
      if (failed) return failed;
      copy(part.y, nTruth, places.true + k * nTruth);
      keep(k, part.y, nTruth, places.kept);
      step(places.t, part.c, x, places.held, places.nothing, next, places.seen + k * stages * study.seen);
      [x, next] = [next, x];
    }
    return null;
  }

  /** What the sensors show of it at all stages. */
  function measure(p, seed) {
    const name = roles.sensors;
    const part = places.of[name];
    const out = f[`${name}_out`];
    const samples = grid.hold ? Math.floor(grid.steps / grid.hold) + 1 : 0;
    prepare(name, p);
    for (let sample = 0; sample < samples; ++sample)
      for (let i = 0; i < study.noise; ++i) m[places.noise + sample * study.noise + i] = noise(seed, i, sample);
    for (let k = 0; k <= grid.steps; ++k) {
      hold(k);
      for (let i = 0; i < stages; ++i) {
        const seen = places.seen + (k * stages + i) * study.seen;
        m[places.t] = (k + nodes[i]) * grid.h;
        out(places.t, part.c, part.x, places.held, seen, measuredAt(k, i), part.domain);
      }
    }
  }
  const measuredAt = (k, stage) => places.measured + (k * stages + stage) * nMeasured;

  /** What an observer's front makes of the measurements, before any state: at all stages. */
  function look(p, part) {
    const { front, near, staged } = part;
    const full = f[`${roles.front}_out`];
    const quick = f[`${roles.near}_out`];
    prepare(roles.front, p, front);
    if (near) prepare(roles.near, p, near);
    for (let k = 0; k <= grid.steps; ++k) {
      const here = staged + k * stages * nStaged;
      for (let i = 0; i < stages; ++i) copy(measuredAt(k, i), nMeasured, here + i * nStaged);
      // the quick one tells all stages at once, and whether it doubts that
      if (near) quick(places.t, near.c, near.x, places.held, here, near.y, near.domain);
      const sure = near && m[near.y + stages * nFront] === 0;
      for (let i = 0; i < stages; ++i) {
        const stage = here + i * nStaged;
        if (sure) copy(near.y + i * nFront, nFront, stage + nMeasured);
        else full(places.t, front.c, front.x, places.held, stage, stage + nMeasured, front.domain);
      }
    }
  }

  /** What an observer makes of what it sees, until the truth fails, and its score. Returns its failure, if any. */
  function observe(name, p, staged, truthFailed) {
    const block = blocks[name];
    const part = places.of[name];
    const n = block.y.length;
    const { c } = places.of[roles.score];
    const step = stepOf(name);
    const out = f[`${name}_out`];
    const jumps = [f[`${name}_sample`], f[`${name}_each`]];
    const accounts = [f[`${roles.score}_sample`], f[`${roles.score}_each`]];
    let { x, next, sums, nextSums } = part;
    prepare(name, p);
    hold(0);
    m.fill(NaN, part.kept, part.kept + points() * n);
    m.fill(NaN, part.measures, part.measures + Object.keys(study.measures).length * study.quantities.length);
    m.fill(0, sums, sums + score.x.length);
    f[`${name}_init`](places.t, part.p, places.held, staged, x);
    const last = truthFailed ? truthFailed.k - 1 : grid.steps;
    for (let k = 0; k <= last; ++k) {
      const here = staged + k * stages * nStaged;
      // the first jump is at samples only
      const first = sampled(k) ? 0 : 1;
      const counts = !block.sampled || sampled(k);
      if (!counts && k % grid.record) continue;
      hold(k);
      for (let i = first; i < jumps.length; ++i) {
        if (!jumps[i]) continue;
        jumps[i](places.t, part.c, x, places.held, here, next);
        [x, next] = [next, x];
      }
      out(places.t, part.c, x, places.held, here, part.y, part.domain);
      const failed = failure(k, block, x, part);
      if (failed) return failed;
      keep(k, part.y, n, part.kept);
      if (counts) {
        copy(places.true + k * nTruth, nTruth, places.scored);
        copy(part.y, n, places.scored + nTruth);
      }
      for (let i = first; counts && i < accounts.length; ++i) {
        accounts[i](places.t, c, sums, places.held, places.scored, nextSums);
        [sums, nextSums] = [nextSums, sums];
      }
      if (block.sampled || k === grid.steps) continue;
      step(places.t, part.c, x, places.held, here, next, places.nothing);
      [x, next] = [next, x];
    }
    if (!truthFailed) tell(block, sums, part.measures);
    return null;
  }

  /** The measures of an observer, of its score. */
  function tell(block, sums, to) {
    // errors of what moves at samples only are counted there
    const each = block.sampled && grid.hold ? grid.hold : 1;
    m[places.h] = grid.h * each;
    m[places.steps] = Math.floor(grid.steps / each);
    m[places.window] = Math.ceil(grid.window / each);
    f.measures(sums, places.h, places.steps, places.window, to);
  }

  /** Takes steps that are so many times as large. */
  function coarsen(times) {
    const { h, pulses } = study.grid;
    grid = { h: h * times, pulses: pulses.map((edges) => edges.map((edge) => edge / times)) };
    for (const name of ["steps", "record", "hold", "window"]) grid[name] = study.grid[name] / times;
  }

  return {
    coarsen,
    prepare,
    move,
    measure,
    look,
    observe,
    points,
    times: () => Float64Array.from({ length: points() }, (_, i) => i * grid.record * grid.h),
  };
}
