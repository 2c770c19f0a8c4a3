"""What a target says of an observer beside its functions: names, units, bounds and sentences of all numbers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca


@dataclass(frozen=True)
class Member:
    """One number of an array: the Block's name for it, unit, what it is, bounds in words, if any, and as numbers.

    least, most: what is above the one or below the other is within them too.
    """

    name: str
    unit: str
    sentence: str
    bounds: str = ""
    least: float = -math.inf
    most: float = math.inf


@dataclass(frozen=True, eq=False)  # functions have no usable ==
class Manifest:
    """An observer to be written for a target; all arrays in the order of its functions, those of `Follower`.

    prefix: what the names of all functions begin with. guards: so many of the estimates, the last ones. columns: what
    tables call each input. period: in `time_unit`.
    """

    name: str
    prefix: str
    label: str
    sentence: str
    version: str
    period: float
    time_unit: str
    substeps: int
    units: str
    state: Sequence[Member]
    params: Sequence[Member]
    input: Sequence[Member]
    estimate: Sequence[Member]
    guards: int
    defaults: Sequence[float]
    columns: Sequence[str]
    functions: Mapping[str, ca.Function]


def one_line(words: str) -> str:
    """Words of others without what ends a line or is not for reading."""
    return "".join(c if c.isprintable() else " " for c in words)
