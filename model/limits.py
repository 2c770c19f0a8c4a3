"""How large a state or an estimate may be: what is larger has diverged (docs/observers.md#divergence)."""

from __future__ import annotations

from collections.abc import Iterable

import casadi as ca

from .block import STEP, Symbols

# signal → how many times a time divides the length that it is: lengths, velocities, an acceleration
_ORDERS = {"x1": 0, "x3": 0, "x4": 0, "x2": 1, "u1": 1, "u2": 1, "Delta": 2}
# largest length, in C: a value within the domain and an error of its size, 1 each
_ROOM = 2.0
# RK4 is stable up to h · rate = 2.78 on the real axis; 10 % margin
STABLE = 2.5


def limits(names: Iterable[str], C: ca.SX) -> Symbols:
    """The largest magnitude of those of the signals named, or estimates of them, that are lengths or their rates.

    C: distance of the muscles' origins.
    """
    orders = {name: _ORDERS[signal] for name in names if (signal := name.removesuffix("_hat")) in _ORDERS}
    # |v| ≤ 2 C (2.5/h)ᵏ: no rate above 2.5/h is integrated, and an error e₀ makes peaks of the order of e₀ rateᵏ
    return Symbols({name: _ROOM * C * (STABLE / STEP) ** order for name, order in orders.items()})
