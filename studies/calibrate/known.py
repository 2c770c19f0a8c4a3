"""What a trial tells of a muscle: force, length, their rates and the activation, smoothed, with standard deviations.

These hardly depend on the muscle's numbers, so they are found once, with the numbers that are known before.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...model.arrays import Array
from ...observers.behind.balance import KNOWN, tendon_force
from ...observers.behind.sensitivity import muscle_numbers
from ..estimate.run import KALMAN, estimate
from ..files.errors import RecordingError
from ..files.progress import Progress
from ..kalman.run import INPUTS
from ..laboratory.laws import mapped
from ..laboratory.muscles import Muscle
from ..laboratory.subject import Subject
from .trial import Trial


@dataclass(frozen=True, eq=False)
class Known:
    """Of a muscle in a trial: times in s (n), KNOWN in SI and their standard deviations (n × 5).

    level_sd: by how much the activation may be off in the whole trial. Samples of slack tendons and gaps are left out.
    """

    source: str
    muscle: str
    time: Array
    values: Array
    sds: Array
    level_sd: float

    @property
    def length(self) -> Array:
        """Of the muscle, in m (n)."""
        return self.values[:, KNOWN.index("L_m")]


def known(trial: Trial, subject: Subject, progress: Progress) -> Iterator[Known]:
    """Of each muscle of the subject whose activation the trial knows."""
    recording, s = trial.recording, subject.scales
    told = estimate(recording, subject, KALMAN, progress=progress, form=INPUTS, smooth=True, usual_doubt=False)
    told = told.isel(observer=0)

    def of_joints(name: str) -> Array:
        values: Array = told[name].values
        return (values if subject.joints else values[:, None]) / s.coordinates

    q, dq = of_joints("position_hat"), of_joints("velocity_hat") / s.rate
    R = subject.laws.moment_arms(q)
    L_m, dL_m = s.metres(subject.laws.lengths(q)), s.velocity(subject.laws.rates(q, dq))
    # σ² = Rᵀ σ_q²
    sd_L, sd_dL = (
        s.metres(np.sqrt((R**2 @ (of_joints(name) ** 2)[..., None])[..., 0]))
        for name in ("position_sd_state", "velocity_sd_state")
    )
    L_S, sd_S, v = (told[name].values for name in ("tendon_length_hat", "tendon_length_sd_state", "fibre_velocity_hat"))
    _, along = subject.fibres(q, s.lengths(L_S))
    time = recording.time
    first, last = trial.between or (time[0], time[-1])
    if not (inside := (time >= first) & (time <= last)).any():
        raise RecordingError(
            f"{recording.source}: no sample lies between {first:g} and {last:g} s; it has {time[0]:g} to {time[-1]:g} s"
        )
    for j, (name, muscle) in enumerate(subject.muscles.items()):
        if name not in trial.activation:
            continue
        theta = numbers_of_muscle(muscle)
        F, slope = mapped(tendon_force(muscle.curves, bool(muscle.pennation)), [L_S[:, j : j + 1], _each(theta, L_S)]).T
        # Ḟ = Φ′_S L̇_S,  L̇_S = L̇_m + u
        dF = slope * (dL_m[:, j] - v[:, j] / along[:, j])
        a = np.broadcast_to(trial.activation[name], len(time))
        none = np.zeros(len(time))
        # u errs as the velocity does, so the tendon's rate is known far better than either
        sds = np.column_stack([slope * sd_S[:, j], none, sd_L[:, j], sd_dL[:, j], none])
        values = np.column_stack([F, dF, L_m[:, j], dL_m[:, j], a])
        seen = inside & np.isfinite(sds).all(axis=1) & (told.bridged.values == 0)
        if not seen.any():
            raise RecordingError(f"{recording.source}: no sample tells anything of {name}: its tendon carries no force")
        yield Known(recording.source, name, time[seen], values[seen], sds[seen], trial.sds[name])


def numbers_of_muscle(muscle: Muscle) -> Array:
    """Its `muscle_numbers` in SI."""
    values = {**muscle.values, **muscle.sizes}
    return np.array([values[name] for name in muscle_numbers(muscle.curves, bool(muscle.pennation))])


def _each(theta: Array, like: Array) -> Array:
    return np.broadcast_to(theta, (len(like), len(theta)))
