/* What is shown of a study: some quantities, observers that are not hidden, one measure. */

function choicesOf(study) {
  const quantities = study.quantities.map(({ name }) => name);
  const observers = Object.keys(study.observers);
  const measures = Object.keys(study.measures);
  const first = quantities.filter((name) => study.first.includes(name));
  const choices = { shown: new Set(first), hidden: new Set(), measure: measures[0] };

  /** What a link says of it: only what is not as it is at first. */
  choices.words = () => {
    const shown = quantities.filter((name) => choices.shown.has(name));
    return [
      ...(shown.join() === first.join() ? [] : [["show", shown.join()]]),
      ...(choices.hidden.size ? [["hide", [...choices.hidden].join()]] : []),
      ...(choices.measure === measures[0] ? [] : [["measure", choices.measure]]),
    ];
  };

  /** Takes what a link says; returns the words that are about something else. */
  choices.take = ({ show = "", hide = "", measure, ...others }) => {
    const listed = (words, valid) => valid.filter((name) => words.split(",").includes(name));
    const shown = listed(show, quantities);
    choices.shown = new Set(shown.length ? shown : first);
    choices.hidden = new Set(listed(hide, observers));
    choices.measure = measures.includes(measure) ? measure : measures[0];
    return others;
  };
  return choices;
}
