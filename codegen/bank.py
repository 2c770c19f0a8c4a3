"""Observers that look at the same measurements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from ..model.block import Block
from ..model.wiring import with_numbers
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

    def with_numbers(self, fixed: Mapping[str, Mapping[str, float]]) -> Bank:
        """The bank with numbers in the place of parameters: observer → name → value.

        The front finds its parameters in each observer, so they become numbers if all observers have the same ones.
        """
        everywhere = {name: {fixed[block.name].get(name) for block in self.observers} for name in self.front.p}
        shared = {name: only for name, (only, *others) in everywhere.items() if only is not None and not others}

        def written(block: Block, numbers: Mapping[str, float]) -> Block:
            own = (name for name in numbers if name in block.p and (name in shared or name not in everywhere))
            return with_numbers(block, {name: numbers[name] for name in own})

        return replace(
            self,
            front=written(self.front, shared),
            near=written(self.near, shared) if self.near else None,
            observers=tuple(written(block, fixed[block.name]) for block in self.observers),
        )

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
