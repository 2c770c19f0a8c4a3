"""What a search for gains has to say: the gains, what they are worth in runs that it has not seen, and their file."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from rich.table import Table

from ....observers import OBSERVERS, label
from ...files.toml import toml_numbers
from ...tune.run import Tuned
from .number import counted, number

# digits of a number in a sentence
_DIGITS = 4


def sentences(found: Tuned) -> Iterator[str]:
    """How many trials there were, the front, the gains, and what got worse."""
    trials, tests, who = found.trials, found.tests, label(found.trials.attrs["observer"])
    allowed = int((trials.broken == 0).sum())
    yield f"{counted(trials.sizes['trial'], 'trial')}, {allowed:,} of them within all gain conditions"
    if trials.broken.values[0] > 0:
        yield "the scenario's own gains are not within them"
    if trials.sizes["objective"] > 1:
        yield (
            f"{counted(int(trials.front.sum()), 'trial')} on the front of {' and '.join(trials.objective.values)}; "
            "taken: the smallest product of factors"
        )
    numbers = (f"{path.partition('.')[2]} = {value:.{_DIGITS}g}" for path, value in found.numbers.items())
    yield f"{who}: {', '.join(numbers)}"
    seeds = tests.sizes["seed"]
    noise = f"with {seeds:,} other seeds" if seeds > 1 else "without noise"
    yield (f"tested {noise}, on the scenario's trajectory and on {counted(tests.sizes['trajectory'] - 1, 'other')}:")


def factors_table(found: Tuned) -> Table:
    """For each quantity the median errors, and the factors on the scenario's trajectory and on the others."""
    own, tuned = (np.median(found.tests.rmse.sel(gains=name), axis=1) for name in found.tests.gains.values)
    table = Table(box=None, padding=(0, 1, 0, 0))
    for heading in ("quantity", "scenario's\ngains", "tuned", "factor", "others:\nmedian", "worst"):
        table.add_column(heading, no_wrap=True, justify="left" if heading == "quantity" else "right", vertical="bottom")
    for i, quantity in enumerate(found.tests.quantity.values.tolist()):
        factor = tuned[:, i] / own[:, i]
        others = (number(float(value)) for value in (np.median(factor[1:]), factor[1:].max()))
        table.add_row(quantity, number(own[0, i]), number(tuned[0, i]), number(factor[0]), *others)
    return table


def scenario_file(found: Tuned) -> str:
    """The scenario with the gains, as TOML that says what it is."""
    name, count = found.trials.attrs["observer"], found.trials.sizes["trial"]
    run = f"--observer {name if name in OBSERVERS else f'FILE.py:{name}'}{' --corrected' * found.corrected}"
    objectives = "; ".join(found.trials.objective.values)
    comments = [
        f"gains of {label(name)} by {count:,} trials: the smallest error of {objectives}",
        f"hillobs simulate THIS_FILE {run}",
    ]
    return toml_numbers(comments, {**found.scenario, **found.numbers})
