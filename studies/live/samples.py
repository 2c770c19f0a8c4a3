"""What a follower is given: each sample's numbers, in their order, of which none is impossible; and its time."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from typing import Any

from ...model.arrays import is_number
from ..files.errors import RecordingError, ScenarioError
from ..files.numbers import number
from ..files.quote import shown
from ..laboratory.gaps import bounds
from ..laboratory.subject import Subject

_LARGEST = sys.float_info.max


class Samples:
    """Takes samples of a subject: positions, then forces, in SI, NaN or None where there is no value."""

    def __init__(self, subject: Subject) -> None:
        known = bounds(subject)
        self._names = subject.columns.required
        self._bounds = [known[name] for name in self._names]
        # infinity is no bound: it is no number either
        self._limits = [(max(bound.least, -_LARGEST), min(bound.most, _LARGEST)) for bound in self._bounds]

    def taken(self, measured: Sequence[Any], columns: Mapping[str, object]) -> Sequence[float]:
        """The numbers of a sample, by place or by name. RecordingError says what is wrong with it."""
        values = self._in_order(measured, columns) if columns or len(measured) != len(self._limits) else measured
        for value, (least, most) in zip(values, self._limits, strict=True):
            # the quick way: NaN is within no limits
            if not (isinstance(value, float) and least <= value <= most):
                return [self._checked(i, value) for i, value in enumerate(values)]
        return values

    def _in_order(self, measured: Sequence[Any], columns: Mapping[str, object]) -> Sequence[Any]:
        if measured and columns:
            raise RecordingError("a sample is given by place or by name, not half and half")
        if columns:
            if missing := [name for name in self._names if name not in columns]:
                raise RecordingError(f"the sample has no {missing[0]}; it needs {', '.join(self._names)}")
            if odd := [name for name in columns if name not in self._names]:
                raise RecordingError(f"{shown(odd[0])} is nothing that a sample has; it needs {', '.join(self._names)}")
            return [columns[name] for name in self._names]
        flat: list[Any] = []
        for part in measured:
            # an array of one number without dimensions is a number
            sequence = isinstance(part, list | tuple) or getattr(part, "ndim", 0) == 1
            flat.extend(part if sequence else [part])
        if len(flat) != len(self._names):
            raise RecordingError(
                f"the sample has {len(flat)} numbers; it needs {len(self._names)}: {', '.join(self._names)}"
            )
        return flat

    def _checked(self, place: int, value: object) -> float:
        # NaN differs from itself
        if value is None or (is_number(value) and value != value):
            return math.nan
        name, bound = self._names[place], self._bounds[place]
        plain = plain_number(name, value)
        if not bound.least <= plain <= bound.most:
            raise RecordingError(bound.refusal(name, plain))
        return plain


class Clock:
    """The times of samples in s, rising: as they are given, or a period after the one before.

    base: the last time that was given; count: samples since then; last: the time of the last sample, −∞ before any.
    """

    def __init__(self, period: float) -> None:
        self.period = period
        self.base, self.count, self.last = 0.0, -1, -math.inf

    def next(self, time: object) -> float:
        """The time of a sample. RecordingError if it does not rise, or is not known, and the clock stands still."""
        if time is None:
            return self._counted()
        t = plain_number("time", time)
        if t <= self.last:
            raise RecordingError(f"time must rise from sample to sample: {t:.10g} s comes after {self.last:.10g} s")
        self.base, self.count, self.last = t, 0, t
        return t

    def _counted(self) -> float:
        if not self.period:
            raise RecordingError("the sample needs its time, since no period is given")
        self.count += 1
        # not one period more: that would add up what each addition rounds
        self.last = self.base + self.count * self.period
        return self.last


def plain_number(what: str, value: object) -> float:
    """A finite number. RecordingError for all else."""
    try:
        return number(what, value)
    except ScenarioError as error:
        raise RecordingError(str(error)) from error
