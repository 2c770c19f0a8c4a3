"""The Kalman filter over a whole recording: orders and densities, the form, and the estimates, causal or smoothed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...model.arrays import Array
from ...model.system import pair_system
from ...observers.kalman.activations import ACTIVATIONS_MODEL
from ...observers.kalman.inputs import INPUTS_MODEL
from ...observers.kalman.parameters import resolved, slowest
from ...observers.ports import ESTIMATES
from ..files.progress import Progress, shares, unseen
from .muscles import ACTIVATION, LAW, SPREAD, compiled_muscles
from .orders import Choice, chosen_activations, chosen_inputs
from .passes import CompiledPasses, Filtered, compiled, row_names, table
from .record import Record, segments, settled

INPUTS, ACTIVATIONS, AUTO = "u", "a", "auto"
FORMS = (AUTO, INPUTS, ACTIVATIONS)
# samples that are passed at once: 2 kB each
_PIECE = 50_000
# a smoother looks ahead for so many of its slowest time constants: what is later changes nothing
_AHEAD = 30.0
# shares of the time: densities of each form, passes
_FIT, _PASS = 3.0, 1.0


@dataclass(frozen=True)
class How:
    """What is asked for. lag: samples that a smoother looks ahead, None: all; 0: none, the filter."""

    form: str = AUTO
    lag: int | None = 0

    @property
    def causal(self) -> bool:
        """Whether an estimate knows no later sample."""
        return self.lag == 0


@dataclass(frozen=True, eq=False)
class Passed:
    """The choices made, and each estimate, standard deviation and guard (kept samples) by name."""

    form: str
    inputs: Choice
    activations: Choice | None
    outputs: Mapping[str, Array]


# what is told of some samples (n × names) → outputs by name
Outputs = Callable[[Array], dict[str, Array]]


def passed(record: Record, how: How, by_hand: Mapping[str, float], keep_every: int, progress: Progress) -> Passed:
    """The estimates of a recording, of every n-th sample.

    by_hand: numbers of the filter that are to stay as they are.
    """
    parts, whole = shares(progress, [_FIT, _FIT, 2 * _PASS]), record.table()
    fitted_to = [settled(whole[part]) for part in segments(len(record))]
    inputs = chosen_inputs(record, fitted_to, by_hand, next(parts))
    second = next(parts)
    activations = None if how.form == INPUTS else _second(record, fitted_to, inputs, how, by_hand, second)
    second(1.0)
    form, outputs = estimated(record, how, inputs, activations, keep_every, next(parts))
    return Passed(form, inputs, activations, outputs)


def causal_inputs(record: Record, by_hand: Mapping[str, float]) -> Choice:
    """The model of the first pass by all samples of a recording; by_hand: orders that are known."""
    return chosen_inputs(record, [settled(record.table(), record.settling)], by_hand)


def causal_choices(record: Record, by_hand: Mapping[str, float]) -> tuple[Choice, Choice]:
    """Both models for causal estimates, by all samples of a recording; by_hand: orders that are known."""
    inputs = causal_inputs(record, by_hand)
    of_second = {name: value for name, value in by_hand.items() if name == "order_a"}
    return inputs, _second(record, [settled(record.table(), record.settling)], inputs, How(), of_second)


def estimated(
    record: Record, how: How, inputs: Choice, activations: Choice | None, keep_every: int, progress: Progress
) -> tuple[str, dict[str, Array]]:
    """The form that counts, and by name every n-th estimate, standard deviation and guard."""
    whole, ahead = record.table(), _ahead(record, inputs)
    if activations is None or form_of(how, inputs, activations) == INPUTS:
        told = over(compiled(INPUTS_MODEL), inputs.fit.numbers, whole, how, ahead)
        return INPUTS, _collected(told, _of_inputs(record), keep_every, len(record), progress)
    before, after = shares(progress, [_PASS, _PASS])
    rows = _linear(record, whole, inputs, how)
    before(1.0)
    told = over(compiled(ACTIVATIONS_MODEL), activations.fit.numbers, rows, how, ahead)
    return ACTIVATIONS, _collected(told, _of_activations, keep_every, len(record), after)


def _second(
    record: Record,
    tables: Sequence[Array],
    inputs: Choice,
    how: How,
    by_hand: Mapping[str, float],
    progress: Progress = unseen,
) -> Choice:
    linear = [_linear(record, rows, inputs, how) for rows in tables]
    return chosen_activations(record, linear, inputs, by_hand, progress)


def estimates_of_inputs(record: Record, inputs: Choice) -> Array:
    """The causal estimates (n × ESTIMATES) of the first pass."""
    return _whole(record, inputs, record.table(), How())


def innovations(record: Record, numbers: Mapping[str, float]) -> Array:
    """The innovations of the first pass over their standard deviations (n × 3); NaN where a sample does not count."""
    return innovation_ratios(compiled(INPUTS_MODEL), {**record.numbers, **numbers}, record.table())


def innovation_ratios(passes: CompiledPasses, numbers: Mapping[str, float], rows: Array) -> Array:
    """Those of a table (n × measurements)."""
    rows = settled(rows)
    pieces = _filtered(passes, numbers, rows)
    ratios: Array = np.concatenate([filtered.nu / np.sqrt(filtered.S) for _, _, filtered in pieces])
    ratios[rows[:, -1] == 0] = np.nan
    return ratios


def over(passes: CompiledPasses, numbers: Mapping[str, float], rows: Array, how: How, ahead: int) -> Iterator[Array]:
    """What is told of the samples, piece by piece; a smoother looks `ahead` so many samples beyond a piece."""
    beyond = ahead if how.lag is None else how.lag
    for start, motions, filtered in _filtered(passes, numbers, rows):
        if how.causal:
            # a copy: as a part of all results it would keep them
            yield filtered.told.copy()
            continue
        length = len(motions)
        after = rows[start + length : start + length + beyond]
        if len(after):
            moved = passes.motions(numbers, after, rows[start + length - 1])
            filtered = filtered.followed_by(passes.filtered(numbers, filtered.carry, after, moved))
            motions = np.concatenate([motions, moved])
        seen = rows[start : start + len(motions)]
        yield passes.smoothed(numbers, seen, motions, filtered, how.lag or 0).told[:length].copy()


def ahead(w: float, T: float) -> int:
    """Samples, T apart, after which a smoother whose slowest chain has the frequency w has nothing more to learn."""
    return min(math.ceil(_AHEAD / (w * T)), _PIECE)


def _filtered(
    passes: CompiledPasses, numbers: Mapping[str, float], rows: Array
) -> Iterator[tuple[int, Array, Filtered]]:
    """Where a piece of the samples begins, the motions in it, and the filter over it."""
    carry = passes.start(numbers, rows[0])
    for start in range(0, len(rows), _PIECE):
        piece = rows[start : start + _PIECE]
        motions = passes.motions(numbers, piece, rows[max(start - 1, 0)])
        filtered = passes.filtered(numbers, carry, piece, motions)
        carry = filtered.carry
        yield start, motions, filtered


def form_of(how: How, inputs: Choice, activations: Choice) -> str:
    """The likelier form, unless one is asked for."""
    if how.form != AUTO:
        return how.form
    # a smoother does without the second pass where the inputs are abrupt: the likelihood looks one sample ahead only
    abrupt = inputs.orders[-1] == 1 and not how.causal
    return ACTIVATIONS if activations.fit.log_likelihood > inputs.fit.log_likelihood and not abrupt else INPUTS


def _ahead(record: Record, inputs: Choice) -> int:
    """Samples after which a smoother has nothing more to learn."""
    return ahead(slowest(inputs.fit.numbers, resolved(record.sizes, record.T).sigma_L, record.T), record.T)


def _whole(record: Record, inputs: Choice, rows: Array, how: How) -> Array:
    """The estimates (n × ESTIMATES) of the first pass."""
    pieces = over(compiled(INPUTS_MODEL), inputs.fit.numbers, rows, how, _ahead(record, inputs))
    return np.concatenate([told[:, : len(ESTIMATES)].copy() for told in pieces])


def _linear(record: Record, rows: Array, inputs: Choice, how: How) -> Array:
    """The rows of the second pass, linear about the first: smoothed if `how` is, and causal if that is late only."""
    about = _whole(record, inputs, rows, how if how.lag is None else How())
    estimates = dict(zip(ESTIMATES, about.T, strict=True))
    law = compiled_muscles(pair_system(record.curves)).outputs(LAW, record.numbers, estimates)
    known = dict(zip(row_names(INPUTS_MODEL), rows.T, strict=True))
    return table(ACTIVATIONS_MODEL, {**known, **estimates, **law})


def _collected(
    pieces: Iterator[Array], outputs: Outputs, keep_every: int, length: int, progress: Progress
) -> dict[str, Array]:
    parts: list[dict[str, Array]] = []
    done = 0
    for told in pieces:
        parts.append({name: values[-done % keep_every :: keep_every].copy() for name, values in outputs(told).items()})
        done += len(told)
        progress(done / length)
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _of_inputs(record: Record) -> Outputs:
    muscles = compiled_muscles(pair_system(record.curves))

    def outputs(told: Array) -> dict[str, Array]:
        named = dict(zip(compiled(INPUTS_MODEL).told, told.T, strict=True))
        estimates = {name: named[name] for name in ESTIMATES}
        behind = {
            **muscles.outputs(ACTIVATION, record.numbers, named),
            **muscles.outputs(SPREAD, record.numbers, named),
        }
        return {**estimates, **behind}

    return outputs


def _of_activations(told: Array) -> dict[str, Array]:
    named = dict(zip(compiled(ACTIVATIONS_MODEL).told, told.T, strict=True))
    for name in ("a1_hat", "a2_hat"):
        named[f"{name}_limit"] = ((named[name] < 0) | (named[name] > 1)).astype(float)
        named[name] = np.clip(named[name], 0, 1)
    return named
