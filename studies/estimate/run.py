"""What a pair of muscles was doing, from a recording of position and tendon forces."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from ...codegen.recordings.filters import CompiledBank
from ...model.arrays import Array
from ...model.block import Block
from ...observers import OBSERVERS, Observer
from ..files.errors import RecordingError, ScenarioError
from ..files.numbers import number, switch, whole
from ..files.progress import Progress, shares, unseen
from ..files.quote import shown, table
from ..kalman.apart.record import RecordApart
from ..kalman.record import Record
from ..kalman.run import AUTO, FORMS
from ..laboratory.gaps import bridged, refuse_impossible, refuse_long_steps
from ..laboratory.mechanisms.mechanism import Mechanism
from ..laboratory.muscles import MusclePair
from ..laboratory.recording import Recording, read_recording
from ..laboratory.samples import MOST_NUMBERS
from ..laboratory.subject import Subject, pair_subject, subject_of
from ..scenarios.layers import Value
from ..scenarios.observers import Observers, observers_named
from ..scenarios.paths import Paths
from .bands.doubt import doubts
from .bands.muscle import compile_sensitivities
from .case import Case, Result, Settings
from .conditions import gain_conditions
from .dataset import estimate_dataset
from .fitted import compile_passes, fitted_result, pair_record, record_apart
from .follow import chosen_bank, chosen_whole, compiled_bank, followed, lengths_block, measured_tendons, observer_paths
from .sizes.first_pass import compile_first_pass, first_pass
from .start import at_rest, begun, gains_by_hand, gains_of_block, gains_of_rule, too_rare

# estimates of a sample with their standard deviations; 250 million numbers are 2 GB
_NUMBERS, _MOST_NUMBERS = 50, 250_000_000

KALMAN = "kalman"


def estimate(
    recording: str | Path | Recording,
    muscles: str | Path | MusclePair | Mechanism | Subject,
    observers: Observers = None,
    mapping: Mapping[str, str] | None = None,
    corrected: bool = True,
    changes: Mapping[str, Value] | None = None,
    keep_every: int = 1,
    progress: Progress | None = None,
    form: str = AUTO,
    smooth: bool = False,
    lag: float = 0.0,
    doubt: Mapping[str, float | str] | None = None,
    usual_doubt: bool = True,
) -> xr.Dataset:
    """Follow a recording with observers and return velocities, lengths, activations and disturbance in SI.

    recording: CSV, .sto or .mot, also gzipped, with time, position, force_1, force_2; or one that was read.
    muscles: a muscle or mechanism file, or one that was read; a mechanism's columns are named after its joints and
    muscles, docs/mechanisms.md. observers: registered names, or Blocks of your own, which have their
    own numbers, known to no rule; the paper's three by default. mapping: name → column of the file, `column[unit]`.
    corrected: the sliding mode observers' layers are corrected. changes: gains by hand, path → value, such as
    {"high_gain.eps_h": 0.05}; all others follow the rule, docs/gains.md. keep_every: keep every n-th estimate; the
    observers see all samples. progress: given the part that is done, of reading and of each observer.
    The rest concerns the Kalman filter. form: what its chains of integrators are, inputs "u" or activations "a", or
    "auto": what the recording is likelier for. smooth: estimates know all samples. lag: s that they may be late, to
    know the samples until then; by default they know no later sample.
    doubt: how far numbers may be off, such as {"optimal_fibre_length": "3%", "muscle1.F_max": 50, "force_bias": "5N"};
    beside these count those of the muscle file and the usual ones, docs/observers.md#bands, unless not usual_doubt.
    The Dataset has the dimensions time, observer, muscle, of a mechanism also joint.
    RecordingError, ScenarioError for what is wrong with the
    files, BuildError if nothing can be compiled.

    >>> estimates = hillobs.estimate("run.csv", "pair.toml", "high_gain", mapping={"position": "block x[mm]"})
    >>> error = estimates.activation_hat - estimates.true_activation
    >>> print(f"{error.sel(time=slice(1, None)).std().item():.3f}")
    0.012
    """
    chosen = observers_named(observers)
    subject = subject_of(muscles)
    bank = chosen_bank(subject, switch("corrected", corrected), chosen)
    whole = chosen_whole(subject, corrected, chosen)
    paths = observer_paths(subject.system, bank, whole)
    settings = _settings(corrected, changes or {}, keep_every, paths, chosen)
    settings = replace(settings, **_smoothing(chosen, form, smooth, lag))
    known = doubts(subject, {} if doubt is None else doubt, switch("usual_doubt", usual_doubt))
    if isinstance(recording, Recording):
        parts, read = shares(progress or unseen, [1] * len(chosen)), recording
    else:
        parts = shares(progress or unseen, [1] * (1 + len(chosen)))
        read = read_recording(recording, mapping, next(parts), subject.columns)
    _check_size(len(read), settings.keep_every, len(chosen))
    compiled = compiled_bank(bank)
    case = _case(read, subject, compiled, paths, settings, known)
    blocks = {block.name: block for block in (*bank.observers, *whole)}
    results = {
        name: (_pass if observer.fitted else _follow)(case, compiled, paths, blocks[name], observer, next(parts))
        for name, observer in chosen.items()
    }
    return estimate_dataset(case, results, str(compiled.path.stem))


def compile_observers(subject: Subject, observers: Observers = None, corrected: bool = True) -> None:
    """Compile what `estimate` needs for these, or load it from the cache: once, and then estimates begin at once."""
    compile_first_pass(subject.system)
    chosen = observers_named(observers)
    compiled_bank(chosen_bank(subject, corrected, chosen))
    compile_sensitivities(subject)
    if any(observer.fitted for observer in chosen.values()):
        compile_passes(subject.system)


def recorded(
    read: Recording, pair: MusclePair, changes: Mapping[str, float] = MappingProxyType({})
) -> tuple[Case, Record]:
    """A recording with its muscles, and as the Kalman filter takes it. RecordingError for what no muscle can do.

    changes: path → value of its numbers by hand.
    """
    case, numbers = _recorded(read, pair_subject(pair), changes)
    return case, pair_record(case, numbers)


def recorded_apart(
    read: Recording, subject: Subject, changes: Mapping[str, float] = MappingProxyType({})
) -> tuple[Case, RecordApart]:
    """The same of a mechanism."""
    case, numbers = _recorded(read, subject, changes)
    return case, record_apart(case, numbers)


def _recorded(read: Recording, subject: Subject, changes: Mapping[str, float]) -> tuple[Case, dict[str, float]]:
    chosen = observers_named(KALMAN)
    bank, (block,) = chosen_bank(subject, True, chosen), chosen_whole(subject, True, chosen)
    paths = observer_paths(subject.system, bank, [block])
    case = _case(read, subject, compiled_bank(bank), paths, Settings(True, changes, 1), {})
    return case, _numbers(case, paths, block)


def _smoothing(chosen: Mapping[str, Observer], form: str, smooth: bool, lag: float) -> dict[str, Any]:
    """What was asked of the Kalman filter. ScenarioError says what is wrong, or that there is none to be asked."""
    if form not in FORMS:
        raise ScenarioError(f"unknown form {shown(form)}; there are {', '.join(FORMS)}")
    smooth, lag = switch("smooth", smooth), number("lag", lag)
    if lag < 0:
        raise ScenarioError(f"lag must be 0 s or more, not {lag:g} s")
    if smooth and lag:
        raise ScenarioError("smooth knows all samples; a lag beside it means nothing")
    if (smooth or lag or form != AUTO) and not any(observer.fitted for observer in chosen.values()):
        able = ", ".join(name for name, observer in OBSERVERS.items() if observer.fitted)
        raise ScenarioError(f"form, smooth and lag are for {able}, which is not among the observers asked for")
    return {"form": form, "smooth": smooth, "lag": lag}


def _settings(
    corrected: bool, changes: Mapping[str, Value], keep_every: int, paths: Paths, chosen: Mapping[str, Observer]
) -> Settings:
    """What was asked for, checked before anything is read. ScenarioError says what is wrong."""
    keep_every = whole("keep_every", keep_every, 1, MOST_NUMBERS)
    return Settings(corrected, gains_by_hand(table("changes", changes), chosen, paths), keep_every)


def _check_size(samples: int, keep_every: int, observers: int) -> None:
    if (size := samples // keep_every * observers * _NUMBERS) > _MOST_NUMBERS:
        least = -(-samples * observers * _NUMBERS // _MOST_NUMBERS)
        raise ScenarioError(
            f"{samples:,} samples make {size:,} estimates, more than memory should hold; "
            f"keep every {least}th (--every {least}) or fewer"
        )


def _case(
    read: Recording,
    subject: Subject,
    compiled: CompiledBank,
    paths: Paths,
    settings: Settings,
    doubt: Mapping[str, float],
) -> Case:
    if len(read) < 2:
        raise RecordingError(f"{read.source}: has one row of numbers; observers need two or more")
    refuse_impossible(read, subject)
    inputs, gaps = bridged(read)
    s, system = subject.scales, subject.system
    tau = s.tau(read.time - read.time[0])
    joints = len(system.joints)
    y = np.column_stack([inputs[:, :joints] / s.coordinates, s.forces(inputs[:, joints:])])
    period = float(np.median(np.diff(tau)))
    if objection := too_rare(period / s.rate, s):
        raise RecordingError(f"{read.source}: {objection}; is time in another unit?")
    refuse_long_steps(read)
    z, slopes = measured_tendons(compiled, np.array(paths.values(lengths_block(compiled.bank), s.numbers)), y)
    sizes = first_pass(subject.laws, y, z, period, tau)
    return Case(read, subject, tau, y, z, slopes, gaps, sizes, settings, doubt)


def _pass(
    case: Case, compiled: CompiledBank, paths: Paths, block: Block, observer: Observer, progress: Progress
) -> Result:
    return fitted_result(case, block, _numbers(case, paths, block), progress)


def _numbers(case: Case, paths: Paths, block: Block) -> dict[str, float]:
    values = paths.values(block, {**case.scales.numbers, **case.settings.changes, **_start(case)})
    return dict(zip(block.p, values, strict=True))


def _follow(
    case: Case, compiled: CompiledBank, paths: Paths, block: Block, observer: Observer, progress: Progress
) -> Result:
    name = block.name
    rule = gains_of_rule(observer, case.subject.system, block, case.sizes, case.period)
    gains = {**rule, **gains_of_block(block, case.settings.changes)}
    first = [*case.y[0], *case.z[0]]
    numbers, steps = begun(observer, case.subject, paths, block, gains, first, case.period)
    checked = gain_conditions(observer, case.subject.system, numbers, case.sizes, case.period / steps)
    violated = [condition for condition in checked if not condition.holds]
    filter_ = compiled.follow(name, list(numbers.values()), steps)
    kept = len(range(len(case.tau))[case.kept])
    y, guards, place = np.empty((kept, len(block.y))), np.empty((kept, len(block.guards))), 0
    # what moves at samples only knows how long a step is, and needs none filled in
    longest = math.inf if block.sampled else case.period
    for piece, outputs, active in followed(filter_, longest, case.tau, case.y):
        chosen = slice(-piece.start % case.settings.keep_every, None, case.settings.keep_every)
        here = slice(place, place + len(outputs[chosen]))
        y[here], guards[here], place = outputs[chosen], active[chosen], here.stop
        progress(min(piece.stop, len(case.tau)) / len(case.tau))
    return Result(_named(block.y, y), _named(block.guards, guards), gains, steps, violated, filter_.failure)


def _start(case: Case) -> dict[str, float]:
    """x̂(0) from the first sample."""
    return at_rest(case.subject.system, [*case.y[0, : len(case.subject.system.joints)], *case.z[0]])


def _named(names: Mapping[str, object], columns: Array) -> dict[str, Array]:
    return {name: columns[:, i] for i, name in enumerate(names)}
