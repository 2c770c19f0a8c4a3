/* The page: unpacks the study and its functions, builds the controls, and runs again when a number changes. */

// steps are so many times larger while a slider is moved, if the grid allows it
const COARSER = 2;
// of a slider, and digits that tell neighbouring ones apart
const POSITIONS = 1000, DIGITS = 4;
// the section that comes first
const NOISE = "noise";

const byId = (id) => document.getElementById(id);

/** A new element with attributes and children. */
function made(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

/** What a script of the page holds, unpacked. */
async function unpacked(id) {
  const bytes = Uint8Array.from(atob(byId(id).textContent), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

/** The study's functions, and the array that they work on. */
async function loaded(study) {
  const kernel = await unpacked("kernel");
  if (byId("kernel").dataset.language === "javascript") {
    // a place is never 0
    const places = arranged(study, 1), m = new Float64Array(places.end);
    return { places, m, f: new Function("m", new TextDecoder().decode(kernel))(m) };
  }
  const { instance } = await WebAssembly.instantiate(kernel, { env: Math });
  const { memory, __heap_base: begin } = instance.exports, page = 65536;
  const places = arranged(study, Math.ceil(begin.value / 8));
  memory.grow(Math.max(0, Math.ceil((8 * places.end - memory.buffer.byteLength) / page)));
  return { places, m: new Float64Array(memory.buffer), f: instance.exports };
}

async function begin() {
  const study = JSON.parse(new TextDecoder().decode(await unpacked("study")));
  const { places, m, f } = await loaded(study);
  const runner = runnable(study, f, m, places), settings = settingsOf(study);
  const names = Object.keys(study.observers);
  const grids = ["steps", "record", "hold", "window"].map((name) => study.grid[name]).concat(study.grid.pulses.flat());
  const coarser = grids.every((steps) => steps % COARSER === 0) ? COARSER : 1;
  const shown = new Set(), hidden = new Set(), controls = new Map();
  let measure = Object.keys(study.measures)[0];

  const styles = getComputedStyle(document.documentElement);
  const colour = (name) => styles.getPropertyValue(name);
  names.forEach((name, i) => document.documentElement.style.setProperty(`--of-${name}`, `var(--line-${i % 6})`));
  const charts = chartsOf(study, runner, byId("charts"), colour, (name) => !hidden.has(name));

  /** Runs what has changed and shows it; steps are larger while something moves. */
  function show(moving) {
    const start = performance.now(), broken = runner.broken(settings.value);
    byId("failures").textContent = broken;
    if (broken) return;
    runner.run(settings.value, settings.seed(), moving ? coarser : 1);
    const computed = performance.now();
    charts.draw(shown);
    fillTable();
    tell();
    state.times.push({ compute: computed - start, all: performance.now() - start });
    if (!moving) history.replaceState(null, "", `#${link()}`);
  }

  // a fast drag asks more often than there are pictures
  let asked = null;
  const ask = (moving) => {
    if (asked === null) requestAnimationFrame(() => { const how = asked; asked = null; show(how); });
    asked = moving && asked !== false;
  };

  const link = () => {
    const words = [];
    if ([...shown].join() !== firstShown().join()) words.push(["show", [...shown].join()]);
    if (hidden.size) words.push(["hide", [...hidden].join()]);
    if (measure !== Object.keys(study.measures)[0]) words.push(["measure", measure]);
    return settings.link(words);
  };
  const firstShown = () => study.quantities.map(({ name }) => name).filter((name) => study.first.includes(name));

  /** What failed, in words; else nothing. */
  function tell() {
    const { truth, ...observers } = runner.failures;
    const failed = ([name, { time, name: what }]) => `${study.observers[name] ?? "the plant"} failed at τ = ${short(time)}: ${what} is beyond its limit`;
    const words = truth ? [["", truth]] : Object.entries(observers).filter(([, failure]) => failure);
    byId("failures").textContent = words.map(failed).join("; ");
  }

  function fillTable() {
    const body = byId("measures").tBodies[0];
    study.quantities.forEach((_, row) => {
      const values = names.map((name) => runner.measure(name, measure, row));
      const best = Math.min(...values.filter(Number.isFinite));
      values.forEach((value, column) => {
        const cell = body.rows[row].cells[column + 1], text = short(value);
        if (cell.textContent !== text) cell.textContent = text;
        cell.classList.toggle("best", value === best && measure !== "masked");
      });
    });
  }

  function buildTable() {
    const choice = made("select", { id: "measure" });
    for (const name of Object.keys(study.measures)) choice.append(made("option", { value: name }, name === "rmse" ? "RMSE" : name));
    choice.addEventListener("change", () => { measure = choice.value; sayMeasure(); show(false); });
    byId("which").append(made("label", {}, "Show ", choice), made("span", { id: "meaning" }));
    const head = made("tr", {}, made("th", { scope: "col" }, "quantity"));
    for (const name of names) head.append(made("th", { scope: "col" }, swatch(name), study.observers[name]));
    byId("measures").tHead.append(head);
    for (const { symbol, sentence } of study.quantities) {
      const row = made("tr", {}, made("th", { scope: "row" }, made("b", {}, symbol), " ", made("span", {}, sentence)));
      names.forEach(() => row.append(made("td")));
      byId("measures").tBodies[0].append(row);
    }
  }
  const sayMeasure = () => {
    byId("measure").value = measure;
    byId("meaning").textContent = study.measures[measure];
  };

  const swatch = (name) => made("span", { class: "swatch", style: `background: var(--of-${name})`, "aria-hidden": "true" });

  /** A button that is pressed or not, for a member of a set. */
  function toggle(set, member, pressed, ...content) {
    const button = made("button", { type: "button", class: "toggle" }, ...content);
    const paint = () => button.setAttribute("aria-pressed", String(set.has(member) === pressed));
    button.addEventListener("click", () => {
      if (!set.delete(member)) set.add(member);
      paint();
      show(false);
    });
    toggles.push(paint);
    return button;
  }
  const toggles = [];

  function buildToggles() {
    for (const name of names) byId("observers").append(toggle(hidden, name, false, swatch(name), study.observers[name]));
    for (const { name, symbol, sentence } of study.quantities) {
      const button = toggle(shown, name, true, symbol);
      button.title = sentence;
      button.setAttribute("aria-label", sentence);
      byId("quantities").append(button);
    }
  }

  /** A slider and a box for a number; the box alone where nothing says how far a slider should go. */
  function control(number) {
    const { path, sentence, unit, reach, logarithmic, value } = number;
    const id = `number-${path}`, row = made("div", { class: "number" });
    const box = made("input", { id, type: "text", inputmode: "decimal", autocomplete: "off", "aria-describedby": `${id}-said` });
    const said = made("span", { id: `${id}-said`, class: "said" }, sentence + (unit === "1" ? "" : ` [${unit}]`));
    const label = made("label", { for: id }, path.slice(path.indexOf(".") + 1).replace(/[._]/g, "$&\u200b"));
    row.append(label, box, said);
    const change = (to, moving) => {
      const wrong = settings.set(path, to);
      box.setCustomValidity(wrong && `${path} must be ${wrong}`);
      row.classList.toggle("wrong", Boolean(wrong));
      said.textContent = wrong ? `must be ${wrong}` : sentence;
      if (!wrong) ask(moving);
      row.classList.toggle("changed", settings.changed(path));
    };
    const [low, high] = reach ?? [0, 0];
    const at = (position) => (logarithmic ? low * (high / low) ** position : low + (high - low) * position);
    const where = (x) => (logarithmic ? Math.log(x / low) / Math.log(high / low) : (x - low) / (high - low));
    let slider = null;
    if (reach) {
      slider = made("input", { type: "range", min: 0, max: POSITIONS, step: 1, "aria-label": `${path}: ${sentence}` });
      const move = (moving) => {
        // the place where it stood at first is its very number
        const position = Number(slider.value), first = Math.round(where(value) * POSITIONS);
        const to = position === first ? value : Number(at(position / POSITIONS).toPrecision(DIGITS));
        box.value = String(to);
        slider.setAttribute("aria-valuetext", box.value);
        change(to, moving);
      };
      slider.addEventListener("input", () => move(true));
      slider.addEventListener("change", () => move(false));
      row.insertBefore(slider, said);
    }
    box.addEventListener("change", () => {
      change(box.value.trim() === "" ? NaN : Number(box.value), false);
      if (slider) slider.value = Math.round(where(settings.value(path)) * POSITIONS);
    });
    const paint = () => {
      const x = settings.value(path);
      box.value = String(x);
      if (slider) {
        slider.value = Math.round(where(x) * POSITIONS);
        slider.setAttribute("aria-valuetext", box.value);
      }
      said.textContent = sentence;
      box.setCustomValidity("");
      row.classList.remove("wrong");
      row.classList.toggle("changed", settings.changed(path));
    };
    controls.set(path, paint);
    return row;
  }

  function buildControls() {
    const sections = new Map();
    for (const number of study.numbers) {
      const owner = number.path.split(".")[0];
      if (!sections.has(owner)) sections.set(owner, []);
      sections.get(owner).push(number);
    }
    // what is moved most comes first, and is open
    const order = new Set([NOISE, ...names, ...sections.keys()]), open = [NOISE, names[0]];
    for (const owner of [...order].filter((name) => sections.has(name))) {
      const title = study.observers[owner] ? [swatch(owner), study.observers[owner]] : [owner.replace(/([a-z])(\d)/, "$1 $2")];
      const section = made("details", {}, made("summary", {}, ...title), ...sections.get(owner).map(control));
      section.open = open.includes(owner);
      byId("numbers").append(section);
    }
    const seed = byId("seed");
    const set = (number) => {
      const wrong = settings.seedObjection(number);
      seed.setCustomValidity(wrong && `the seed must be ${wrong}`);
      if (seed.reportValidity()) settings.setSeed(number), ask(false);
    };
    seed.addEventListener("change", () => set(seed.value.trim() === "" ? NaN : Number(seed.value)));
    byId("another").addEventListener("click", () => { seed.value = settings.seed() + 1; set(settings.seed() + 1); });
    byId("reset").addEventListener("click", () => { settings.reset(); paint(); show(false); });
    byId("copy").addEventListener("click", async () => {
      try {
        await navigator.clipboard.writeText(location.href);
        byId("status").textContent = "The link is copied.";
      } catch {
        byId("status").textContent = "This browser does not let the page copy; the link is in its address line.";
      }
    });
  }

  function paint() {
    byId("seed").value = settings.seed();
    controls.forEach((one) => one());
    toggles.forEach((one) => one());
    sayMeasure();
  }

  /** Takes the settings of a link. */
  function take(words) {
    const { unknown, others } = settings.take(words);
    const listed = (text, valid) => (text ?? "").split(",").filter((name) => valid.includes(name));
    const quantities = listed(others.show, study.quantities.map(({ name }) => name));
    shown.clear();
    hidden.clear();
    (quantities.length ? quantities : firstShown()).forEach((name) => shown.add(name));
    listed(others.hide, names).forEach((name) => hidden.add(name));
    measure = listed(others.measure, Object.keys(study.measures))[0] ?? Object.keys(study.measures)[0];
    for (const name of ["show", "hide", "measure"]) delete others[name];
    const odd = [...unknown, ...Object.entries(others).map(([name, text]) => `${name}=${text}`)];
    byId("status").textContent = odd.length ? `The link says what this page does not know: ${odd.join(", ")}.` : "";
  }

  const state = { study, runner, settings, times: [] };
  window.hillobs = state;
  buildTable();
  buildToggles();
  buildControls();
  take(location.hash.slice(1));
  paint();
  show(false);
  document.body.classList.remove("loading");
  window.addEventListener("hashchange", () => { take(location.hash.slice(1)); paint(); show(false); });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", charts.redraw);
}

begin().catch((error) => {
  byId("failures").textContent = `This page cannot run here: ${error.message}`;
  document.body.classList.remove("loading");
});
