/* A slider and a box for each number, in a section for each part of the study; the seed. */

// of a slider, and the digits that tell neighbouring ones apart
const POSITIONS = 1000;
const DIGITS = 4;
// the section that comes first
const NOISE = "noise";

const typed = (box) => (box.value.trim() === "" ? NaN : Number(box.value));

/** Builds them; `changed(moving)` is called when a number has changed. Returns what shows the numbers as they are set. */
function controlsOf(study, settings, changed) {
  const painters = [];
  const names = Object.keys(study.observers);

  /** The number's place on a slider, from 0 to 1, and the number there; nothing if there is no slider. */
  function scaleOf({ reach, logarithmic, value }) {
    if (!reach) return null;
    const [low, high] = reach;
    const number = (part) => (logarithmic ? low * (high / low) ** part : low + (high - low) * part);
    const part = (x) => (logarithmic ? Math.log(x / low) / Math.log(high / low) : (x - low) / (high - low));
    const position = (x) => Math.round(part(x) * POSITIONS);
    // where it stood at first is its very number
    const at = (k) => (k === position(value) ? value : Number(number(k / POSITIONS).toPrecision(DIGITS)));
    return { position, at };
  }

  function control(number) {
    const { path, sentence, unit } = number;
    const id = `number-${path}`;
    const about = unit === "1" ? sentence : `${sentence} [${unit}]`;
    const scale = scaleOf(number);
    const attributes = { type: "text", inputmode: "decimal", autocomplete: "off", "aria-describedby": `${id}-said` };
    const box = made("input", { id, ...attributes });
    const slider = made("input", { type: "range", max: POSITIONS, "aria-label": `${path}: ${sentence}` });
    const said = made("span", { id: `${id}-said`, class: "said" });
    // may be broken after a dot or a dash
    const label = made("label", { for: id }, path.slice(path.indexOf(".") + 1).replace(/[._]/g, "$&\u200b"));
    const row = made("div", { class: "number" }, label, ...(scale ? [slider] : []), box, said);

    /** Shows what is wrong, or nothing. */
    const judge = (wrong) => {
      box.setCustomValidity(wrong && `${path} must be ${wrong}`);
      said.textContent = wrong ? `must be ${wrong}` : about;
      row.classList.toggle("wrong", Boolean(wrong));
      row.classList.toggle("changed", settings.changed(path));
    };
    const place = () => {
      if (!scale) return;
      slider.value = scale.position(settings.value(path));
      slider.setAttribute("aria-valuetext", String(settings.value(path)));
    };
    const set = (to, moving) => {
      const wrong = settings.set(path, to);
      judge(wrong);
      if (!wrong) changed(moving);
    };
    const slide = (moving) => {
      const to = scale.at(Number(slider.value));
      box.value = String(to);
      slider.setAttribute("aria-valuetext", box.value);
      set(to, moving);
    };
    slider.addEventListener("input", () => slide(true));
    slider.addEventListener("change", () => slide(false));
    box.addEventListener("change", () => {
      set(typed(box), false);
      place();
    });
    painters.push(() => {
      box.value = String(settings.value(path));
      place();
      judge("");
    });
    return row;
  }

  function section(owner, numbers) {
    const label = study.observers[owner];
    const title = label ? [swatch(owner), label] : [owner.replace(/([a-z])(\d)/, "$1 $2")];
    const details = made("details", {}, made("summary", {}, ...title), ...numbers.map(control));
    // what is moved most is open
    details.open = owner === NOISE || owner === names[0];
    return details;
  }

  function seed() {
    const box = byId("seed");
    const set = (number) => {
      const wrong = settings.seedObjection(number);
      box.setCustomValidity(wrong && `the seed must be ${wrong}`);
      if (!box.reportValidity()) return;
      settings.setSeed(number);
      box.value = String(number);
      changed(false);
    };
    box.addEventListener("change", () => set(typed(box)));
    byId("another").addEventListener("click", () => set(settings.seed() + 1));
    painters.push(() => {
      box.value = String(settings.seed());
      box.setCustomValidity("");
    });
  }

  const ownerOf = ({ path }) => path.split(".")[0];
  for (const owner of new Set([NOISE, ...names, ...study.numbers.map(ownerOf)])) {
    const numbers = study.numbers.filter((number) => ownerOf(number) === owner);
    if (numbers.length) byId("numbers").append(section(owner, numbers));
  }
  seed();
  return () => painters.forEach((paint) => paint());
}
