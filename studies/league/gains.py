"""The sets of gains that observers play with."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from ...observers import OBSERVERS
from ..estimate.of_scenario import sampled
from .cells import Cell, shipped_numbers

# the shipped scenario whose gains are those that `hillobs tune` found for the paper's noisy one
TUNED = "tuned"
# the paper's structure with a number more each: chains of two speeds, second layers that forget
_VARIANT = {"high_gain.eps_h": 0.21, "high_gain.eps_L": 0.046, "adaptive_sliding_mode.leak": 5.0}


@dataclass(frozen=True)
class Gains:
    """A set of gains: who plays with it, path → value in a cell, and whether layers are corrected."""

    name: str
    sentence: str
    observers: tuple[str, ...]
    numbers: Callable[[Cell], Mapping[str, float]]
    corrected: bool = False


def _by_rule(cell: Cell) -> dict[str, float]:
    record = sampled(cell.source, cell.changes).record
    return {
        f"{name}.{number}": value
        for name, observer in OBSERVERS.items()
        for number, value in observer.gains(record.sizes, record.T).items()
    }


def _tuned(cell: Cell) -> dict[str, float]:
    return {path: value for path, value in shipped_numbers(TUNED).items() if path.partition(".")[0] in OBSERVERS}


SETS = (
    Gains("default", "the paper's, or an observer's usual ones", tuple(OBSERVERS), lambda cell: {}),
    Gains(
        "variant",
        ", ".join(f"{path} = {value:g}" for path, value in _VARIANT.items()),
        tuple(dict.fromkeys(path.partition(".")[0] for path in _VARIANT)),
        lambda cell: _VARIANT,
    ),
    Gains(
        "rule", "those of docs/gains.md for the samples of a run, layers corrected", tuple(OBSERVERS), _by_rule, True
    ),
    Gains("tuned", f"found by `hillobs tune` on paper-noisy: the scenario `{TUNED}`", tuple(OBSERVERS), _tuned),
)
