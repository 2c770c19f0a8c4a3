"""What a sweep has to say on a terminal: where the median error is smallest, what failed, which gains are too small."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr
from rich.table import Table
from rich.text import Text

from ....model.arrays import Array
from ....observers import label
from ...simulate.step_error import SHOWN_FROM, error_of, relative
from ...sweep.optimum import (
    Optimum,
    at_scenario,
    axes_of,
    held,
    medians,
    optimum,
    own_value,
    parameters_of,
    shown_of,
    varied,
)
from ...sweep.region import where
from .number import counted, number, percent

_SHOWN = ("x2", "Delta", "u1", "u2", "a1", "a2")
# characters of a word that a heading has room for
_LONG = 13
# a larger change is said as a factor
_DOUBLED = 1.0


def tables(dataset: xr.Dataset) -> list[Table]:
    """The optima of observers that have parameters of their own in the sweep, and how much the errors of others change.

    A sweep over seeds alone has neither: the medians.
    """
    if not varied(dataset):
        rows = [(who, quantity, number(median.item())) for who, quantity, median, _ in _errors(dataset)]
        return [_table(["median RMSE"], rows)]
    compared = dataset.attrs["kind"] == "grid"
    paths, scenario = list(axes_of(dataset).paths), ["scenario's\nown"] * compared
    optima, spreads = [], []
    for who, quantity, median, best in _errors(dataset):
        at = [number(at_scenario(dataset, median))] * compared
        if best is None:
            least, largest = float(median.min()), float(median.max())
            spreads.append((who, quantity, *at, number(least), number(largest), _change(least, largest)))
        else:
            values = [f"{best.values[path]:.4g}" if path in best.values else "" for path in paths]
            optima.append((who, quantity, *values, number(best.error), *at, _remark(best)))
    headings = [_heading(path) for path in paths]
    each = (
        (optima, [*headings, "median\nRMSE", *scenario, ""]),
        (spreads, [*scenario, "least\nmedian", "largest\nmedian", "change"]),
    )
    return [_table(columns, rows) for rows, columns in each if rows]


def step_table(dataset: xr.Dataset) -> Iterator[Table]:
    """How much of the RMSE the step makes in the runs sampled, where that is much; nothing if it is not."""
    rows = [
        (who, quantity, percent(float(parts.max())), f"{(parts >= SHOWN_FROM).sum()}")
        for who, quantity, parts in _step_errors(dataset)
        if parts.max() >= SHOWN_FROM
    ]
    if rows:
        yield _table(["largest\n± step", f"runs from\n{percent(SHOWN_FROM)} on"], rows)


def notes(dataset: xr.Dataset) -> Iterator[str]:
    """Sentences above the tables: how many runs, what failed, the step, gain conditions, what is compared."""
    runs = counted(dataset.plant_failed_at.size, "run")
    yield f"{runs} of {dataset.attrs['scenario']}, {dataset.sizes['seed']:,} per point"
    yield from _failures(dataset, "the plant", dataset.plant_failed_at, dataset.plant_failure)
    for observer in dataset.observer.values.tolist():
        of = dataset.sel(observer=observer)
        yield from _failures(dataset, label(observer), of.failed_at, of.failure)
    yield from _step_note(dataset)
    broken = json.loads(dataset.attrs["violated_conditions"])
    each = [(label(name), sentence) for name, sentences in broken.items() for sentence in sentences]
    for i, (who, sentence) in enumerate(each):
        yield f"gain condition ({i + 1}) of {who}: {sentence}"
    yield from _comparison(dataset)


def _step_errors(dataset: xr.Dataset) -> Iterator[tuple[str, str, Array]]:
    """Each observer and quantity, and what the step makes of its RMSE in the runs sampled, as fractions."""
    each = dataset.rmse.values.reshape(-1, dataset.sizes["observer"], dataset.sizes["quantity"])
    parts = relative(dataset[error_of("rmse")].values, each[dataset.sampled.values])
    for i, observer in enumerate(dataset.observer.values.tolist()):
        for j, quantity in enumerate(dataset.quantity.values.tolist()):
            if (known := parts[~np.isnan(parts[:, i, j]), i, j]).size:
                yield label(observer), quantity, known


def _step_note(dataset: xr.Dataset) -> Iterator[str]:
    """How good the step is, and in which runs that was tried."""
    largest = [(float(parts.max()), who, quantity) for who, quantity, parts in _step_errors(dataset)]
    if largest:
        part, who, quantity = max(largest)
        tried, runs = dataset.sizes["sampled"], counted(dataset.plant_failed_at.size, "run")
        yield f"error of the step: at most {percent(part)} of an RMSE ({who} {quantity}), tried in {tried} of {runs}"


def _errors(dataset: xr.Dataset) -> Iterator[tuple[str, str, xr.DataArray, Optimum | None]]:
    """Each observer and quantity with a number: its median errors, and their optimum if it has one."""
    errors = medians(dataset)
    for observer in dataset.observer.values.tolist():
        for quantity in shown_of(dataset, _SHOWN):
            median = errors.sel(observer=observer, quantity=quantity)
            if median.notnull().any():
                yield label(observer), quantity, median, optimum(dataset, median, observer)


def _table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> Table:
    table = Table(box=None, padding=(0, 1, 0, 0))
    for heading in ("", "quantity", *columns):
        left = heading in ("", "quantity")
        table.add_column(heading, no_wrap=True, justify="left" if left else "right", vertical="bottom")
    for who, *row in rows:
        table.add_row(Text(who), *row)
    return table


def _heading(path: str) -> str:
    """A path over several lines: broken behind dots, and behind the first underscore of a long word."""
    words = path.split(".")
    return ".\n".join(word.replace("_", "_\n", 1) if len(word) > _LONG else word for word in words)


def _remark(best: Optimum) -> str:
    """Why an optimum may be none; the numbers are those of the notes."""
    words = [f"edge of {', '.join(path.partition('.')[2] for path in best.edges)}"] if best.edges else []
    if best.violated:
        numbers = " ".join(f"({place + 1})" for place in best.violated)
        words.append(f"{numbers} fail{'s' if len(best.violated) == 1 else ''}")
    return ", ".join(words)


def _change(least: float, largest: float) -> str:
    """How much larger the largest is."""
    if least == largest:
        return "none"
    if least > 0 and largest / least - 1 < _DOUBLED:
        return f"{100 * (largest / least - 1):.2g} %"
    return f"× {largest / least:.3g}" if least > 0 else "–"


def _failures(dataset: xr.Dataset, who: str, times: xr.DataArray, causes: xr.DataArray) -> Iterator[str]:
    """How often, how early and where it failed, and the commonest cause with the points where it was the cause."""
    lost = int(times.notnull().sum())
    if not lost:
        return
    places = causes.values[causes.values > 0]
    most = int(np.bincount(places).argmax())
    name = str(causes.attrs["flag_meanings"]).split()[most]
    at = where(axes_of(dataset), (causes == most).any("seed").values.ravel())
    yield f"{who} failed in {lost:,} of them, first at τ = {float(times.min()):g}"
    yield f"  commonest cause: {name} ({counted(int((places == most).sum()), 'run')}), {at}"


def _comparison(dataset: xr.Dataset) -> Iterator[str]:
    """What the columns of the tables mean where it is not plain."""
    paths, grid = varied(dataset), dataset.attrs["kind"] == "grid"
    if grid and paths:
        at = {path: own_value(dataset, path) for path in paths}
        if None not in at.values():
            words = ", ".join(f"{path} = {value:g}" for path, value in at.items())
            yield f"scenario's own: {words}, or the swept value nearest to it"
    yield from _sought(dataset)


def _sought(dataset: xr.Dataset) -> Iterator[str]:
    """What the optima are sought over, why there are none, and what an edge means."""
    observers = dataset.observer.values.tolist()
    chosen = [path for path in varied(dataset) if any(path in parameters_of(dataset, name) for name in observers)]
    if not chosen:
        return
    places, optima = held(dataset), [best for *_, best in _errors(dataset) if best]
    at = [f"{path} = {dataset[path].values[place]:.4g}" for path, place in places.items() if place is not None]
    if lost := [path for path, place in places.items() if place is None]:
        yield f"no optimum over {', '.join(chosen)}: {', '.join(lost)} cannot be held at one value of the scenario's"
    elif at:
        yield f"smallest over {', '.join(chosen)}, at {', '.join(at)}, the nearest to the scenario's"
    if any(best.edges for best in optima):
        yield "edge: the least or the largest value that was swept; the optimum may lie beyond"
