"""What a run has to say on a terminal: tables of measures, warnings, guards, failures."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np
import xarray as xr
from rich.table import Table
from rich.text import Text

from ....model.symbols import muscle_of
from ....observers import label
from ...scenarios.prepare import BASELINE
from ...scenarios.world import FEEDBACK, STATES
from ...simulate.measures import numbers
from ...simulate.series import label_of
from ...simulate.step_error import SHOWN_FROM, error_of, relative
from .conditions import violated_conditions
from .number import number, percent

_TITLES = {
    "rmse": "root mean square error over [{start:g}, {end:g}]",
    "peak": "largest error over [0, {end:g}]",
    "settling": "settling time (– : not settled at the end)",
    "chattering": "mean change from sample to sample over [{start:g}, {end:g}]",
}
_WORSE = "*"
# more quantities than a terminal is wide have rows instead
_MOST_COLUMNS = 9
_BY_STEP = "  ± step"


def tables(dataset: xr.Dataset) -> Iterator[tuple[str, Table]]:
    """Title and table of each measure, a row per observer and the baseline."""
    parameters = json.loads(dataset.attrs["parameters"])
    start, end = parameters["score.start"], parameters["duration"]
    for key, title in _TITLES.items():
        # what does not settle has a peak
        defined = dataset["peak" if key == "settling" else key]
        shown = [q for q in _quantities(dataset) if defined.sel(quantity=q).notnull().any() or key == "rmse"]
        if shown:
            table = _wide if len(shown) <= _MOST_COLUMNS else _long
            yield title.format(start=start, end=end), table(dataset, key, shown)


def _wide(dataset: xr.Dataset, key: str, shown: Sequence[str]) -> Table:
    """A column per quantity, below each number what the step makes of it."""
    table, cell, parts = _table(shown), _cells(dataset, key), _step_errors(dataset, key)
    for estimator in _rows(dataset, key):
        table.add_row(Text(label(estimator)), *(cell(estimator, quantity) for quantity in shown))
        errors = [parts[estimator, quantity] for quantity in shown]
        if any(error >= SHOWN_FROM for error in errors):
            table.add_row(_BY_STEP, *(percent(error) if error >= SHOWN_FROM else "" for error in errors))
    return table


def _long(dataset: xr.Dataset, key: str, shown: Sequence[str]) -> Table:
    """A row per quantity, beside each number what the step makes of it."""
    rows, cell, errors = _rows(dataset, key), _cells(dataset, key), _step_errors(dataset, key)
    coarse = [who for who in rows if any(errors[who, q] >= SHOWN_FROM for q in shown)]
    table = _table([words for who in rows for words in (label(who), *([_BY_STEP.strip()] if who in coarse else []))])
    for quantity in shown:
        cells: list[Text | str] = []
        for who in rows:
            cells.append(cell(who, quantity))
            if who in coarse:
                error = errors[who, quantity]
                cells.append(percent(error) if error >= SHOWN_FROM else "")
        table.add_row(quantity, *cells)
    return table


def _table(columns: Sequence[str]) -> Table:
    table = Table(box=None, padding=(0, 1, 0, 0))
    table.add_column("", no_wrap=True, min_width=8)
    for column in columns:
        table.add_column(column, justify="right", no_wrap=True)
    return table


def _quantities(dataset: xr.Dataset) -> list[str]:
    names: list[str] = dataset.quantity.values.tolist()
    return names


def notes(dataset: xr.Dataset) -> Iterator[str]:
    """Sentences below the tables: what the step and the marks mean, masked time, guards, gain conditions."""
    yield from _step_notes(dataset)
    rmse = numbers(dataset.rmse)
    if any(_worse(rmse, *of) for of in rmse):
        yield f"{_WORSE} worse than the baseline: raw outputs, a constant Δ, zero velocity and zero inputs"
    masked = dataset.masked.sel(estimator="baseline")
    of_muscle: dict[str, list[str]] = {}
    for quantity in _quantities(dataset):
        if muscle := muscle_of(quantity):
            of_muscle.setdefault(muscle, []).append(quantity)
    for muscle, quantities in of_muscle.items():
        if (time := float(masked.sel(quantity=quantities[-1]))) > 0:
            name = label_of(muscle)
            yield f"tendon {name} was slack for {time:.4g}: {', '.join(quantities)} are not scored there"
    yield from _led(dataset)
    parameters = json.loads(dataset.attrs["parameters"])
    if parameters["score.start"] > parameters["duration"]:
        yield "the errors have no window: score.start is after the end of the run, so there is no RMSE"
    if parameters["noise.period"] == 0:
        yield "noise.period = 0: the noise is off, and without samples there is no chattering"
    if unused := json.loads(dataset.attrs["unused"]):
        drive = json.loads(dataset.attrs["choices"])["plant.drive"]
        yield f"without effect while plant.drive = {drive}: {', '.join(unused)}"
    for name, times in json.loads(dataset.attrs["guards"]).items():
        active = ", ".join(f"{guard} {time:.4g}" for guard, time in times.items())
        where = "plant and controller" if name == "truth" else label(name)
        yield f"limits active in {where} (time): {active}"
        if any("infeasible" in guard for guard in times):
            yield "  infeasible: the inputs ask for an activation outside [0, 1]; estimates are limited to it"
    yield from violated_conditions(dataset)


def _led(dataset: xr.Dataset) -> Iterator[str]:
    """How closely a position follows its reference; of a mechanism also in which units all numbers are."""
    start = json.loads(dataset.attrs["parameters"])["score.start"]
    # a plant that failed is nowhere
    known = (dataset.time.values >= start) & dataset.x.notnull().all("state").values
    if "joint" not in dataset:
        if "r" in dataset and known.any():
            off = abs(dataset.x.sel(state="x1") - dataset.r).values[known].max()
            feedback = json.loads(dataset.attrs["choices"]).get(FEEDBACK, STATES)
            sees = "" if feedback == STATES else f", with the controller on the estimates of {label(feedback)}"
            yield f"x1 is within {off:.2g} of its reference from τ = {start:g} on{sees}"
        return
    scales = json.loads(dataset.attrs["scales"])
    if "place" in dataset and known.any():
        off_by = np.abs(dataset["at"].values - dataset["r"].values)[known].max(axis=0)
        for name, off in zip(dataset.place.values.tolist(), off_by.tolist(), strict=True):
            metres = f" ({off * scales['length']:.2g} m)" if "." in name else ""
            yield f"{name} is within {off:.2g}{metres} of its reference from τ = {start:g} on"
    yield (
        f"in units of {dataset.muscle.values[0]}: lengths {scales['length']:.4g} m, forces {scales['force']:.5g} N, "
        f"time {1 / scales['rate']:.4g} s; angles in rad"
    )


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for everything that has no numbers after some time."""
    return list(json.loads(dataset.attrs["failures"]).values())


