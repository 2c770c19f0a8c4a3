"""What an estimate has to say on a terminal: how it was made, what was limited, how far it is from the truth."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from rich.table import Table
from rich.text import Text

from .....model.arrays import Array
from .....model.skeleton.load import pull
from .....observers import label
from ....estimate.bands.doubt import stated
from ....estimate.dataset import ON_PAPER
from ....estimate.forces import weak
from ....estimate.run import KALMAN
from ....estimate.scores import SETTLED, WITHIN_95, Score
from ....kalman.record import FEW
from ....laboratory.subject import subject_again
from ..conditions import violated_conditions
from ..number import counted, number
from .likelihood import decisions

# a table in the units that muscles have
_SHOWN = ("velocity", "disturbance", "fibre_length", "fibre_velocity", "activation")
# unit of a score → that of the table, and how many of these it is
_UNITS = {**ON_PAPER, "1": ("", 1.0)}
# episodes named one by one
_FEW = 3
# a time from here on has no decimals
_WHOLE = 10.0
# an activation that may be off by more is not known at all
_ALL = 1.0
# nothing follows from activations of which so many are at a limit
_MOST = 0.5
# a step longer than this many of the usual is worth a word
_UNEVEN = 1.1
# the mass's acceleration over the muscles' pull: how steep is clearly against it, and how large is no slow motion,
# in which all forces are in balance; measured on the six public recordings with muscles swapped
_SLOPE, _FAST = 0.05, 0.4


def notes(dataset: xr.Dataset) -> Iterator[str]:
    """Sentences: the recording, the gains and their cost, gaps, slack tendons, what looks wrong, limits."""
    attributes = dataset.attrs
    time, period, longest = dataset.time.values, float(attributes["period"]), float(attributes["longest_step"])
    yield (
        f"{attributes['source']}: {int(attributes['samples']):,} samples, {float(attributes['duration']):.4g} s, "
        f"one every {period * 1e3:.4g} ms"
        + (f", but some after {longest * 1e3:.4g} ms" if longest > _UNEVEN * period else "")
    )
    if int(attributes["samples"]) < FEW:
        yield f"fewer than {FEW} samples tell neither noise nor speed: gains are those of a usual recording"
    if (keep_every := json.loads(attributes["settings"])["keep_every"]) > 1:
        yield f"estimates are kept of every {keep_every}th sample"
    yield from json.loads(attributes["notes"])
    if dataset.bridged.any():
        yield f"gaps bridged by straight lines {_episodes(time, dataset.bridged.values > 0)}"
    for j in dataset.muscle.values.tolist():
        if (slack := dataset.slack.sel(muscle=j).values > 0).any():
            yield f"tendon {j} carries no force {_episodes(time, slack)}: its length and activation mean nothing there"
    yield from _weak(dataset)
    if _against(dataset):
        yield (
            "the mass accelerates against the difference of the tendon forces: either forces from outside rule it, or "
            "the muscles are swapped (muscle 1 pulls towards position 0)"
        )
    gains, substeps, fits = (json.loads(attributes[name]) for name in ("gains", "substeps", "fits"))
    for name in dataset.observer.values.tolist():
        steps = f"{label(name)}: {counted(substeps[name], 'step')} from sample to sample"
        numbers = _gains({path.partition(".")[2]: value for path, value in gains[name].items()})
        yield f"{steps}; {', '.join(numbers)}" if numbers else steps
        if name in fits:
            yield from (f"  {sentence}" for sentence in decisions(fits[name], json.loads(attributes["settings"])))
        of = dataset.sel(observer=name)
        for j in dataset.muscle.values.tolist():
            for what, sentence in (
                ("velocity_limited", f"fibre {j} seems faster than its activation can be computed for"),
                ("activation_limited", f"activation {j} would be below 0 or above 1"),
            ):
                if (active := of[what].sel(muscle=j).values > 0).any():
                    yield f"  {sentence} {_episodes(time, active)}"
    yield from _in_doubt(dataset)
    yield from violated_conditions(dataset)


def _weak(dataset: xr.Dataset) -> Iterator[str]:
    """Forces that no muscle of this size has; of `kalman` the verdict says so."""
    if KALMAN in dataset.observer:
        return
    subject = subject_again(json.loads(str(dataset.muscle_file.values)))
    for (name, muscle), force in zip(subject.forces.items(), dataset.force.values.T, strict=True):
        if force.any():
            yield from filter(None, [weak(name, float(np.nanmax(force)) / muscle.F_max)])


def _gains(numbers: dict[str, float]) -> list[str]:
    """Each number, and of those that several joints or muscles have the least and the largest."""
    by_name: dict[str, dict[str, float]] = {}
    for path, value in numbers.items():
        owner, _, name = path.rpartition(".")
        by_name.setdefault(name, {})[owner] = value
    told = []
    for name, values in by_name.items():
        least, most = min(values, key=values.__getitem__), max(values, key=values.__getitem__)
        same = values[least] == values[most]
        told.append(
            f"{name} = {values[least]:.3g}"
            if same
            else f"{name} = {values[least]:.3g} ({least}) to {values[most]:.3g} ({most})"
        )
    return told


def _in_doubt(dataset: xr.Dataset) -> Iterator[str]:
    """Which numbers are in doubt, and what they do to the activations at most times; of the observer with all parts."""
    observer = next((name for name in dataset.observer.values.tolist() if _knows_noise(dataset, name)), None)
    if "activation_sd_muscle" in dataset:
        of = dataset.sel(observer=observer) if observer else dataset.isel(observer=0)
        off, whose = WITHIN_95 * float(of.activation_sd_muscle.median()), label(str(of.observer.values))
        why = "since the muscles' numbers are known only so well, see --doubt"
        if float(of.activation_limited.mean()) > _MOST:
            yield f"how far the activations of {whose} may be off cannot be told, since most of them are at a limit"
        elif off > _ALL:
            yield f"how far the activations of {whose} may be off cannot be told, {why}"
        elif np.isfinite(off):
            yield f"the activations of {whose} may be off by {number(off)} (95 %, median over time) {why}"
    if doubt := json.loads(dataset.attrs["doubt"]):
        yield f"  standard deviations: {', '.join(f'{name} {sd}' for name, sd in stated(doubt).items())}"


def _knows_noise(dataset: xr.Dataset, observer: str) -> bool:
    return "activation_sd_state" in dataset and bool(dataset.activation_sd_state.sel(observer=observer).notnull().any())


def failures(dataset: xr.Dataset) -> Iterator[str]:
    """A sentence per observer that fails."""
    yield from json.loads(dataset.attrs["failures"]).values()


def timing(dataset: xr.Dataset, reading: float, building: float, following: float) -> str:
    """How long it took, in seconds; what the observers cost is apart from what a compiler or a disk does."""
    each = following / int(dataset.attrs["samples"]) * 1e6
    return (
        f"read in {_seconds(reading)}, observers built in {_seconds(building)}, followed in {_seconds(following)}: "
        f"{each:,.{0 if each >= _WHOLE else 1}f} µs a sample"
    )


def _seconds(value: float) -> str:
    return f"{value:,.0f} s" if value >= _WHOLE else f"{value:.2f} s"


def score_table(scores: Sequence[Score]) -> Table:
    """RMSE of each observer after the first second, all muscles together, and all joints where they have one unit."""
    table = Table(box=None, padding=(0, 2, 0, 0), title=f"RMSE after {SETTLED:g} s", title_justify="left")
    head, *rows = score_cells(scores)
    for heading in head:
        table.add_column(heading, justify="left" if not heading else "right", no_wrap=True)
    for observer, *cells in rows:
        table.add_row(Text(observer), *cells)
    return table


def score_cells(scores: Sequence[Score]) -> list[list[str]]:
    """The same as words: a row of headings, then a row for each observer, which it begins with."""
    by_key = {(s.observer, s.quantity): s for s in scores if s.together}
    units = {s.quantity: _UNITS.get(s.unit, (s.unit, 1.0)) for s in by_key.values()}
    shown = [q for q in _SHOWN if q in units]
    rows = [
        [label(observer), *(number(by_key[observer, q].rmse * units[q][1]) for q in shown)]
        for observer in dict.fromkeys(score.observer for score in scores)
    ]
    head = [f"{q.replace('_', ' ')}{', ' if units[q][0] else ''}{units[q][0]}" for q in shown]
    return [["", *head], *rows]


def _against(dataset: xr.Dataset) -> bool:
    """Whether the mass of a pair clearly accelerates against force_2 − force_1.

    Noise may hide that, but not feign it.
    """
    if "joint" in dataset.dims:
        return False
    late = dataset.isel(observer=0).sel(time=slice(float(dataset.time[0]) + SETTLED, None))
    difference = pull(late.force.values.T)
    # mass · acceleration = R F + disturbance
    total = difference + late.disturbance_hat.values
    if len(difference) < 2 or not np.isfinite(total).all():
        return False
    fast = total.std() > _FAST * difference.std()
    return bool(fast and np.cov(difference, total)[0, 1] < -_SLOPE * difference.var())


def _episodes(time: Array, active: NDArray[np.bool_]) -> str:
    """`from 1.2 to 1.3 s`, or how many times and how long in all."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], active, [False]]).astype(np.int8)))
    starts, ends = edges[::2], edges[1::2] - 1
    if len(starts) <= _FEW:
        return ", ".join(f"from {time[a]:.4g} to {time[b]:.4g} s" for a, b in zip(starts, ends, strict=True))
    return f"{len(starts):,} times, {active.mean():.2%} of the samples, first at {time[starts[0]]:.4g} s"
