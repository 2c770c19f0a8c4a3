"""What numbers in doubt make of the estimates: √Σ(S_θ r_θ)², with S from `sensitivities` at each estimate."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Mapping

import numpy as np

from ....codegen.shared_library import Library, compile_functions
from ....codegen.toolchain import SINGLE
from ....model.arrays import Array
from ....model.curves import CurveSet
from ....model.skeleton.load import pull
from ....model.symbols import MUSCLES, hat
from ....observers.behind.activation import LIMITS
from ....observers.behind.sensitivity import (
    FORCE_BIAS,
    LENGTH_BIAS,
    MUSCLE_ESTIMATES,
    PENNATION,
    numbers,
    sensitivities,
)
from ...laboratory.muscles import SCALED, Muscle
from ...laboratory.subject import Subject
from ..case import Case, Result
from .doubt import POSITION_BIAS

# samples at a time: their derivatives are a few MB
_CHUNK = 10_000


def compile_sensitivities(subject: Subject) -> None:
    """Compile what the curves of its muscles need, or load it from the cache."""
    for muscle in subject.muscles.values():
        _compiled(muscle.curves, bool(muscle.pennation))


def muscle_parts(case: Case, results: Mapping[str, Result]) -> dict[str, Array]:
    """Estimate → its standard deviation (observer × time × joint or muscle), if a number in doubt has a share in it.

    NaN where it is not finite, as where a tendon has no slope.
    """
    found: dict[str, Array] = {}
    shape = len(results), len(range(len(case.tau))[case.kept])
    deviations = [_of_muscle(case, muscle) for muscle in case.subject.muscles]
    if any(deviations):
        parts = np.empty((len(MUSCLE_ESTIMATES), *shape, len(deviations)))
        # next to slack S may be anything
        with np.errstate(over="ignore", invalid="ignore"):
            for i, (name, result) in enumerate(results.items()):
                for rows, L_m, dL_m in _motion(case, result):
                    for j, r in enumerate(deviations):
                        shares = _shares(case, j, r, name, result, rows, L_m[:, j], dL_m[:, j])
                        # σ² = Σ (S_θ r_θ)²
                        parts[:, i, rows, j] = np.sqrt((shares**2).sum(axis=1)).T
        parts[~np.isfinite(parts)] = np.nan
        found = {name: part for name, part in zip(MUSCLE_ESTIMATES, parts, strict=True) if np.nansum(part)}
    if bias := case.doubt.get(POSITION_BIAS):
        found["position"] = np.full((*shape, 1), bias)
    biases = np.array([case.doubt.get(f"{muscle}.{FORCE_BIAS}", 0.0) for muscle in case.subject.muscles])
    if biases.any() or "mass" in case.doubt:
        found["disturbance"] = _of_the_disturbance(case, results, biases)
    return found


def _of_the_disturbance(case: Case, results: Mapping[str, Result], biases: Array) -> Array:
    system, s = case.subject.system, case.scales
    q, Delta = (
        np.stack([np.stack([result.y[hat(name)] for name in names], axis=-1) for result in results.values()])
        for names in (system.joint("q"), system.joint("Delta"))
    )
    # M q̈ + … = R F + disturbance:  S of a force is its moment arm
    R = case.subject.laws.moment_arms(q) * (s.length / s.coordinates)
    part: Array = np.sqrt(((R * biases[:, None]) ** 2).sum(axis=-2))
    if mass := case.doubt.get("mass", 0.0):
        # that of the mass q̈
        force = case.subject.disturbance(q, Delta)
        acceleration = (force + pull(case.y[case.kept, 1:].T * s.force)[:, None]) / case.pair.mass
        part = np.hypot(part, acceleration * mass)
    return part


def _motion(case: Case, result: Result) -> Iterator[tuple[slice, Array, Array]]:
    """Piece by piece: samples, lengths in m and their rates in m/s of all muscles (samples × muscle)."""
    s, system, laws = case.scales, case.subject.system, case.subject.laws
    q, dq = (np.stack([result.y[hat(name)] for name in system.joint(signal)], axis=-1) for signal in ("q", "dq"))
    for start in range(0, len(q), _CHUNK):
        rows = slice(start, start + _CHUNK)
        yield rows, s.metres(laws.lengths(q[rows])), s.velocity(laws.rates(q[rows], dq[rows]))


def _shares(
    case: Case, j: int, r: Mapping[str, float], name: str, result: Result, rows: slice, L_m: Array, dL_m: Array
) -> Array:
    """S_θ r_θ of a muscle by one observer (samples × number in doubt × estimate)."""
    s, system = case.scales, case.subject.system
    muscle = list(case.subject.muscles.values())[j]
    oblique = bool(muscle.pennation)
    of = numbers(muscle.curves, oblique)
    theta = _values(muscle)
    values = [theta[number] for number in of]
    doubted = [i for i, number in enumerate(of) if number in r]
    sd = np.array([r[of[i]] for i in doubted])[:, None]
    limits = [case.settings.changes.get(f"{name}.{key}", LIMITS[key].default) for key in ("u_low", "u_high")]
    L_S_hat, u_hat = (hat(system.muscle(signal)[j]) for signal in ("L_S", "u"))
    L_S, u = s.metres(result.y[L_S_hat][rows]), s.velocity(result.y[u_hat][rows])
    x = np.stack(np.broadcast_arrays(L_m, dL_m, L_S, u, *limits), axis=1)
    (flat,) = _compiled(muscle.curves, oblique).call("sensitivities", x, values)
    S = flat.reshape(-1, len(of), len(MUSCLE_ESTIMATES))
    return np.asarray(S[:, doubted] * sd)


def _values(muscle: Muscle) -> dict[str, float]:
    """The numbers of a muscle by the names that curve sets have; sensors count as right."""
    return {**muscle.numbers, **muscle.sizes, PENNATION: muscle.pennation, FORCE_BIAS: 0.0, LENGTH_BIAS: 0.0}


def _of_muscle(case: Case, muscle: str) -> dict[str, float]:
    """Number of a muscle → standard deviation, if it is in doubt."""
    prefix = f"{muscle}."
    own = {path.removeprefix(prefix): r for path, r in case.doubt.items() if path.startswith(prefix)}
    # C is in the length of muscle 2 only
    length = math.hypot(case.doubt.get(POSITION_BIAS, 0.0), case.doubt.get("C", 0.0) * (muscle == MUSCLES[1]))
    return {SCALED.get(key, key): r for key, r in own.items()} | ({LENGTH_BIAS: length} if length else {})


@functools.lru_cache(maxsize=32)
def _compiled(curves: CurveSet, oblique: bool) -> Library:
    # in lanes Millard's curves would take three times as long to compile
    return compile_functions([sensitivities(curves, oblique)], SINGLE)
