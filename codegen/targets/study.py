"""What a target says of a closed loop beside its functions: its time grid, its numbers and what they may be."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca

from ..loop import Loop
from ..memory import Grid


@dataclass(frozen=True)
class Number:
    """A number that may be changed: where it is, what it is, its value, and what it may be.

    above, least, below, most: value > above, ≥ least, < below, ≤ most; None where there is no such bound. reach: from
    where to where it is worth trying, or None; logarithmic: in equal ratios.
    """

    path: str
    sentence: str
    unit: str
    value: float
    above: float | None
    least: float | None
    below: float | None
    most: float | None
    whole: bool
    reach: tuple[float, float] | None
    logarithmic: bool


@dataclass(frozen=True)
class Shown:
    """Something that is estimated: its name, symbol in Unicode, and sentence."""

    name: str
    symbol: str
    sentence: str


@dataclass(frozen=True, eq=False)  # compared by identity: functions have no usable ==
class Study:
    """A scenario to be written for a target.

    observers: name → label. first: the quantities that are shown at first. numbers: those that stand at a path of their
    own; paths: Block name → the path of each of its numbers; shared: path → the path whose number it takes unless it is
    given one itself. given: path → number. measures: those that `formulas` gives of the score's sums, each with its
    sentence, of all quantities. rules: what must hold between numbers, in words; `sides` gives the smaller and the
    larger side of each rule, of the numbers at the paths `ruled`.
    """

    name: str
    sentence: str
    version: str
    loop: Loop
    grid: Grid
    seed: int
    observers: Mapping[str, str]
    quantities: Sequence[Shown]
    first: Sequence[str]
    numbers: Sequence[Number]
    paths: Mapping[str, Sequence[str]]
    shared: Mapping[str, str]
    given: Mapping[str, float]
    measures: Mapping[str, str]
    formulas: ca.Function
    rules: Sequence[str]
    ruled: Sequence[str]
    sides: ca.Function
