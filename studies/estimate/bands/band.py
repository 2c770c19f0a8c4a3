"""Standard deviations of what observers made of a recording: in all, and their two parts."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....model.arrays import Array
from ....model.symbols import hat
from ....observers.behind.spread import sd
from ..case import Case, Result
from .muscle import muscle_parts
from .taut import taut

Variable = tuple[tuple[str, ...], NDArray[Any], dict[str, str]]

_OF_OBSERVERS = ("observer", "time")
# estimates of joints, and their words
_OF_JOINTS = {"position": "positions", "velocity": "velocities", "disturbance": "external forces"}
# of muscles, with their units
_OF_MUSCLES = {
    "tendon_length": ("m", "tendon lengths"),
    "fibre_length": ("m", "fibre lengths"),
    "fibre_velocity": ("m/s", "fibre velocities"),
    "activation": ("1", "activations"),
}
# a part → where it comes from
_FROM = {"": "", "_state": ", from noise and unknown inputs alone", "_muscle": ", from the numbers in doubt alone"}


def deviations(case: Case, results: Mapping[str, Result], units: Mapping[str, str]) -> dict[str, Variable]:
    """`…_sd` of each estimate and its parts, `…_sd_state` and `…_sd_muscle`, as variables of a Dataset.

    units: of positions, velocities and disturbances.

    The second part is left out where no number in doubt has a share in it. Not every observer tells the first, and
    without it the whole is not known: both are NaN, or left out if no observer tells it.
    """
    found: dict[str, Variable] = {}
    states, muscles, taut_tendons = _states(case, list(results.values())), muscle_parts(case, results), _taut(case)
    of_joints = {name: (units[name], words) for name, words in _OF_JOINTS.items()}
    for name, (unit, words) in {**of_joints, **_OF_MUSCLES}.items():
        parts = {part: of[name] for part, of in (("_state", states), ("_muscle", muscles)) if name in of}
        if "_state" in parts:
            # σ² = σ_state² + σ_muscle²
            parts[""] = functools.reduce(np.hypot, parts.values(), np.zeros(()))
        for part, values in parts.items():
            about = {"long_name": f"standard deviation of the estimated {words}{_FROM[part]}", "units": unit}
            if name in _OF_MUSCLES:
                values[:, ~taut_tendons] = np.nan
                found[f"{name}_sd{part}"] = (*_OF_OBSERVERS, "muscle"), values, about
            elif case.subject.joints:
                found[f"{name}_sd{part}"] = (*_OF_OBSERVERS, "joint"), values, about
            else:
                found[f"{name}_sd{part}"] = _OF_OBSERVERS, values[..., 0], about
    return found


def _states(case: Case, results: Sequence[Result]) -> dict[str, Array]:
    """What the covariance of an observer tells, NaN if it tells none; nothing if none does."""
    s, subject, system = case.scales, case.subject, case.subject.system
    first = sd(system.states[0])
    told = [result.y for result in results if first in result.y]
    if not told:
        return {}
    unknown = np.full_like(told[0][first], np.nan)

    def stacked(names: Sequence[str]) -> Array:
        return np.stack([np.stack([r.y.get(name, unknown) for name in names], axis=-1) for r in results])

    def sds(names: Sequence[str]) -> Array:
        return stacked([sd(name) for name in names])

    q, L_S = (stacked([hat(name) for name in names]) for names in (system.joint("q"), system.muscle("L_S")))
    # σ of M Δ, of which each joint's has nothing in common with the others
    Delta = sds(system.joint("Delta"))
    parts = (subject.disturbance(q, Delta * own) for own in np.eye(len(system.joints)))
    _, along = subject.fibres(q, L_S)
    return {
        "position": s.positions(sds(system.joint("q"))),
        "velocity": s.velocities(sds(system.joint("dq"))),
        "disturbance": np.abs(functools.reduce(np.hypot, parts)),
        "tendon_length": s.metres(sds(system.muscle("L_S"))),
        "fibre_length": s.metres(sds(system.muscle("L_C"))),
        "fibre_velocity": s.velocity(sds(system.muscle("u"))) * along,
        "activation": sds(system.muscle("a")),
    }


def _taut(case: Case) -> NDArray[np.bool_]:
    """Where the length of each tendon can be known (time × muscle)."""
    sigmas = [muscle.sigma_F for muscle in case.sizes.muscles.values()]
    forces = case.y[:, len(case.subject.system.joints) :].T
    return np.stack([taut(force, sigma) for force, sigma in zip(forces, sigmas, strict=True)], axis=1)[case.kept]