def _rows(dataset: xr.Dataset, key: str) -> list[str]:
    """Whose measures the table of `key` has; a baseline has errors, and nothing that settles or chatters."""
    estimators: list[str] = dataset.estimator.values.tolist()
    return [name for name in estimators if key == "rmse" or name != BASELINE]


def _cells(dataset: xr.Dataset, key: str) -> Callable[[str, str], Text]:
    """The measure of an estimator and a quantity as a cell of a table."""
    values, rmse = numbers(dataset[key]), numbers(dataset.rmse)

    def cell(estimator: str, quantity: str) -> Text:
        worse = key == "rmse" and _worse(rmse, estimator, quantity)
        return Text(number(values[estimator, quantity]) + (_WORSE if worse else ""), style="red" if worse else "")

    return cell


def _step_errors(dataset: xr.Dataset, key: str) -> dict[tuple[str, str], float]:
    """The errors that the step makes as fractions of the measures; NaN where there is no measure."""
    measure = dataset[key]
    return numbers(measure.copy(data=relative(dataset[error_of(key)].transpose(*measure.dims), measure)))


def _step_notes(dataset: xr.Dataset) -> Iterator[str]:
    """How good the step is, and what the rows of it mean."""
    step = json.loads(dataset.attrs["parameters"])["step"]
    errors = {}
    for key in _TITLES:
        rows = _rows(dataset, key)
        errors[key] = {of: part for of, part in _step_errors(dataset, key).items() if of[0] in rows}
    if known := {where: error for where, error in errors["rmse"].items() if error == error}:
        (estimator, quantity), largest = max(known.items(), key=lambda item: item[1])
        yield f"error of the step {step:g}: at most {percent(largest)} of an RMSE ({label(estimator)} {quantity})"
    if any(error >= SHOWN_FROM for each in errors.values() for error in each.values()):
        yield f"{_BY_STEP}: that error as part of the number above it, from {percent(SHOWN_FROM)} on"


def _worse(rmse: Mapping[tuple[str, str], float], estimator: str, quantity: str) -> bool:
    # a baseline of 0 is the exact output of a run without noise
    return 0 < rmse[BASELINE, quantity] < rmse[estimator, quantity]
