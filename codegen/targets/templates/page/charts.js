/* A chart for each quantity: the truth and all estimates over time. */

// of the scale: room above and below, as a part of what is shown
const MARGIN = 0.08;
const HEIGHT = 210;
// of the truth, which is drawn last: what lies below shows in the gaps
const DASHES = [7, 4];

function chartsOf(study, runner, box, colour, isShown) {
  const charts = new Map();
  const together = uPlot.sync("time");
  const names = Object.keys(study.observers);

  /** From where to where the truth goes, and estimates once errors count. */
  function range(plot) {
    const from = study.grid.window * study.grid.h;
    let low = Infinity, high = -Infinity;
    const [times, ...estimates] = plot.data, truth = estimates.pop();
    const look = (values, begin) => {
      for (let i = 0; i < values.length; ++i) if (times[i] >= begin && values[i] === values[i]) (low = Math.min(low, values[i])), (high = Math.max(high, values[i]));
    };
    look(truth, 0);
    estimates.forEach((values, i) => { if (isShown(names[i])) look(values, from); });
    if (!(low <= high)) return [-1, 1];
    const room = MARGIN * (high - low || Math.abs(high) || 1);
    return [low - room, high + room];
  }

  function made(quantity) {
    const figure = document.createElement("figure");
    const caption = document.createElement("figcaption");
    const value = document.createElement("span");
    caption.innerHTML = `<b></b> <span></span>`;
    caption.children[0].textContent = quantity.symbol;
    caption.children[1].textContent = quantity.sentence;
    value.className = "reading";
    const place = document.createElement("div");
    place.setAttribute("role", "img");
    place.setAttribute("aria-label", `${quantity.sentence} over time: the truth and the estimates; errors are in the table`);
    figure.append(caption, place, value);
    // in the order of the study, whenever it is asked for
    const after = study.quantities.slice(study.quantities.indexOf(quantity) + 1).find(({ name }) => charts.has(name));
    box.insertBefore(figure, after ? charts.get(after.name).figure : null);
    const axis = { stroke: () => colour("--ink"), grid: { stroke: () => colour("--line"), width: 1 }, ticks: { stroke: () => colour("--line") }, font: "12px system-ui, sans-serif" };
    const plot = new uPlot({
      width: place.clientWidth || 400, height: HEIGHT,
      cursor: { sync: { key: together.key }, y: false, points: { size: 5 } },
      legend: { show: false },
      scales: { x: { time: false }, y: { range } },
      axes: [{ ...axis, label: "τ", labelSize: 16, labelFont: "italic 13px serif", size: 34 }, { ...axis, size: 58 }],
      series: [
        {},
        ...names.map((name) => ({ stroke: () => colour(`--of-${name}`), width: 1.5, show: isShown(name) })),
        { stroke: () => colour("--ink"), width: 1.5, dash: DASHES },
      ],
      hooks: { setCursor: [(u) => { value.textContent = reading(u); }] },
    }, [[], ...names.map(() => []), []], place);
    new ResizeObserver(() => plot.setSize({ width: place.clientWidth, height: HEIGHT })).observe(place);
    return { figure, plot, value };
  }

  /** What is under the cursor, in words. */
  function reading(u) {
    const i = u.cursor.idx;
    if (i === null || i === undefined || !u.data[0].length) return "";
    const words = names.map((name, j) => (isShown(name) ? `${study.observers[name]} ${short(u.data[j + 1][i])}` : "")).filter(Boolean);
    return `τ = ${u.data[0][i].toFixed(2)}: true ${short(u.data[names.length + 1][i])}, ${words.join(", ")}`;
  }

  /** Draws the charts of the quantities named, in the order of the study. */
  function draw(shown) {
    const times = runner.times();
    for (const quantity of study.quantities) {
      const { name } = quantity;
      const chart = charts.get(name);
      if (!shown.has(name)) { if (chart) chart.figure.hidden = true; continue; }
      const { figure, plot } = chart ?? charts.set(name, made(quantity)).get(name);
      figure.hidden = false;
      names.forEach((observer, i) => { if (plot.series[i + 1].show !== isShown(observer)) plot.setSeries(i + 1, { show: isShown(observer) }, false); });
      plot.setData([times, ...names.map((observer) => runner.estimate(observer, name)), runner.truth(name)]);
    }
  }
  return { draw, redraw: () => charts.forEach(({ plot }) => plot.redraw(false)) };
}

/** A number with three digits. */
function short(number) {
  if (!Number.isFinite(number)) return "–";
  const size = Math.abs(number);
  if (size !== 0 && (size < 1e-3 || size >= 1e4)) return number.toExponential(2).replace("e-", "e−").replace("e+", "e");
  return String(Number(number.toPrecision(3))).replace("-", "−");
}
