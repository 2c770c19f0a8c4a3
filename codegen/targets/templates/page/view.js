/* The page: what it was written with, what is shown of it, and what happens when a number changes. */

// steps are so many times larger while a slider moves, if the grid allows that
const COARSER = 2;
// colours of lines
const COLOURS = 6;

async function begin() {
  const { study, places, m, f } = await loaded();
  const runner = runnerOf(study, f, m, places);
  const settings = settingsOf(study);
  const choices = choicesOf(study);
  const names = Object.keys(study.observers);
  const { steps, record, hold, window: scored, pulses } = study.grid;
  const coarser = [steps, record, hold, scored, ...pulses.flat()].every((k) => k % COARSER === 0) ? COARSER : 1;
  const toggles = [];

  names.forEach((name, i) => document.documentElement.style.setProperty(`--of-${name}`, `var(--line-${i % COLOURS})`));
  const charts = chartsOf(study, runner, choices, byId("charts"));
  const fillTable = tableOf(study, runner, choices, () => show(false));
  const paintControls = controlsOf(study, settings, ask);

  /** Runs what has changed and shows it; steps are larger while something moves. */
  function show(moving) {
    const start = performance.now();
    const broken = runner.broken(settings.value);
    if (!broken) {
      runner.run(settings.value, settings.seed(), moving ? coarser : 1);
      charts.draw();
      fillTable();
    }
    byId("failures").textContent = broken || failures();
    window.hillobs.times.push(performance.now() - start);
    if (!moving) history.replaceState(null, "", `#${settings.link(choices.words())}`);
  }

  // a fast drag asks more often than there are pictures
  let asked = null;
  function ask(moving) {
    if (asked === null)
      requestAnimationFrame(() => {
        const now = asked;
        asked = null;
        show(now);
      });
    asked = moving && asked !== false;
  }

  /** What failed, in words; an empty text if nothing did. */
  function failures() {
    const said = (who, { time, name }) => `${who} failed at τ = ${short(time)}: ${name} is beyond its limit`;
    const { truth } = runner.failures;
    if (truth) return said("the plant", truth);
    const failed = names.filter((name) => runner.failures[name]);
    return failed.map((name) => said(study.observers[name], runner.failures[name])).join("; ");
  }

  /** A button that is pressed while `isPressed()`. */
  function toggle(isPressed, press, ...content) {
    const button = made("button", { type: "button", class: "toggle" }, ...content);
    const paint = () => button.setAttribute("aria-pressed", String(isPressed()));
    button.addEventListener("click", () => {
      press();
      paint();
      show(false);
    });
    toggles.push(paint);
    return button;
  }

  const flip = (set, member) => set.delete(member) || set.add(member);
  for (const name of names) {
    const content = [swatch(name), study.observers[name]];
    const isShown = () => !choices.hidden.has(name);
    byId("observers").append(toggle(isShown, () => flip(choices.hidden, name), ...content));
  }
  for (const { name, symbol, sentence } of study.quantities) {
    const isShown = () => choices.shown.has(name);
    const button = toggle(isShown, () => flip(choices.shown, name), symbol);
    button.title = sentence;
    button.setAttribute("aria-label", sentence);
    byId("quantities").append(button);
  }

  byId("reset").addEventListener("click", () => {
    settings.reset();
    paintControls();
    show(false);
  });
  byId("copy").addEventListener("click", async () => {
    try {
      await navigator.clipboard.writeText(location.href);
      byId("status").textContent = "The link is copied.";
    } catch {
      byId("status").textContent = "This browser does not let the page copy; the link is in its address line.";
    }
  });

  /** Takes what the address carries, and shows it. */
  function follow() {
    const { unknown, others } = settings.take(location.hash.slice(1));
    const odd = [...unknown, ...Object.entries(choices.take(others)).map(([name, words]) => `${name}=${words}`)];
    byId("status").textContent = odd.length ? `The link says what this page does not know: ${odd.join(", ")}.` : "";
    paintControls();
    toggles.forEach((paint) => paint());
    show(false);
  }

  // for those who look behind the page: in the console, and in tests
  window.hillobs = { study, runner, settings, charts, times: [] };
  follow();
  document.body.classList.remove("loading");
  window.addEventListener("hashchange", follow);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", charts.redraw);
}

begin().catch((error) => {
  byId("failures").textContent = `This page cannot run here: ${error.message}`;
  document.body.classList.remove("loading");
});
