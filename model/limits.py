"""How large a state or an estimate may be: what is larger has diverged (docs/observers.md#divergence)."""

from __future__ import annotations

from collections.abc import Iterable

from .block import STEP, Symbols
from .system import System

# signal → how many times a time divides the length or angle that it is: lengths, velocities, an acceleration
ORDERS_OF_JOINT, ORDERS_OF_MUSCLE = {"q": 0, "dq": 1, "Delta": 2}, {"L_S": 0, "u": 1}
# largest length, in C: a value within the domain and an error of its size, 1 each
_ROOM = 2.0
# RK4 is stable up to h · rate = 2.78 on the real axis; 10 % margin
STABLE = 2.5


def limits(system: System, names: Iterable[str], p: Symbols) -> Symbols:
    """The largest magnitude of those of the signals named, or estimates of them, that are lengths or their rates.

    p: the numbers that the system's reach takes.
    """
    scales = {
        system.name(signal, of): (system.reach(of, p), order)
        for owners, orders in ((system.joints, ORDERS_OF_JOINT), (system.muscles, ORDERS_OF_MUSCLE))
        for of in owners
        for signal, order in orders.items()
    }
    known = {name: scales[signal] for name in names if (signal := name.removesuffix("_hat")) in scales}
    # |v| ≤ 2 C (2.5/h)ᵏ: no rate above 2.5/h is integrated, and an error e₀ makes peaks of the order of e₀ rateᵏ
    return Symbols({name: _ROOM * C * (STABLE / STEP) ** order for name, (C, order) in known.items()})
