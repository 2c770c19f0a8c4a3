"""An observer under way: from one sample to what is known there."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ...codegen.failure import Failure
from ...codegen.recordings.filters import State
from ...model.arrays import Array
from ..estimate.bands.band import state_deviations
from ..estimate.bands.taut import still_taut
from ..estimate.follow import JITTER, filled, followed
from ..laboratory.quantities import OF_MUSCLES, quantities_of
from .setup import Setup

# what a filter of a pair knows of the noise of its forces
_NOISES = ("sigma_F1", "sigma_F2")


class Running:
    """An observer from its first sample on, with `gains` for a period T in τ; measurements are dimensionless."""

    def __init__(self, setup: Setup, gains: Mapping[str, float], first: Sequence[float], T: float) -> None:
        self.first = list(first)
        self._setup = setup
        # what moves at samples only knows how long a step is, and needs none filled in
        self._longest = math.inf if setup.block.sampled else T
        # no longer than this, a step is surely not filled
        self._usual = self._longest * (1 + JITTER / 2)
        self._filter, numbers = setup.filter(gains, first, T)
        self._names = list(setup.block.y)
        subject = setup.subject
        # all numbers in SI at the last sample, in the order of `Quantities`
        self.estimates = quantities_of(subject).of_memory(self._filter.row[: len(subject.system.quantities)])
        self._joints = len(subject.system.joints)
        self._noises = [numbers[name] for name in _NOISES] if setup.sure else []
        self.taut = [False] * len(subject.system.muscles)
        self._tau = -math.inf

    @property
    def failure(self) -> Failure | None:
        """Why it has no estimates any more."""
        return self._filter.failure

    @property
    def state(self) -> State:
        """Where it stands, after a sample at least."""
        return self._filter.state

    def go_on_from(self, state: State, taut: Sequence[bool]) -> None:
        """Take the place of one that began at the same sample, from where that stood."""
        self._filter.go_on_from(state)
        self._tau, self.taut = state.t, list(taut)

    def all_of(self, tau: Array, y: Array) -> None:
        """Pass samples that have come before: times τ (n), measurements (n × measured)."""
        for _ in followed(self._filter, self._longest, tau, y):
            pass
        self._tau = float(tau[-1])
        if self._noises:
            for row in y:
                self._feel(row)

    def sample(self, tau: float, y: Sequence[float]) -> None:
        """Go on to a sample."""
        if tau - self._tau <= self._usual or self._tau < 0:
            self._filter.sample(tau, y)
        else:
            last = self._filter.state
            times, values, _ = filled(np.array([last.t, tau]), np.array([last.y, y]), self._longest)
            self._filter.samples(times[1:], values[1:])
        self._tau = tau
        if self._noises:
            self._feel(y)

    def deviations(self) -> dict[str, Array] | None:
        """The standard deviations, if the observer tells them; NaN where a tendon is slack."""
        if not self._noises:
            return None
        told = dict(zip(self._names, self._filter.row[: len(self._names)], strict=True))
        known = {name: values[0] for name, values in state_deviations(self._setup.subject, [told]).items()}
        for name in OF_MUSCLES:
            known[name][~np.array(self.taut)] = np.nan
        return known

    def _feel(self, y: Sequence[float]) -> None:
        forces = y[self._joints :]
        self.taut = [
            still_taut(before, force, sigma)
            for before, force, sigma in zip(self.taut, forces, self._noises, strict=True)
        ]
