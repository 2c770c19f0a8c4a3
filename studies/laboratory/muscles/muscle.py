"""A muscle in SI: its curve set, its sizes, the numbers of its curves, and how well they are known."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from ....model.block import Parameter
from ....model.curves import CurveSet
from ....model.fibre import PENNATION
from ...files.errors import ScenarioError
from ...files.numbers import within
from ...files.quote import shown, table
from ..deviations import deviation

FILE = "muscle file"
# No default: a muscle is not known without them. The ranges reach decades beyond the smallest muscles of a mouse and
# the largest of an elephant (docs/recordings.md); the upper ones of lengths find millimetres where metres belong.
SIZES: Mapping[str, Parameter] = {
    "F_max": Parameter(math.nan, "largest isometric force", FILE, "N", least=1e-6, most=1e7),
    "optimal_fibre_length": Parameter(math.nan, "fibre length of the largest force", FILE, "m", least=1e-5, below=10),
    "tendon_slack_length": Parameter(
        math.nan, "length below which the tendon is slack", FILE, "m", least=1e-6, below=10
    ),
    "v_max": Parameter(
        math.nan,
        "largest shortening velocity, in optimal fibre lengths per second",
        FILE,
        "1/s",
        least=0.01,
        below=1000,
    ),
}
# what a curve set calls the sizes, in those of muscle 1; they follow from the file
SCALED: Mapping[str, str] = {
    "F_max": "F_max",
    "optimal_fibre_length": "l_opt",
    "tendon_slack_length": "L_slack",
    "v_max": "v_max",
}


@dataclass(frozen=True)
class Muscle:
    """F_max N, optimal_fibre_length and tendon_slack_length m, v_max in own optimal fibre lengths per second.

    curves: one of CURVES, or of tables.
    numbers: those of the curve set, its defaults where left out. sds: standard deviations of numbers that are known
    only so well, in their units. pennation: rad.
    ScenarioError for what is no number, or beyond the ranges of docs/recordings.md.
    """

    curves: CurveSet
    F_max: float
    optimal_fibre_length: float
    tendon_slack_length: float
    v_max: float
    numbers: Mapping[str, float] = field(default_factory=dict)
    sds: Mapping[str, float] = field(default_factory=dict)
    pennation: float = PENNATION.default

    def __post_init__(self) -> None:
        if not isinstance(self.curves, CurveSet):
            raise ScenarioError(f"curves must be those of a muscle file or of hillobs.CURVES, not {shown(self.curves)}")
        given, known = table("numbers", self.numbers), numbers_of(self.curves)
        if odd := [key for key in given if key not in known]:
            raise ScenarioError(f"numbers must be of {', '.join(known)}, not of {shown(odd[0])}")
        own = {**SIZES, "pennation": PENNATION}
        for key, parameter in own.items():
            object.__setattr__(self, key, within(key, getattr(self, key), parameter))
        object.__setattr__(
            self, "numbers", {key: within(key, given.get(key, known[key].default), known[key]) for key in known}
        )
        object.__setattr__(self, "sds", deviations(self.sds, self.values, {**own, **known}))

    @property
    def sizes(self) -> dict[str, float]:
        """F_max and so on by the names that curve sets have, in SI."""
        return {name: getattr(self, key) for key, name in SCALED.items()}

    @property
    def values(self) -> dict[str, float]:
        """All its numbers, by the keys of a file."""
        return {**{key: getattr(self, key) for key in SIZES}, "pennation": self.pennation, **self.numbers}


def numbers_of(curves: CurveSet) -> dict[str, Parameter]:
    """What a curve set has beside the sizes; it may be left out."""
    return {key: parameter for key, parameter in curves.parameters.items() if key not in SCALED.values()}


def deviations(given: object, values: Mapping[str, float], known: Mapping[str, Parameter]) -> dict[str, float]:
    """The standard deviations of some `values`, checked. ScenarioError says what is wrong."""
    sds = table("sds", given)
    if odd := [key for key in sds if key not in known]:
        raise ScenarioError(f"sds must be of {', '.join(known)}, not of {shown(odd[0])}")
    return {key: deviation(key, sd, values[key], known[key].unit) for key, sd in sds.items()}
