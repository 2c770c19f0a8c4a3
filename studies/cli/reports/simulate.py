"""What a run has to say on a terminal: tables of measures, warnings, guards, failures."""

from __future__ import annotations

import json
from collections.abc import Iterator

import xarray as xr
from rich.table import Table
from rich.text import Text

from ....model.symbols import QUANTITIES
from ....observers import label
from .conditions import violated_conditions
from .number import number

_TITLES = {
    "rmse": "root mean square error over [{start:g}, {end:g}]",
    "peak": "largest error over [0, {end:g}]",
    "settling": "settling time (– : not settled at the end)",
    "chattering": "mean change from sample to sample over [{start:g}, {end:g}]",
}
_WORSE = "*"


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
        for estimator in dataset.estimator.values.tolist():
            if key == "rmse" or estimator != "baseline":
                cells = [_cell(dataset, key, estimator, quantity) for quantity in shown]
                table.add_row(Text(label(estimator)), *cells)
        if shown:
            yield title.format(start=start, end=end), table


def notes(dataset: xr.Dataset) -> Iterator[str]:
    """Sentences below the tables: what the marks mean, masked time, guards, gain conditions, failures."""
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


def _cell(dataset: xr.Dataset, key: str, estimator: str, quantity: str) -> Text:
    value = float(dataset[key].sel(estimator=estimator, quantity=quantity))
    worse = key == "rmse" and _worse(dataset, estimator, quantity)
    return Text(number(value) + (_WORSE if worse else ""), style="red" if worse else "")


def _worse(dataset: xr.Dataset, estimator: str, quantity: str) -> bool:
    rmse = dataset.rmse.sel(quantity=quantity)
    trivial = float(rmse.sel(estimator="baseline"))
    # a baseline of 0 is the exact output of a run without noise
    return 0 < trivial < float(rmse.sel(estimator=estimator))


def _any_worse(dataset: xr.Dataset) -> bool:
    return any(_worse(dataset, e, q) for e in dataset.estimator.values for q in QUANTITIES)
