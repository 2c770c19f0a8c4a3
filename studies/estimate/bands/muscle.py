"""What numbers in doubt make of the estimates: √Σ(S_θ r_θ)², with S from `sensitivities` at each estimate."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping

import numpy as np

from ....codegen.library import Library, compile_functions
from ....codegen.toolchain import SINGLE
from ....model.arrays import Array
from ....model.curves import Curves, CurveSet, by_muscle
from ....model.skeleton import lengths, pull
from ....model.symbols import MUSCLES, hat
from ....observers.activation import LIMITS
from ....observers.sensitivity import FORCE_BIAS, LENGTH_BIAS, MUSCLE_ESTIMATES, numbers, sensitivities
from ...laboratory.muscles import SCALED, Muscle
from ..case import Case, Result
from .doubt import POSITION_BIAS

# samples at a time: their derivatives are a few MB
_CHUNK = 10_000


def compile_sensitivities(curves: Curves) -> None:
    """Compile what these curves need, or load it from the cache."""
    for curve_set in by_muscle(curves).values():
        _compiled(curve_set)


def muscle_parts(case: Case, results: Mapping[str, Result]) -> dict[str, Array]:
    """Estimate → its standard deviation (observer × time, or × muscle), if a number in doubt has a share in it.

    NaN where it is not finite, as where a tendon has no slope.
    """
    found: dict[str, Array] = {}
    deviations = [_of_muscle(case, j) for j in range(len(MUSCLES))]
    if any(deviations):
        # (muscle × observer × time × estimate)
        parts = np.array([[_parts(case, j, r, *of) for of in results.items()] for j, r in enumerate(deviations)])
        each = zip(MUSCLE_ESTIMATES, np.moveaxis(parts, (0, 3), (3, 0)), strict=True)
        found = {name: values for name, values in each if np.nansum(values)}
    q = np.stack([result.y[hat("x1")] for result in results.values()])
    if bias := case.doubt.get(POSITION_BIAS):
        found["position"] = np.full_like(q, bias)
    if case.doubt.keys() & {"mass", *_FORCE_BIASES}:
        found["disturbance"] = _of_the_disturbance(case, results)
    return found


_FORCE_BIASES = [f"{name}.{FORCE_BIAS}" for name in MUSCLES]


def _of_the_disturbance(case: Case, results: Mapping[str, Result]) -> Array:
    s, shares = case.scales, [case.doubt.get(path, 0.0) for path in _FORCE_BIASES]
    force = s.disturbance(np.stack([result.y[hat("Delta")] for result in results.values()]))
    # mass q̈ = R F + disturbance:  S of a force is ±1, that of the mass q̈
    acceleration = (force + pull(case.y[case.kept, 1:].T * s.force)) / s.mass
    part: Array = np.hypot(math.hypot(*shares), acceleration * case.doubt.get("mass", 0.0))
    return part


def _parts(case: Case, j: int, r: Mapping[str, float], name: str, result: Result) -> Array:
    """(time × estimate) of muscle j + 1 by one observer."""
    s, muscle = case.scales, getattr(case.pair, MUSCLES[j])
    q, dq = s.metres(result.y[hat("x1")]), s.velocity(result.y[hat("x2")])
    L_S, u = s.metres(result.y[hat(f"x{j + 3}")]), s.velocity(result.y[hat(f"u{j + 1}")])
    # L̇_m = −Rᵀq̇: the length at q̇ of a pair with its origins at 0
    L_m, dL_m = lengths(q, case.pair.C)[j], lengths(dq, 0.0)[j]
    limits = [np.full_like(q, result.gains.get(f"{name}.{key}", LIMITS[key].default)) for key in ("u_low", "u_high")]
    x, of = np.stack([L_m, dL_m, L_S, u, *limits], axis=1), numbers(muscle.curves)
    theta = _values(muscle)
    doubted = [i for i, number in enumerate(of) if number in r]
    sd = np.array([r[of[i]] for i in doubted])[:, None]
    variance = np.empty((len(x), len(MUSCLE_ESTIMATES)))
    for start in range(0, len(x), _CHUNK):
        rows = slice(start, start + _CHUNK)
        (flat,) = _compiled(muscle.curves).call("sensitivities", x[rows], [theta[number] for number in of])
        S = flat.reshape(-1, len(of), len(MUSCLE_ESTIMATES))
        # σ² = Σ (S_θ r_θ)²
        variance[rows] = ((S[:, doubted] * sd) ** 2).sum(axis=1)
    return np.sqrt(np.where(np.isfinite(variance), variance, np.nan))


def _values(muscle: Muscle) -> dict[str, float]:
    """The numbers of a muscle by the names that curve sets have; sensors count as right."""
    return {**muscle.numbers, **muscle.sizes, FORCE_BIAS: 0.0, LENGTH_BIAS: 0.0}


def _of_muscle(case: Case, j: int) -> dict[str, float]:
    """Number of muscle j + 1 → standard deviation, if it is in doubt."""
    prefix = f"{MUSCLES[j]}."
    own = {path.removeprefix(prefix): r for path, r in case.doubt.items() if path.startswith(prefix)}
    # C is in the length of muscle 2 only
    length = math.hypot(case.doubt.get(POSITION_BIAS, 0.0), (0.0, case.doubt.get("C", 0.0))[j])
    return {SCALED.get(key, key): r for key, r in own.items()} | ({LENGTH_BIAS: length} if length else {})


@functools.lru_cache(maxsize=32)
def _compiled(curves: CurveSet) -> Library:
    # in lanes Millard's curves would take three times as long to compile
    return compile_functions([sensitivities(curves)], SINGLE)
