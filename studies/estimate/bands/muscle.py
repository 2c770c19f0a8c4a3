"""What numbers in doubt make of the estimates: √Σ(S_θ r_θ)², with S from `sensitivities` at each estimate."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterator, Mapping

import numpy as np

from ....codegen.shared_library import Library, compile_functions
from ....codegen.toolchain import SINGLE
from ....model.arrays import Array
from ....model.curves import Curves, CurveSet, by_muscle
from ....model.skeleton.load import lengths, pull
from ....model.symbols import MUSCLES, hat
from ....observers.behind.activation import LIMITS
from ....observers.behind.sensitivity import FORCE_BIAS, LENGTH_BIAS, MUSCLE_ESTIMATES, numbers, sensitivities
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
    shape = len(results), len(range(len(case.tau))[case.kept])
    deviations = [_of_muscle(case, j) for j in range(len(MUSCLES))]
    if any(deviations):
        parts = np.empty((len(MUSCLE_ESTIMATES), *shape, len(MUSCLES)))
        # next to slack S may be anything
        with np.errstate(over="ignore", invalid="ignore"):
            for (i, (name, result)), (j, r) in itertools.product(enumerate(results.items()), enumerate(deviations)):
                for rows, shares in _shares(case, j, r, name, result):
                    # σ² = Σ (S_θ r_θ)²
                    parts[:, i, rows, j] = np.sqrt((shares**2).sum(axis=1)).T
        parts[~np.isfinite(parts)] = np.nan
        found = {name: part for name, part in zip(MUSCLE_ESTIMATES, parts, strict=True) if np.nansum(part)}
    if bias := case.doubt.get(POSITION_BIAS):
        found["position"] = np.full(shape, bias)
    if case.doubt.keys() & {"mass", *_FORCE_BIASES}:
        found["disturbance"] = _of_the_disturbance(case, results)
    return found


_FORCE_BIASES = [f"{name}.{FORCE_BIAS}" for name in MUSCLES]


def _of_the_disturbance(case: Case, results: Mapping[str, Result]) -> Array:
    s, shares = case.scales, [case.doubt.get(path, 0.0) for path in _FORCE_BIASES]
    q, Delta = (np.stack([result.y[hat(name)] for result in results.values()])[..., None] for name in ("x1", "Delta"))
    force = case.subject.disturbance(q, Delta)[..., 0]
    # mass q̈ = R F + disturbance:  S of a force is ±1, that of the mass q̈
    acceleration = (force + pull(case.y[case.kept, 1:].T * s.force)) / case.pair.mass
    part: Array = np.hypot(math.hypot(*shares), acceleration * case.doubt.get("mass", 0.0))
    return part


def _shares(case: Case, j: int, r: Mapping[str, float], name: str, result: Result) -> Iterator[tuple[slice, Array]]:
    """S_θ r_θ of muscle j + 1 by one observer, piece by piece: samples, and (samples × number in doubt × estimate)."""
    s, muscle, y = case.scales, getattr(case.pair, MUSCLES[j]), result.y
    of = numbers(muscle.curves)
    theta = _values(muscle)
    values = [theta[number] for number in of]
    doubted = [i for i, number in enumerate(of) if number in r]
    sd = np.array([r[of[i]] for i in doubted])[:, None]
    limits = [case.settings.changes.get(f"{name}.{key}", LIMITS[key].default) for key in ("u_low", "u_high")]
    for start in range(0, len(y[hat("x1")]), _CHUNK):
        rows = slice(start, start + _CHUNK)
        q, L_S = (s.metres(y[hat(state)][rows]) for state in ("x1", f"x{j + 3}"))
        dq, u = (s.velocity(y[hat(rate)][rows]) for rate in ("x2", f"u{j + 1}"))
        # L̇_m = −Rᵀq̇: the length at q̇ of a pair with its origins at 0
        L_m, dL_m = lengths(q, case.pair.C)[j], lengths(dq, 0.0)[j]
        x = np.stack(np.broadcast_arrays(L_m, dL_m, L_S, u, *limits), axis=1)
        (flat,) = _compiled(muscle.curves).call("sensitivities", x, values)
        S = flat.reshape(-1, len(of), len(MUSCLE_ESTIMATES))
        yield rows, S[:, doubted] * sd


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
