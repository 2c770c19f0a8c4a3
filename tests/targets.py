"""What the libraries under test are compiled for: this processor, or a target that stands for another one."""

from hillobs.codegen import toolchain
from hillobs.codegen.toolchain import NATIVE, SINGLE, find_compiler, target_flags

DIVISIONS = ("newton", "plain")
SCALAR = toolchain.TARGETS["scalar"]

_chosen = {"target": NATIVE, "division": "that of this processor"}


def stand_in(target: str | None, division: str | None) -> None:
    """Let `target` take the place of this processor, for the rest of the process. BuildError if it cannot run here."""
    if target:
        target_flags(target, find_compiler())
        flags = toolchain.TARGETS[target]
        toolchain.TARGETS = {**toolchain.TARGETS, NATIVE: flags, SINGLE: tuple(dict.fromkeys((*flags, *SCALAR)))}
        _chosen["target"] = target
    if division:
        toolchain.divides_slowly = lambda: division == "newton"
        _chosen["division"] = division


def sentence() -> str:
    """What this run compiles for, and with what."""
    compiler = find_compiler()
    return f"libraries: {_chosen['target']}, division {_chosen['division']}, {compiler.version.splitlines()[0]}"
