"""Numbers in tables: two digits, short."""

from __future__ import annotations

import math


def number(value: float) -> str:
    """Two digits, short: 1.8e-4, 0.52, 12."""
    if value != value:
        return "–"
    if math.isinf(value):
        return f"{value}"
    if value == 0:
        return "0"
    if not 1e-2 <= abs(value) < 1e4:
        mantissa, _, exponent = f"{value:.1e}".partition("e")
        return f"{mantissa}e{int(exponent)}"
    return f"{value:.2g}" if abs(value) < 100 else f"{value:.0f}"


def percent(fraction: float) -> str:
    """Two digits: 0.12 %, 15 %; ∞ if there is no bound."""
    return "∞" if fraction == math.inf else f"{number(100 * fraction)} %"


def counted(count: int, noun: str, plural: str = "") -> str:
    """`1 run`, `1,000 runs`."""
    return f"{count:,} {noun if count == 1 else plural or noun + 's'}"
