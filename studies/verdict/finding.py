"""One line of a verdict."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Finding:
    """What was looked at, what was found, a number to it, and whether that makes recording or muscles doubtful."""

    subject: str
    sentence: str
    value: float
    doubtful: bool = False
