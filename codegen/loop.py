"""A closed loop of Blocks, and the library that runs it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import casadi as ca

from ..model.block import Block, BlockError
from ..model.wiring import with_numbers
from .bank import Bank
from .clock import clocked
from .constants import hoisted
from .export import Source, export_blocks
from .stepper import functions


@dataclass(frozen=True, eq=False)  # compared by identity: SX has no usable ==
class Loop:
    """A closed loop to export: the truth, the sensors that look at it, the observers, and the score of each."""

    truth: Block
    sensors: Block  # no states; inputs are outputs of the truth and noise
    bank: Bank
    score: Block
    noise: tuple[str, ...]  # held inputs that the kernel draws, in (−1, 1]
    pulses: tuple[str, ...]  # held inputs that the kernel switches on and off
    flags: tuple[str, str] = ("window", "sample")  # held inputs of the score: errors count, a sample instant

    @property
    def observers(self) -> tuple[Block, ...]:
        """Those of the bank."""
        return self.bank.observers

    @property
    def held(self) -> tuple[str, ...]:
        """All held inputs in array order."""
        return (*self.noise, *self.pulses, *self.flags)

    @property
    def noisy(self) -> bool:
        """Whether the truth depends on what sensors show, and so on the seed."""
        return any(port in self.noise for port in self.truth.u)

    @property
    def seen(self) -> tuple[str, ...]:
        """The outputs of the truth that the sensors measure."""
        return tuple(port for port in self.sensors.u if port not in self.held)

    @property
    def blocks(self) -> tuple[Block, ...]:
        """What has parameters of its own, in the kernel's order."""
        return (self.truth, self.sensors, *self.observers, self.score)

    @property
    def exported(self) -> tuple[Block, ...]:
        """All Blocks that become C."""
        return (*self.blocks, *self.bank.exported[len(self.observers) :])

    def __post_init__(self) -> None:
        names = [block.name for block in self.exported]
        if double := {name for name in names if names.count(name) > 1}:
            raise BlockError(f"two blocks of the loop are called {', '.join(sorted(double))}")
        outputs = list(self.observers[0].y)
        if odd := [observer.name for observer in self.observers if list(observer.y)[: len(outputs)] != outputs]:
            raise BlockError(f"{odd[0]}: its outputs must begin with {', '.join(outputs)}")

    def with_numbers(self, fixed: Mapping[str, Mapping[str, float]]) -> Loop:
        """The loop with numbers in the place of parameters: block → name → value. They make its code faster."""
        return replace(
            self,
            truth=with_numbers(self.truth, fixed[self.truth.name]),
            sensors=with_numbers(self.sensors, fixed[self.sensors.name]),
            bank=self.bank.with_numbers(fixed),
            score=with_numbers(self.score, fixed[self.score.name]),
        )

    def functions(self, block: Block) -> dict[str, ca.Function]:
        """The roles of one Block of the loop, with its parameters as an argument."""
        staged = {
            self.truth.name: (),
            self.sensors.name: self.seen,
            self.score.name: (*self.truth.y, *self.observers[0].y),
        }.get(block.name)
        if staged is None:
            staged = self.bank.staged(block)
        return functions(block, self.held, staged, self.seen if block is self.truth else ())

    def compiled(self, block: Block) -> dict[str, ca.Function]:
        """The same as the kernel calls them: without what follows from the parameters, or for the truth from time."""
        table = hoisted(block.name, self.functions(block))
        return clocked(block.name, table) if block is self.truth else table


def export_loop(loop: Loop) -> Source:
    """A library that runs the loop for any parameters, initial values, seeds, durations and choice of observers."""
    sizes = {
        "N_NOISE": len(loop.noise),
        "N_PULSES": len(loop.pulses),
        "N_SEEN": len(loop.seen),
        "N_TRUTH": len(loop.truth.y),
        "N_ESTIMATES": len(loop.observers[0].y),
        "N_OBSERVERS": len(loop.observers),
        **loop.bank.sizes(),
    }
    return export_blocks(
        tables={block.name: loop.compiled(block) for block in loop.exported},
        blocks=loop.exported,
        sizes=sizes,
        named={"Truth": loop.truth, "Sensors": loop.sensors, "Score": loop.score, **loop.bank.named()},
        lists={"Observers": loop.observers, "Everything": loop.exported},
        files=("philox.hpp", "front.hpp", "loop.cpp"),
        held=loop.held,
    )
