"""The situations that observers are compared in."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ..scenarios.layers import Value, layers
from ..scenarios.prepare import prepare


@dataclass(frozen=True)
class Cell:
    """A situation: a scenario with changes. believed: number of each observer → factor by which it takes it wrongly."""

    name: str
    sentence: str
    source: str = "paper-noisy"
    changes: Mapping[str, Value] = field(default_factory=dict)
    believed: Mapping[str, float] = field(default_factory=dict)

    def changes_for(self, observers: Sequence[str]) -> dict[str, Value]:
        """The changes, and what these observers believe."""
        if not self.believed:
            return dict(self.changes)
        true = prepare(self.source, None, self.changes)
        wrong = {
            f"{observer}.{number}": factor * true.value(f"{observer}.{number}")
            for observer in observers
            for number, factor in self.believed.items()
        }
        return {**self.changes, **wrong}


# forces that a muscle's tendon has at all lengths
_STIFFNESS = tuple(f"muscle{j}.{number}" for j in (1, 2) for number in ("k", "F_toe"))


def shipped_numbers(name: str) -> dict[str, float]:
    """Path → number of a shipped scenario, as its file has them."""
    _, (file, _) = layers(name, {})
    return {path: float(value) for path, value in file.leaves.items() if isinstance(value, int | float)}


def _noise(times: int) -> Cell:
    own = shipped_numbers(HOME.source)
    half_widths: dict[str, Value] = {path: times * own[path] for path in ("noise.x1", "noise.force")}
    return Cell(f"noise × {times}", f"noise of position and forces × {times}", changes=half_widths)


def _wrong(what: str, numbers: Sequence[str], percent: int) -> Cell:
    words = f"{what} {'+' if percent > 0 else '−'} {abs(percent)} %"
    return Cell(words, f"all observers take the {words}", believed=dict.fromkeys(numbers, 1 + percent / 100))


HOME = Cell("paper-noisy", "the paper's second simulation")
CELLS = (
    HOME,
    Cell("challenge", "a fast reference, a strong uncertainty", "challenge"),
    Cell("slack", "a tendon goes slack for a while", "slack"),
    *(_wrong("mass", ("m",), percent) for percent in (-10, 10)),
    *(_wrong("stiffness", _STIFFNESS, percent) for percent in (-10, 10)),
    *map(_noise, (3, 10)),
    Cell(
        "start × 10",
        "start of the estimates ten times as wrong",
        # x = (2.6, 0, 2.018, 2.018); the paper's estimates start at (2.62, 0, 2.01, 2.01)
        changes={"initial.x1_hat": 2.8, "initial.x3_hat": 1.938, "initial.x4_hat": 1.938},
    ),
    Cell("T = 200", "ten times as long", changes={"duration": 200.0, "record": 0.1}),
)
