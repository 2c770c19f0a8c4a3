"""One observer, sample by sample: gains learnt at the start or given, then an estimate of each sample."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from ..estimate.dataset import explained
from ..estimate.start import longest_period, too_rare
from ..files.errors import RecordingError
from ..laboratory.gaps import longest_step
from .estimate import Estimate, Naming
from .running import Running
from .samples import Clock, Samples
from .setup import Setup

# s at the start from which gains are learnt: docs/live.md#gains says how good they are then
LEARNING = 5.0


class Follower:
    """Gives an estimate of each sample; made by `follow`.

    The observer is that of `estimate`, with its steps: a straight line leads from the last sample to the new one.
    """

    def __init__(self, setup: Setup, gains: Mapping[str, float], period: float, seconds: float) -> None:
        self._setup, self._gains, self._seconds = setup, dict(gains), seconds
        self._samples, self._naming, self.clock = Samples(setup.subject), Naming(setup.subject), Clock(period)
        self._rate, self._units = setup.subject.scales.rate, setup.units
        # in τ, known once the gains are
        self.T = period * self._rate
        self.start = self.followed = math.nan
        self.learnt_from: list[tuple[float, list[float]]] = []
        self.running: Running | None = None
        self.failure = ""
        self._learning = bool(setup.missing(gains))
        self._longest = longest_step(period or longest_period(setup.subject.scales))
        if not self._learning:
            setup.refuse_too_fast(gains, self.T)

    @property
    def observer(self) -> str:
        """The name of the observer."""
        return self._setup.block.name

    @property
    def setup(self) -> Setup:
        """Who follows whose muscles."""
        return self._setup

    @property
    def seconds(self) -> float:
        """How long gains are learnt, in s."""
        return self._seconds

    @property
    def learning(self) -> bool:
        """Whether gains are still learnt: until then there are no estimates."""
        return self._learning

    @property
    def gains(self) -> Mapping[str, float]:
        """Path → value of the gains that are known."""
        return MappingProxyType(self._gains)

    def step(self, *measured: Any, time: float | None = None, **columns: Any) -> Estimate:  # noqa: ANN401 — a sample's
        """The estimate at the next sample: `step(position, force_1, force_2)` of a pair, in m and N.

        Of a mechanism two sequences, positions and forces in its order; of both also by name, as the columns of a
        recording are called. time: s; a period after the last sample where it is left out. NaN or None is a gap: its
        estimate is NaN, and a straight line leads from the sample before it to the one after. After a gap that is too
        long for a line the observer begins anew. RecordingError says what is wrong with a sample, which then counts as
        not there. Estimates are NaN while gains are learnt, and for good once the observer has failed, see `failure`.
        """
        values = self._samples.taken(measured, columns)
        t = self.clock.next(time)
        # the sum of numbers and NaN is NaN
        if (total := sum(values)) != total:
            return self._naming.nothing(t, t - self.start)
        if not t - self.followed <= self._longest:
            self._begin(t)
        self.followed = t
        y = [value / unit for value, unit in zip(values, self._units, strict=True)]
        if self._learning:
            self.learnt_from.append((t, y))
            if t - self.start >= self._seconds:
                self._learn()
        elif not self.failure:
            if self.running is None:
                self.running = Running(self._setup, self._gains, y, self.T)
            self.running.sample(self._rate * (t - self.start), y)
        return self._estimate(t)

    def _begin(self, t: float) -> None:
        self.start, self.running, self.failure, self.learnt_from = t, None, "", []

    def _estimate(self, t: float) -> Estimate:
        age, running = t - self.start, self.running
        if running is None or self.failure:
            return self._naming.nothing(t, age)
        if running.failure is not None:
            self.failure = explained(self.observer, running.failure, self.start + running.failure.time / self._rate)
        return self._naming.estimate(t, age, running.estimates(), running.deviations())

    def _learn(self) -> None:
        """Find the gains and pass the samples that have come."""
        times, values = zip(*self.learnt_from, strict=True)
        tau, y = self._rate * (np.array(times) - self.start), np.array(values)
        self.T = float(np.median(np.diff(tau)))
        self.learnt_from = []
        if objection := too_rare(self.T / self._rate, self._setup.subject.scales):
            self._begin(math.nan)
            raise RecordingError(f"nothing can be learnt: {objection}")
        self._gains = {**self._setup.learnt(y, tau, self.T), **self._gains}
        self._learning, self._longest = False, longest_step(self.T / self._rate)
        self.running = Running(self._setup, self._gains, y[0].tolist(), self.T)
        self.running.all_of(tau, y)
