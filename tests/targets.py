"""What the libraries under test are compiled for: this processor, or a target that stands for another one."""

from hillobs.codegen import toolchain
from hillobs.codegen.toolchain import NATIVE, SINGLE, TARGETS, find_compiler, target_flags

NEWTON, PLAIN = DIVISIONS = ("newton", "plain")


def stand_in(target: str | None, division: str | None) -> None:
    """Let `target` take the place of this processor, for the rest of the process. BuildError if it cannot run here."""
    if target:
        target_flags(target, find_compiler())
        lanes, scalar = TARGETS[target], TARGETS["scalar"]
        toolchain.TARGETS = {**TARGETS, NATIVE: lanes, SINGLE: tuple(dict.fromkeys((*lanes, *scalar)))}
    if division:
        toolchain.divides_slowly = lambda: division == NEWTON
