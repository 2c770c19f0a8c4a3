"""Observers that look at the same measurements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from ..model.block import Block
from .stepper import STAGES


@dataclass(frozen=True, eq=False)  # compared by identity: SX has no usable ==
class Bank:
    """Observers, what they measure, and the `front`: what they compute from the measurements alone, without states.

    Observers with the same numbers for the front share its values; its parameters are theirs of the same names. `near`,
    if given, is the front at all stages of a step at once (`y2.0`, … in, `L_S1.0`, … and `doubt` out), for less; where
    it doubts, the front is taken.
    """

    measured: tuple[str, ...]
    front: Block
    near: Block | None
    observers: tuple[Block, ...]

    @property
    def exported(self) -> tuple[Block, ...]:
        """All Blocks that become C."""
        return (*self.observers, self.front, *([self.near] if self.near else []))

    def staged(self, block: Block) -> tuple[str, ...]:
        """What `block`, one of ours, is given at each stage."""
        if block is self.near:
            return tuple(f"{name}.{i}" for i in range(STAGES) for name in (*self.measured, *self.front.y))
        return self.measured if block is self.front else (*self.measured, *self.front.y)

    def sizes(self) -> dict[str, int]:
        """What the kernel must know of the front."""
        return {
            "N_MEASURED": len(self.measured),
            "N_FRONT": len(self.front.y),
            "HAS_NEAR": int(self.near is not None),
        }

    def named(self) -> Mapping[str, Block]:
        """The Blocks that the kernel calls by name."""
        return {"Front": self.front, "Near": self.near or self.front}
