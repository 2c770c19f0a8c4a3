"""What a pair of muscles was doing, from a recording of position and tendon forces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from ...codegen.filters import CompiledBank
from ...model.arrays import Array
from ...model.symbols import hat
from ...observers import FOLLOWERS
from ..files.errors import RecordingError, ScenarioError
from ..files.progress import Progress, unseen
from ..files.quote import shown
from ..laboratory.gaps import bridged, refuse_impossible, refuse_long_steps
from ..laboratory.muscles import MusclePair, read_muscles
from ..laboratory.recording import Recording, read_recording
from ..laboratory.scales import scales
from ..scenarios.layers import Value
from ..scenarios.paths import Table, table
from ..scenarios.scenario import checked_number
from .case import Case, Followed
from .dataset import estimate_dataset
from .first_pass import first_pass
from .follow import compiled_bank, curves_of, followed, lengths_block, tendon_lengths
from .gains import gains
from .substeps import substeps

# periods of the muscles' own time 1/v_max between samples beyond which nothing can be followed
_LONGEST_PERIOD = 0.7
# estimates of a sample; 100 million numbers are 1 GB
_NUMBERS, _MOST_NUMBERS = 20, 100_000_000
DEFAULT_OBSERVERS = ("high_gain", "sliding_mode", "adaptive_sliding_mode")


def estimate(
    recording: str | Path | Recording,
    muscles: str | Path | MusclePair,
    observers: Sequence[str] | str | None = None,
    mapping: Mapping[str, str] | None = None,
    corrected: bool = True,
    changes: Mapping[str, Value] | None = None,
    every: int = 1,
    progress: Progress = unseen,
) -> xr.Dataset:
    """Follow a recording with observers and return velocities, lengths, activations and disturbance in SI.

    recording: CSV, .sto or .mot, also gzipped, with time, position, force_1, force_2; or one that was read.
    muscles: a muscle file, or one that was read. observers: names of FOLLOWERS; the paper's three by default.
    mapping: name → column of the file, `column[unit]`. corrected: the sliding mode observers' layers are corrected.
    changes: gains by hand, path → value, such as {"high_gain.eps_h": 0.05}; all others follow the rule, docs/gains.md.
    every: keep the estimates of every so-manieth sample; the observers see all.
    The Dataset has the dimensions time, observer, muscle. RecordingError, ScenarioError for what is wrong with the
    files, BuildError if nothing can be compiled.
    """
    chosen = [observers] if isinstance(observers, str) else list(dict.fromkeys(observers or DEFAULT_OBSERVERS))
    for name in chosen:
        if name not in FOLLOWERS:
            raise ScenarioError(f"unknown observer {shown(name)}; there are {', '.join(FOLLOWERS)}")
    pair = muscles if isinstance(muscles, MusclePair) else read_muscles(muscles)
    read = recording if isinstance(recording, Recording) else read_recording(recording, mapping)
    compiled = compiled_bank(curves_of(pair), corrected)
    numbers = table(compiled.bank.observers)
    by_hand = _checked(changes or {}, numbers, chosen)
    _check_size(len(read), every, len(chosen))
    case = _case(read, pair, compiled, numbers, corrected, every)
    results = {}
    for i, name in enumerate(chosen):

        def share(done: float, before: int = i) -> None:
            progress((before + done) / len(chosen))

        results[name] = _follow(case, compiled, numbers, name, by_hand, share)
    return estimate_dataset(case, results, str(compiled.path.stem))


def _checked(changes: Mapping[str, Value], every: Table, chosen: Sequence[str]) -> dict[str, float]:
    given: dict[str, float] = {}
    for path, value in changes.items():
        if path.partition(".")[0] not in chosen:
            raise ScenarioError(
                f"{shown(path)} is no gain of {', '.join(chosen)}; the muscle file has all other numbers"
            )
        given |= {member: checked_number(member, value, every) for member in every.expand(path)}
    return given


def _check_size(samples: int, every: int, observers: int) -> None:
    if every < 1:
        raise ScenarioError(f"every must be at least 1, not {every}")
    if (size := samples // every * observers * _NUMBERS) > _MOST_NUMBERS:
        least = -(-samples * observers * _NUMBERS // _MOST_NUMBERS)
        raise ScenarioError(
            f"{samples:,} samples make {size:,} estimates, more than memory should hold; "
            f"keep every {least}th (--every {least}) or fewer"
        )


def _case(read: Recording, pair: MusclePair, compiled: CompiledBank, every: Table, corrected: bool, kept: int) -> Case:
    if len(read) < 2:
        raise RecordingError(f"{read.source}: has one row of numbers; observers need two or more")
    refuse_impossible(read, pair)
    inputs, gaps = bridged(read)
    s = scales(pair)
    tau = s.tau(read.time - read.time[0])
    y = np.column_stack([s.lengths(inputs[:, 0]), s.forces(inputs[:, 1]), s.forces(inputs[:, 2])])
    period = float(np.median(np.diff(tau)))
    if period > _LONGEST_PERIOD:
        raise RecordingError(
            f"{read.source}: a sample every {period / s.rate:.3g} s is too few for muscles of v_max = {s.rate:g}/s; "
            f"at most {_LONGEST_PERIOD / s.rate:.3g} s; is time in another unit?"
        )
    refuse_long_steps(read)
    z = tendon_lengths(compiled, np.array(every.values(lengths_block(compiled.bank), s.numbers)), y)
    # acc = (y₃ − y₂)/m
    sizes = first_pass(y[:, 0], z[:, 0], z[:, 1], (y[:, 2] - y[:, 1]) / s.numbers["plant.m"], period)
    return Case(read, pair, s, tau, y, z, gaps, sizes, corrected, kept)


def _follow(
    case: Case, compiled: CompiledBank, every: Table, name: str, by_hand: Mapping[str, float], progress: Progress
) -> Followed:
    block = next(block for block in compiled.bank.observers if block.name == name)
    own = {path: value for path, value in by_hand.items() if path.partition(".")[0] == name}
    chosen = {**gains(name, case.sizes, case.period), **own}
    # an observer that is not corrected has no use for some
    chosen = {path: value for path, value in chosen.items() if path.partition(".")[2] in block.p}
    steps = substeps(name, chosen, case.period)
    given = {**case.scales.numbers, **chosen, **_start(case)}
    numbers = np.array(every.values(block, given))
    kept = len(range(len(case.tau))[case.kept])
    y, guards, place = np.empty((kept, len(block.y))), np.empty((kept, len(block.guards))), 0
    for piece, outputs, active in followed(compiled, name, numbers, steps, case.period, case.tau, case.y):
        wanted = slice(-piece.start % case.every, None, case.every)
        here = slice(place, place + len(outputs[wanted]))
        y[here], guards[here], place = outputs[wanted], active[wanted], here.stop
        progress(min(piece.stop, len(case.tau)) / len(case.tau))
    return Followed(_named(block.y, y), _named(block.guards, guards), chosen, steps)


def _start(case: Case) -> dict[str, float]:
    """x̂(0) from the first sample."""
    x = (case.y[0, 0], 0.0, case.z[0, 0], case.z[0, 1])
    return {f"initial.{hat(f'x{i}')}": float(value) for i, value in enumerate(x, start=1)}


def _named(names: Mapping[str, object], columns: Array) -> dict[str, Array]:
    return {name: columns[:, i] for i, name in enumerate(names)}
