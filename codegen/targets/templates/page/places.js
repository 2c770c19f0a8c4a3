/* Where the arrays of a study are: all are parts of one array of numbers `m`, and a place is an index of it. */

/** The places from `begin` on; `end` is behind them. `of` has those of each block by its name. */
function placesOf(study, begin) {
  const { blocks, grid, roles, stages } = study;
  const points = grid.steps + 1;
  const kept = grid.steps / grid.record + 1;
  const truth = blocks[roles.truth];
  const sensors = blocks[roles.sensors];
  const front = blocks[roles.front];
  const score = blocks[roles.score];
  const observers = Object.keys(study.observers);
  let end = begin;

  const room = (size) => (end += size) - size;

  const part = (block) => ({
    p: room(block.p.length),
    c: room(block.constants),
    scales: room(block.x.length + block.y.length),
    x: room(block.x.length),
    next: room(block.x.length),
    y: room(block.y.length),
    domain: room(block.domain.length),
    // of a step that is taken stage by stage
    at: room(block.x.length),
    dx: room(block.x.length),
    node: room(1),
  });

  const of = {};
  for (const [name, block] of Object.entries(blocks)) of[name] = part(block);
  for (const name of observers)
    Object.assign(of[name], {
      front: part(front),
      near: roles.near ? part(blocks[roles.near]) : null,
      staged: room(points * stages * (sensors.y.length + front.y.length)),
      sums: room(score.x.length),
      nextSums: room(score.x.length),
      measures: room(Object.keys(study.measures).length * study.quantities.length),
      kept: room(kept * blocks[name].y.length),
    });
  return {
    of,
    ruled: room(study.ruled.length),
    sides: room(2 * study.rules.length),
    t: room(1),
    h: room(1),
    steps: room(1),
    window: room(1),
    held: room(study.held),
    nothing: room(1),
    noise: room(points * study.noise),
    seen: room(points * stages * study.seen),
    true: room(points * truth.y.length),
    measured: room(points * stages * sensors.y.length),
    scored: room(truth.y.length + Math.max(...observers.map((name) => blocks[name].y.length))),
    kept: room(kept * truth.y.length),
    end,
  };
}
