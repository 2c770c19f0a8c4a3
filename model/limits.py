"""How large a state or an estimate may be: what is larger has diverged (docs/observers.md#divergence)."""

from __future__ import annotations

from collections.abc import Iterable

import casadi as ca

from .block import STEP, Symbols
from .symbols import SIGNALS

# largest length, in C: a value within the muscles' domain, and an error of its size with its overshoot
_ROOM = 4.0
# RK4 is stable up to h · rate = 2.78 on the real axis; 10 % margin
STABLE = 2.5


def limits(names: Iterable[str], C: ca.SX) -> Symbols:
    """The largest magnitude of those of the signals, or their estimates, that have the dimension of a motion.

    C: distance of the muscles' origins.
    """
    signals = {name: SIGNALS[known] for name in names if (known := name.removesuffix("_hat")) in SIGNALS}
    # |v| ≤ 4 C (2.5/h)ᵏ: no rate above 2.5/h is integrated, and an error e₀ makes peaks of the order of e₀ rateᵏ
    return Symbols(
        {
            name: _ROOM * C * (STABLE / STEP) ** signal.order
            for name, signal in signals.items()
            if signal.order is not None
        }
    )
