"""One line of a verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

# a number from here on has no decimals
_WHOLE = 10.0


@dataclass(frozen=True)
class Suspect:
    """What of the muscles may be wrong: a number, which is likelier times `factor`, or another thing, whose is None.

    instead: what is likelier, in words; log_likelihood: by how much.
    """

    number: str
    factor: float | None
    instead: str
    log_likelihood: float


@dataclass(frozen=True)
class Finding:
    """What was looked at, what was found, a number to it, and whether that makes recording or muscles doubtful.

    when: s from and to, of what is not so all the time.
    """

    subject: str
    sentence: str
    value: float
    doubtful: bool = False
    when: tuple[float, float] | None = None
    suspects: Sequence[Suspect] = ()


def plain(value: float) -> str:
    """Two digits, and no power of ten of what is large."""
    return f"{value:,.0f}" if value >= _WHOLE else f"{value:.2g}"
