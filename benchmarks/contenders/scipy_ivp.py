"""SciPy: `solve_ivp`, started anew at each noise sample."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hillobs.model.arrays import Array

from ..emit import NUMBERS, python
from ..lean import lean_rates
from ..problem import Problem
from . import Contender, marching
from .optional import imported

_STEPS = 400
# other methods than RK4: as good, but not the same
_TOLERANCE = 1e-4


def rk45(of: Problem) -> Contender:
    """Dormand–Prince with steps of at most h."""
    return _contender("SciPy RK45, max_step = h, lean", of, method="RK45", max_step=of.grid.h)


def lsoda(of: Problem) -> Contender:
    """LSODA with steps of its own."""
    return _contender("SciPy LSODA, rtol = atol = 1e-8, lean", of, method="LSODA", rtol=1e-8, atol=1e-8)


def _contender(name: str, of: Problem, **options: Any) -> Contender:  # noqa: ANN401  what solve_ivp takes
    solve: Callable[..., Any] = imported("scipy.integrate", "scipy").solve_ivp
    lean, period = lean_rates(of), of.grid.h * of.grid.hold
    rates, clock = python(lean.function, NUMBERS), python(lean.clock, NUMBERS)

    def march(samples: Array) -> Array:
        x = of.x0
        for i, w in enumerate(samples[:, :, 0].tolist()):

            def f(t: float, x: Array, w: list[float] = w) -> tuple[float, ...]:
                dx: tuple[float, ...] = rates(clock((t,))[0], x.tolist(), w)[0]
                return dx

            x = solve(f, (i * period, (i + 1) * period), x, t_eval=((i + 1) * period,), **options).y[:, -1]
        return x[:, None]

    return marching(name, of, 1, _STEPS, march, _TOLERANCE)
