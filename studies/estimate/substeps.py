"""How many RK4 steps an observer needs from sample to sample, by its fastest rate.

The constants and what they were measured on: docs/gains.md.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import casadi as ca
import numpy as np

from ...model.arrays import Array
from ...model.block import Block, Symbols
from ...model.system import System
from ...observers import Observer
from ..files.errors import ScenarioError

# periods of the muscles' own time 1/v_max between samples beyond which nothing can be followed
LONGEST_PERIOD = 0.7
# more means that the gains belong to other data
MOST_STEPS = 1000
# decimal fractions as doubles
_ROUNDING = 1e-9


def substeps(
    observer: Observer,
    system: System,
    block: Block,
    numbers: Mapping[str, float],
    start: Mapping[str, float],
    T: float,
    limit: float | None = None,
) -> int:
    """RK4 steps in a sampling period T of `block`, which `observer` has built, with these numbers (name → value).

    start: inputs at the first sample, for an observer that does not tell its rates; then the eigenvalues of ∂ẋ/∂x there
    count. limit: the largest step times rate, the observer's own if not given. ScenarioError if no reasonable number of
    steps will do.
    """
    rates = observer.rates_of(system, block.p)
    fastest = _spectral_radius(block, numbers, start) if rates is None else _fastest(block, rates, numbers)
    n = T * fastest / (observer.limit if limit is None else limit)
    if not n <= MOST_STEPS:
        raise ScenarioError(
            f"the gains of {block.name} are too fast for samples τ = {T:.3g} apart: they ask for {n:.3g} steps in "
            f"between, {MOST_STEPS} at most"
        )
    return max(1, math.ceil(n - _ROUNDING))


def _fastest(block: Block, named: Mapping[str, ca.SX], numbers: Mapping[str, float]) -> float:
    expressions = ca.vertcat(*named.values())
    if not named:
        return 0.0
    values = _numeric(expressions, (block.p, numbers))[:, 0]
    if not np.isfinite(values).all():
        wrong = expressions[int(np.argmin(np.isfinite(values)))]
        zeros = [f"{block.name}.{name}" for name, p in block.p.items() if not numbers[name] and ca.depends_on(wrong, p)]
        if zeros:
            raise ScenarioError(f"{' and '.join(zeros)} = 0 has no fastest rate; a recording needs a layer above 0")
        if np.isnan(values).any():
            name = list(named)[int(np.argmax(np.isnan(values)))]
            raise ScenarioError(f"the gains of {block.name} make no observer: its rate {name} is no number")
    return float(values.max())


def _spectral_radius(block: Block, numbers: Mapping[str, float], start: Mapping[str, float]) -> float:
    """The largest eigenvalue of ∂ẋ/∂x at the start; NaN if that is not finite there."""
    x0 = [block.x0.get(name, ca.SX(0)) for name in block.x]
    there = ca.substitute(
        ca.jacobian(block.dx.vector(), block.x.only(block.dx).vector()), block.x.vector(), ca.vertcat(*x0)
    )
    A = _numeric(there, (block.p, numbers), (block.u, start))
    if not A.size:
        return 0.0
    return float(np.abs(np.linalg.eigvals(A)).max()) if np.isfinite(A).all() else math.nan


def _numeric(expressions: ca.SX, *given: tuple[Symbols, Mapping[str, float]]) -> Array:
    """Their values; a number and an input of a user's observer may have the same name."""
    function = ca.Function("numeric", [names.vector() for names, _ in given], [expressions])
    return np.array(function(*([values[name] for name in names] for names, values in given)), dtype=float)
