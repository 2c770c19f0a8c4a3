/* A chart for each quantity that is shown: the truth and the estimates over time. */

const HEIGHT = 210;
// room above and below, as a part of what is shown
const MARGIN = 0.08;
const WIDTH = 1.5;
// of the truth, which is drawn last: what lies below shows in the gaps
const DASHES = [7, 4];

function chartsOf(study, runner, choices, box) {
  const names = Object.keys(study.observers);
  const charts = new Map();
  const styles = getComputedStyle(document.documentElement);
  const colour = (name) => () => styles.getPropertyValue(name);
  const isShown = (name) => !choices.hidden.has(name);

  /** From where to where the truth goes, and the estimates once errors count. */
  function range(plot) {
    const [times, ...lines] = plot.data;
    const scored = study.grid.window * study.grid.h;
    let low = Infinity;
    let high = -Infinity;
    lines.forEach((values, line) => {
      const isTruth = line === names.length;
      if (!isTruth && !isShown(names[line])) return;
      for (let i = 0; i < values.length; ++i) {
        if (times[i] < scored && !isTruth) continue;
        if (values[i] < low) low = values[i];
        if (values[i] > high) high = values[i];
      }
    });
    if (!(low <= high)) return [-1, 1];
    const room = MARGIN * (high - low || Math.abs(high) || 1);
    return [low - room, high + room];
  }

  /** What is under the cursor, in words. */
  function reading({ data: [times, ...lines], cursor: { idx } }) {
    if (idx === null || idx === undefined || !(idx < times.length)) return "";
    const said = names
      .filter(isShown)
      .map((name) => `${study.observers[name]} ${short(lines[names.indexOf(name)][idx])}`);
    return [`τ = ${times[idx].toFixed(2)}: true ${short(lines[names.length][idx])}`, ...said].join(", ");
  }

  function chart(quantity) {
    const caption = made("figcaption", {}, made("b", {}, quantity.symbol), " ", quantity.sentence);
    const about = `${quantity.sentence} over time: the truth and the estimates; errors are in the table`;
    const place = made("div", { role: "img", "aria-label": about });
    const words = made("span", { class: "reading" });
    const figure = made("figure", {}, caption, place, words);
    // in the order of the study, whenever it is asked for
    const later = study.quantities.slice(study.quantities.indexOf(quantity) + 1).find(({ name }) => charts.has(name));
    box.insertBefore(figure, later ? charts.get(later.name).figure : null);
    const axis = {
      stroke: colour("--ink"),
      grid: { stroke: colour("--line"), width: 1 },
      ticks: { stroke: colour("--line") },
      font: "12px system-ui, sans-serif",
    };
    const lines = names.map((name) => ({ stroke: colour(`--of-${name}`), width: WIDTH }));
    const options = {
      width: place.clientWidth,
      height: HEIGHT,
      cursor: { sync: { key: "time" }, y: false, points: { size: 5 } },
      legend: { show: false },
      scales: { x: { time: false }, y: { range } },
      axes: [
        { ...axis, label: "τ", labelSize: 16, labelFont: "italic 13px serif", size: 34 },
        { ...axis, size: 58 },
      ],
      series: [{}, ...lines, { stroke: colour("--ink"), width: WIDTH, dash: DASHES }],
      hooks: { setCursor: [(plot) => (words.textContent = reading(plot))] },
    };
    const plot = new uPlot(options, [[], ...names.map(() => []), []], place);
    new ResizeObserver(() => plot.setSize({ width: place.clientWidth, height: HEIGHT })).observe(place);
    return { figure, plot };
  }

  function draw() {
    const times = runner.times();
    for (const quantity of study.quantities) {
      const { name } = quantity;
      if (choices.shown.has(name) && !charts.has(name)) charts.set(name, chart(quantity));
      if (!charts.has(name)) continue;
      const { figure, plot } = charts.get(name);
      figure.hidden = !choices.shown.has(name);
      if (figure.hidden) continue;
      names.forEach((observer, i) => {
        // whatever is set anew asks for another scale
        if (plot.series[i + 1].show !== isShown(observer)) plot.setSeries(i + 1, { show: isShown(observer) });
      });
      plot.setData([times, ...names.map((observer) => runner.estimate(observer, name)), runner.truth(name)]);
    }
  }

  /** From where to where the chart of a quantity goes. */
  const scaleOf = (name) => charts.get(name).plot.scales.y;

  return { draw, scaleOf, redraw: () => charts.forEach(({ plot }) => plot.redraw(false)) };
}
