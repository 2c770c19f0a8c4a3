/* The table of errors: a row for each quantity, a column for each observer, one measure at a time. */

// a time that did not count, which is no error
const NO_ERROR = "masked";

/** Builds it; `changed()` is called when another measure is chosen. Returns what fills it. */
function tableOf(study, runner, choices, changed) {
  const names = Object.keys(study.observers);
  const table = byId("measures");
  const select = made("select", { id: "measure" });
  const meaning = made("span", { id: "meaning" });

  for (const name of Object.keys(study.measures))
    select.append(made("option", { value: name }, name === "rmse" ? "RMSE" : name));
  select.addEventListener("change", () => {
    choices.measure = select.value;
    changed();
  });
  byId("which").append(made("label", {}, "Show ", select), meaning);

  const columns = names.map((name) => made("th", { scope: "col" }, swatch(name), study.observers[name]));
  table.tHead.append(made("tr", {}, made("th", { scope: "col" }, "quantity"), ...columns));
  for (const { symbol, sentence } of study.quantities) {
    const head = made("th", { scope: "row" }, made("b", {}, symbol), " ", made("span", {}, sentence));
    table.tBodies[0].append(made("tr", {}, head, ...names.map(() => made("td"))));
  }

  return () => {
    select.value = choices.measure;
    meaning.textContent = study.measures[choices.measure];
    study.quantities.forEach((_, row) => {
      const values = names.map((name) => runner.measure(name, choices.measure, row));
      const best = Math.min(...values.filter(Number.isFinite));
      values.forEach((value, column) => {
        const cell = table.tBodies[0].rows[row].cells[column + 1];
        // what has not changed is not read aloud again
        if (cell.textContent !== short(value)) cell.textContent = short(value);
        cell.classList.toggle("best", value === best && choices.measure !== NO_ERROR);
      });
    });
  };
}
