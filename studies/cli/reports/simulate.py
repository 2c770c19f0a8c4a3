"""What a run has to say on a terminal: tables of measures, warnings, guards, failures."""

from __future__ import annotations

import json
from collections.abc import Iterator

import xarray as xr
from rich.table import Table
from rich.text import Text

from ....model.symbols import QUANTITIES
from ....observers import label
from ...scenarios.prepare import BASELINE
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
_BY_STEP = "  ± step"


def tables(dataset: xr.Dataset) -> Iterator[tuple[str, Table]]:
    """Title and table of each measure, a row per observer and the baseline."""
    parameters = json.loads(dataset.attrs["parameters"])
    start, end = parameters["score.start"], parameters["duration"]
    for key, title in _TITLES.items():
        table = Table(box=None, padding=(0, 1, 0, 0))
        table.add_column("", no_wrap=True, min_width=8)
        # what does not settle has a peak
        defined = dataset["peak" if key == "settling" else key]
        shown = [q for q in QUANTITIES if defined.sel(quantity=q).notnull().any() or key == "rmse"]
        for quantity in shown:
            table.add_column(quantity, justify="right", no_wrap=True)
        for estimator in _rows(dataset, key):
            cells = [_cell(dataset, key, estimator, quantity) for quantity in shown]
            table.add_row(Text(label(estimator)), *cells)
            errors = [_step_error(dataset, key, estimator, quantity) for quantity in shown]
            if any(error >= SHOWN_FROM for error in errors):
                table.add_row(_BY_STEP, *(percent(error) if error >= SHOWN_FROM else "" for error in errors))
        if shown:
            yield title.format(start=start, end=end), table


def notes(dataset: xr.Dataset) -> Iterator[str]:
    """Sentences below the tables: what the step and the marks mean, masked time, guards, gain conditions."""
    yield from _step_notes(dataset)
    if _any_worse(dataset):
        yield f"{_WORSE} worse than the baseline: raw outputs, a constant Δ, zero velocity and zero inputs"
    masked = dataset.masked.sel(estimator="baseline")
    for muscle, quantities in ((1, "x3, u1, a1"), (2, "x4, u2, a2")):
        if (time := float(masked.sel(quantity=f"a{muscle}"))) > 0:
            yield f"tendon {muscle} was slack for {time:.4g}: {quantities} are not scored there"
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


def failures(dataset: xr.Dataset) -> list[str]:
    """A sentence for everything that has no numbers after some time."""
    return list(json.loads(dataset.attrs["failures"]).values())


def _rows(dataset: xr.Dataset, key: str) -> list[str]:
    """Whose measures the table of `key` has; a baseline has errors, and nothing that settles or chatters."""
    estimators: list[str] = dataset.estimator.values.tolist()
    return [name for name in estimators if key == "rmse" or name != BASELINE]


def _cell(dataset: xr.Dataset, key: str, estimator: str, quantity: str) -> Text:
    value = float(dataset[key].sel(estimator=estimator, quantity=quantity))
    worse = key == "rmse" and _worse(dataset, estimator, quantity)
    return Text(number(value) + (_WORSE if worse else ""), style="red" if worse else "")


def _step_error(dataset: xr.Dataset, key: str, estimator: str, quantity: str) -> float:
    """The error that the step makes as a fraction of the measure; NaN where there is no measure."""
    measure, error = (float(dataset[name].sel(estimator=estimator, quantity=quantity)) for name in (key, error_of(key)))
    return float(relative(error, measure))


def _step_notes(dataset: xr.Dataset) -> Iterator[str]:
    """How good the step is, and what the rows of it mean."""
    step = json.loads(dataset.attrs["parameters"])["step"]
    errors = {
        key: {(who, q): _step_error(dataset, key, who, q) for who in _rows(dataset, key) for q in QUANTITIES}
        for key in _TITLES
    }
    if known := {where: error for where, error in errors["rmse"].items() if error == error}:
        (estimator, quantity), largest = max(known.items(), key=lambda item: item[1])
        yield f"error of the step {step:g}: at most {percent(largest)} of an RMSE ({label(estimator)} {quantity})"
    if any(error >= SHOWN_FROM for each in errors.values() for error in each.values()):
        yield f"{_BY_STEP}: that error as part of the number above it, from {percent(SHOWN_FROM)} on"


def _worse(dataset: xr.Dataset, estimator: str, quantity: str) -> bool:
    rmse = dataset.rmse.sel(quantity=quantity)
    trivial = float(rmse.sel(estimator="baseline"))
    # a baseline of 0 is the exact output of a run without noise
    return 0 < trivial < float(rmse.sel(estimator=estimator))


def _any_worse(dataset: xr.Dataset) -> bool:
    return any(_worse(dataset, e, q) for e in dataset.estimator.values for q in QUANTITIES)
