"""One observer, sample by sample: gains learnt at the start or given, then an estimate of each sample."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from ...codegen.recordings.filters import State
from ...model.errors import Error
from ..estimate.dataset import explained
from ..estimate.start import longest_period, too_rare
from ..files.errors import RecordingError, ResultError, ScenarioError
from ..laboratory.gaps import longest_step
from ..laboratory.scales import Scales
from .estimate import Estimate, Naming
from .running import Running
from .samples import Clock, Samples
from .setup import Setup
from .state import known, packed, unpacked

# s at the start from which gains are learnt: docs/live.md#gains says how good they are then
LEARNING = 5.0
# s; of more samples gains are no better, and they wait in memory
_LONGEST = 600.0
# s; a gap is filled with so many samples that less would take memory, and no muscle is measured faster
_SHORTEST = 1e-6


class Follower:
    """Gives an estimate of each sample; made by `follow`.

    The observer is that of `estimate`, with its steps: a straight line leads from the last sample to the new one.
    seconds: how long gains are learnt. failure: why there are no estimates any more, empty while there are.
    """

    def __init__(self, setup: Setup, gains: Mapping[str, float], period: float, seconds: float, T: float) -> None:
        """Period and seconds in s, T in τ; ScenarioError if one of them cannot be, or is too long for the gains.

        period: 0 if samples bring their times. T: the period that the gains are for, 0 if they are still learnt.
        """
        s, self._learning = setup.subject.scales, bool(setup.missing(gains))
        self._setup, self._gains, self.seconds, self._T = setup, dict(gains), seconds, T
        if not 0 < seconds <= _LONGEST:
            raise ScenarioError(f"learning must be above 0 and at most {_LONGEST:g} s, not {seconds:g} s")
        if not (self._learning or T):
            raise ScenarioError("the period must be above 0 s, not 0 s")
        # in s even the smallest of all T may be 0
        for given, seconds_apart in ((period, period), (T, T / s.rate)):
            if given and (objection := _objection(seconds_apart, s)):
                raise ScenarioError(objection)
        if not self._learning:
            setup.refuse_too_fast(gains, T)
        self._samples, self._naming, self._clock = Samples(setup.subject), Naming(setup.subject), Clock(period)
        self._rate, self._units = s.rate, setup.units
        self._longest = longest_step(T / s.rate or longest_period(s))
        # times in s of the observer's first sample and of the last that it was given
        self._start = self._followed = math.nan
        self._learnt_from: list[tuple[float, list[float]]] = []
        self._running: Running | None = None
        self.failure = ""

    @property
    def observer(self) -> str:
        """The name of the observer."""
        return self._setup.block.name

    @property
    def period(self) -> float:
        """The period in s that a sample without a time is after the one before; 0 if each needs its time."""
        return self._clock.period

    @property
    def sure(self) -> bool:
        """Whether it tells standard deviations."""
        return self._setup.sure

    @property
    def learning(self) -> bool:
        """Whether gains are still learnt: until then there are no estimates."""
        return self._learning

    @property
    def gains(self) -> Mapping[str, float]:
        """Path → value of the gains that are known."""
        return MappingProxyType(self._gains)

    def step(self, *measured: object, time: float | None = None, **columns: object) -> Estimate:
        """The estimate at the next sample: `step(position, force_1, force_2)` of a pair, in m and N.

        Of a mechanism two sequences, positions and forces in its order; of both also by name, as the columns of a
        recording are called. time: s; a period after the last sample where it is left out. NaN or None is a gap: its
        estimate is NaN, and a straight line leads from the sample before it to the one after. After a gap that is too
        long for a line the observer begins anew. RecordingError says what is wrong with a sample, which then counts as
        not there. Estimates are NaN while gains are learnt, and for good once the observer has failed, see `failure`.
        """
        values = self._samples.taken(measured, columns)
        t = self._clock.next(time)
        # the sum of numbers and NaN is NaN
        if (total := sum(values)) != total:
            return self._naming.nothing(t, t - self._start)
        if not t - self._followed <= self._longest:
            self._begin(t)
        self._followed = t
        if self._learning:
            self._learnt_from.append((t, list(values)))
            if t - self._start >= self.seconds:
                self._learn()
        elif not self.failure:
            y = [value / unit for value, unit in zip(values, self._units, strict=True)]
            if self._running is None:
                self._running = Running(self._setup, self._gains, y, self._T)
            self._running.sample(self._rate * (t - self._start), y)
        return self._estimate(t)

    def state(self) -> bytes:
        """Where it stands, for `follow(…, state=…)`: a follower that goes on from there gives the same estimates."""
        running = None if self.failure else self._running
        at = running.state if running else State([], 0.0, [])
        content = {
            "gains": self._gains,
            "period": self._clock.period,
            "T": self._T,
            "learning": self._learning,
            "seconds": self.seconds,
            "base": self._clock.base,
            "count": self._clock.count,
            "last": known(self._clock.last),
            "start": known(self._start),
            "followed": known(self._followed),
            "learnt_from": [[t, *values] for t, values in self._learnt_from],
            "failure": self.failure,
            "first": running.first if running else [],
            "x": at.x,
            "y": at.y,
            "taut": running.taut if running else [],
        }
        return packed(content, self._setup)

    @classmethod
    def resumed(cls, state: object, setup: Setup) -> Follower:
        """The follower whose state it was. ResultError if it was none, or that of another observer or muscles."""
        try:
            return cls._resumed(unpacked(state, setup), setup)
        except Error as error:
            raise ResultError(f"the state cannot be gone on from: {error}") from error

    @classmethod
    def _resumed(cls, told: Mapping[str, Any], setup: Setup) -> Follower:
        gains, running = setup.given(told["gains"]), bool(told["first"])
        if told["learning"] != bool(setup.missing(gains)) or (running and told["learning"]):
            raise ResultError("its gains are not those of this observer")
        follower = cls(setup, gains, told["period"], told["seconds"], told["T"])
        follower.failure = told["failure"]
        clock = follower._clock
        clock.base, clock.count = told["base"], told["count"]
        for owner, name in ((clock, "last"), (follower, "_start"), (follower, "_followed")):
            if time := told[name.removeprefix("_")]:
                setattr(owner, name, time[0])
        follower._learnt_from = [(t, list(follower._samples.taken(y, {}))) for t, *y in told["learnt_from"]]
        if running:
            follower._running = Running(setup, gains, told["first"], told["T"])
            tau = follower._rate * (follower._followed - follower._start)
            follower._running.go_on_from(State(told["x"], tau, told["y"]), told["taut"])
        return follower

    def _begin(self, t: float) -> None:
        self._start, self._running, self.failure, self._learnt_from = t, None, "", []

    def _estimate(self, t: float) -> Estimate:
        age, running = t - self._start, self._running
        if running is None or self.failure:
            return self._naming.nothing(t, age)
        if running.failure is not None:
            self.failure = explained(self.observer, running.failure, self._start + running.failure.time / self._rate)
        return self._naming.estimate(t, age, running.estimates(), running.deviations())

    def _learn(self) -> None:
        """Find the gains and pass the samples that have come."""
        times, values = zip(*self._learnt_from, strict=True)
        tau, y = self._rate * (np.array(times) - self._start), np.array(values) / self._units
        self._T = float(np.median(np.diff(tau)))
        self._learnt_from = []
        if objection := _objection(self._T / self._rate, self._setup.subject.scales):
            self._followed = math.nan
            raise RecordingError(f"nothing can be learnt: {objection}")
        self._gains = {**self._setup.learnt(y, tau, self._T), **self._gains}
        self._learning, self._longest = False, longest_step(self._T / self._rate)
        self._running = Running(self._setup, self._gains, y[0].tolist(), self._T)
        self._running.all_of(tau, y)


def _objection(period: float, scales: Scales) -> str:
    """Why samples a period apart, in s, cannot be followed; empty if they can."""
    if period < _SHORTEST:
        return f"the period must be at least {_SHORTEST:g} s, not {period:g} s"
    return too_rare(period, scales)
