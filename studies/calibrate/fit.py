"""Numbers of a muscle by least squares of the forces that they leave unexplained in its trials.

    Σ ρ(e²/σ²) + Σ ξ²  →  min over ξ,   e = F − (a f g + Φ_P)(θ),   θ = θ₀ exp(r ξ),   a = a_known + σ_a ξ_a

Residuals of the force: those of the activation, e/(f g), grow without bound where a fibre is far from its best length,
and Gauss-Newton runs away from there.
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ...model.arrays import Array
from ...model.curves import CurveSet
from ...observers.behind.balance import KNOWN, balance
from ..files.errors import RecordingError
from ..laboratory.laws import mapped
from ..laboratory.muscles import Muscle
from .extra import scipy
from .known import Known
from .prior import Prior, prior

# s between residuals at first; neighbours as much alike count as one, and every second one goes
_SPACING, _ALIKE = 0.1, 0.5
# residuals that a trial must have
FEW = 10
# forces that no smoothing resolves, as a part of F_max: what is common to a slow wave of the noise
_FLOOR = 0.001
# standard deviations: from here on a residual counts less, is an outlier; numbers go no farther
_ROBUST, OUTLIER, FARTHEST = 3.0, 5.0, 5.0
# weights follow the numbers, which hardly change after the second time
_ROUNDS = 3


@dataclass(frozen=True, eq=False)
class Fit:
    """ξ of the numbers (n) and of the level of each trial (trials), in what was known before, and their covariance.

    kept: of each trial the samples that count; ratios: their residuals over standard deviations.
    """

    muscle: Muscle
    prior: Prior
    xi: Array
    levels: Array
    covariance: Array
    kept: Sequence[NDArray[np.intp]]
    ratios: Sequence[Array]

    @property
    def numbers(self) -> Array:
        """The numbers found, in SI."""
        return np.asarray(self.prior.values * np.exp(self.prior.parts * self.xi))

    @property
    def left(self) -> Array:
        """Covariance of the numbers (n × n) in that of what was known before, where it is 1."""
        n = len(self.xi)
        return self.covariance[:n, :n]


def fitted(muscle: Muscle, trials: Sequence[Known]) -> Fit:
    """The numbers that explain the trials of a muscle. RecordingError for a trial that is too short."""
    before = prior(muscle)
    spacing = [_SPACING] * len(trials)
    xi = np.zeros(len(before.keys) + len(trials))
    rounds = 0
    while True:
        kept = [_every(trial, seconds) for trial, seconds in zip(trials, spacing, strict=True)]
        problem = _Problem(muscle, before, trials, kept, xi)
        xi = problem.solved(xi)
        ratios = problem.ratios(xi)
        rounds += 1
        alike = [_alike(trial, own) for trial, own in zip(kept, ratios, strict=True)]
        if rounds >= _ROUNDS and not any(alike):
            n = len(before.keys)
            return Fit(muscle, before, xi[:n], xi[n:], problem.covariance(xi), kept, ratios)
        spacing = [seconds * (2 if twice else 1) for seconds, twice in zip(spacing, alike, strict=True)]


class _Problem:
    """Residuals and their Jacobian, with the standard deviations that residuals have at ξ."""

    def __init__(
        self, muscle: Muscle, before: Prior, trials: Sequence[Known], kept: Sequence[NDArray[np.intp]], xi: Array
    ) -> None:
        self._function, self._before = _balance(muscle.curves, bool(muscle.pennation)), before
        self._values = np.concatenate([trial.values[rows] for trial, rows in zip(trials, kept, strict=True)])
        self._of = np.repeat(np.arange(len(trials)), [len(rows) for rows in kept])
        self._level_sd = np.array([trial.level_sd for trial in trials])
        sds = np.concatenate([trial.sds[rows] for trial, rows in zip(trials, kept, strict=True)])
        e, of_known, _ = self._evaluated(xi)
        if not np.isfinite(e).all():
            sources = ", ".join(dict.fromkeys(trial.source for trial in trials))
            raise RecordingError(f"{sources}: the numbers of {trials[0].muscle} give no force there; are units right?")
        # σ² = Σ (∂e/∂x σ_x)² + (0.001 F_max)²
        self._sigma = np.sqrt(((of_known * sds) ** 2).sum(axis=1) + (_FLOOR * muscle.F_max) ** 2)

    def solved(self, xi: Array) -> Array:
        """ξ of the least squares."""
        found = scipy("optimize").least_squares(
            self._residuals, xi, self._jacobian, bounds=(-FARTHEST, FARTHEST), loss="huber", f_scale=_ROBUST
        )
        return np.asarray(found.x)

    def covariance(self, xi: Array) -> Array:
        """Of ξ: (1 + information)⁻¹, of which an outlier gives as much as it counts."""
        residuals = self._residuals(xi)
        J = self._jacobian(xi) / np.sqrt(np.maximum(np.abs(residuals) / _ROBUST, 1))[:, None]
        # what was known before stays known, however far ξ is from it
        J[-len(xi) :] = np.eye(len(xi))
        return np.asarray(np.linalg.inv(J.T @ J), dtype=float)

    def ratios(self, xi: Array) -> list[Array]:
        """e/σ of each trial."""
        all_of = self._evaluated(xi)[0] / self._sigma
        return [all_of[self._of == i] for i in range(len(self._level_sd))]

    def _residuals(self, xi: Array) -> Array:
        return np.concatenate([self._evaluated(xi)[0] / self._sigma, xi])

    def _jacobian(self, xi: Array) -> Array:
        _, of_known, of_theta = self._evaluated(xi)
        before, n = self._before, len(self._before.keys)
        places = list(before.places)
        J = np.zeros((len(self._sigma), len(xi)))
        # ∂θ/∂ξ = r θ
        J[:, :n] = of_theta[:, places] * (before.parts * before.moved(xi[:n])[places])
        J[np.arange(len(J)), n + self._of] = of_known[:, KNOWN.index("a")] * self._level_sd[self._of]
        return np.concatenate([J / self._sigma[:, None], np.eye(len(xi))])

    def _evaluated(self, xi: Array) -> tuple[Array, Array, Array]:
        """e (samples), ∂e/∂KNOWN, ∂e/∂numbers."""
        n = len(self._before.keys)
        values = self._values.copy()
        values[:, KNOWN.index("a")] += (self._level_sd * xi[n:])[self._of]
        theta = self._before.moved(xi[:n])
        told = mapped(self._function, [values, np.broadcast_to(theta, (len(values), len(theta)))])
        e, of_known, of_theta = np.split(told, [1, 1 + len(KNOWN)], axis=1)
        return e[:, 0], of_known, of_theta


@functools.lru_cache(maxsize=8)
def _balance(curves: CurveSet, oblique: bool) -> ca.Function:
    return balance(curves, oblique)


def _every(trial: Known, seconds: float) -> NDArray[np.intp]:
    """Samples that are so far apart, in the middle of their intervals. RecordingError if there are too few."""
    intervals = np.floor((trial.time - trial.time[0]) / seconds + 0.5)
    kept = np.flatnonzero(np.diff(intervals, prepend=intervals[0]))
    if len(kept) < FEW:
        raise RecordingError(
            f"{trial.source}: {trial.muscle} is known for {trial.time[-1] - trial.time[0]:.3g} s; "
            f"a trial takes {FEW * _SPACING:g} s or more, in which its tendon carries a force"
        )
    return kept


def _alike(kept: NDArray[np.intp], ratios: Array) -> bool:
    """Whether neighbours are alike and enough would be left of half of them."""
    if len(kept) < 2 * FEW + 1 or not ratios.std():
        return False
    return bool(np.corrcoef(ratios[1:], ratios[:-1])[0, 1] > _ALIKE)
