"""What must hold between several numbers of a scenario."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from ...model.block import Block
from ...model.curves import CurveSet
from ...model.rules import Below
from .paths import Paths, block_paths

# each tendon has this number
_OF_A_TENDON = ".L_slack"


@dataclass(frozen=True)
class Rule:
    """A rule for the numbers at some paths, by the names that it has for them; owner: whose they are, or nothing."""

    owner: str
    below: Below
    paths: Mapping[str, str]

    def __str__(self) -> str:
        words = f"{self.below.left} must be below {self.below.right}, {self.below.because}"
        return f"{self.owner}: {words}" if self.owner else words

    def objection(self, paths: Paths, given: Mapping[str, float]) -> str:
        """What does not hold with the numbers given, or an empty string."""
        wrong = self.below.objection({name: paths.value(path, given) for name, path in self.paths.items()})
        return f"{self.owner}: {wrong}" if wrong and self.owner else wrong


def rules(truth: Block, observers: Sequence[Block], curves: Mapping[str, CurveSet]) -> Iterator[Rule]:
    """Those of the tendons, each Block's own, and of the truth's force factors; curves: by muscle."""
    paths = dict.fromkeys(path for block in (truth, *observers) for path in block_paths(block))
    for owner in [path.removesuffix(_OF_A_TENDON) for path in paths if path.endswith(_OF_A_TENDON)]:
        curve_set = curves[owner.rpartition(".")[2]]
        if curve_set.rises:
            yield Rule(owner, curve_set.rises, {name: f"{owner}.{name}" for name in curve_set.tendon})
    for muscle in curves:
        limit, pole = f"{muscle}.z_max", f"{muscle}.g_max"
        if {limit, pole} <= set(truth.p):
            below = Below(limit, pole, "the pole of g⁻¹", lambda p: (p.limit, p.pole))
            yield Rule("", below, {"limit": limit, "pole": pole})
