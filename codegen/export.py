"""CasADi functions and the hand-written kernel as one C++ translation unit, with a description of every array."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources

import casadi as ca

from ..model.block import Block, BlockError
from .stepper import ROLES, functions

_KERNEL = "hillobs.codegen.kernel"


@dataclass(frozen=True)
class Source:
    """One translation unit, and names and sizes of its arrays in order."""

    text: str
    description: Mapping[str, object]
    functions: tuple[ca.Function, ...]


@dataclass(frozen=True, eq=False)  # one is itself: symbols have no equality
class Loop:
    """A closed loop to export: the truth, its observers, the score of each, and what passes between them."""

    truth: Block
    observers: tuple[Block, ...]
    score: Block
    measured: tuple[str, ...]  # outputs of the truth that observers see
    noise: tuple[str, ...]  # held inputs that the kernel draws, in (−1, 1]
    pulses: tuple[str, ...]  # held inputs that the kernel switches on and off
    flags: tuple[str, str] = ("window", "sample")  # held inputs of the score: errors count, a sample instant

    @property
    def held(self) -> tuple[str, ...]:
        """All held inputs in array order."""
        return (*self.noise, *self.pulses, *self.flags)

    @property
    def blocks(self) -> tuple[Block, ...]:
        """The rows of the C table."""
        return (self.truth, *self.observers, self.score)

    def __post_init__(self) -> None:
        names = [block.name for block in self.blocks]
        if double := {name for name in names if names.count(name) > 1}:
            raise BlockError(f"two blocks of the loop are called {', '.join(sorted(double))}")


def export_functions(every: Sequence[ca.Function]) -> Source:
    """A library of functions, to be evaluated at many points."""
    return _source(every, {}, "", [])


def export_loop(loop: Loop) -> Source:
    """A library that runs the loop for any parameters, initial values, seeds, durations and choice of observers."""
    scored = (*loop.truth.y, *loop.observers[0].y)
    tables = [functions(loop.truth, loop.held, (), loop.measured)]
    tables += [functions(observer, loop.held, loop.measured) for observer in loop.observers]
    tables += [functions(loop.score, loop.held, scored)]
    rows = ",\n    ".join(_row(block, table) for block, table in zip(loop.blocks, tables, strict=True))
    staged = [list(loop.truth.y).index(name) for name in loop.measured]
    sizes = {
        "N_NOISE": len(loop.noise),
        "N_PULSES": len(loop.pulses),
        "N_STAGED": len(staged),
        "SCORE_BLOCK": len(loop.blocks) - 1,
        "MAX_STATES": max(1, *(len(block.x) for block in loop.blocks)),
        "MAX_GUARDS": max(1, *(max(len(block.guards), len(block.domain)) for block in loop.blocks)),
        "MAX_SCORED": len(scored),
    }
    text = f"static const Block BLOCKS[] = {{\n    {rows}}};\nstatic const int STAGED[] = {{{_list(staged)}}};\n"
    description = {
        "held": list(loop.held),
        "measured": list(loop.measured),
        "blocks": [_describe(block) for block in loop.blocks],
    }
    every = [function for table in tables for function in table.values()]
    return _source(every, description, _enumeration(sizes) + text, ["philox.hpp", "loop.cpp"])


def _source(every: Sequence[ca.Function], description: Mapping[str, object], tables: str, kernel: list[str]) -> Source:
    for function in every:
        if not all(function.sparsity_in(i).is_dense() for i in range(function.n_in())) or not all(
            function.sparsity_out(i).is_dense() for i in range(function.n_out())
        ):
            raise ValueError(f"{function.name()}: arguments and results must be dense")
    parts = [_kernel("types.hpp"), _c_text(every), _kernel("end.hpp"), _function_table(every), tables]
    text = "\n".join([*parts, *map(_kernel, kernel), _kernel("call.cpp")])
    listed = [
        {"name": f.name(), "in": _sizes(f.n_in(), f.numel_in), "out": _sizes(f.n_out(), f.numel_out)} for f in every
    ]
    return Source(text, {"functions": listed, **description}, tuple(every))


def _c_text(every: Sequence[ca.Function]) -> str:
    generator = ca.CodeGenerator("generated.c")
    for function in every:
        generator.add(function)
    return str(generator.dump())


def _kernel(name: str) -> str:
    return (resources.files(_KERNEL) / name).read_text(encoding="utf-8")


def _function_table(every: Sequence[ca.Function]) -> str:
    rows = []
    lists = []
    for i, f in enumerate(every):
        for way, sizes in (("in", _sizes(f.n_in(), f.numel_in)), ("out", _sizes(f.n_out(), f.numel_out))):
            lists.append(f"static const int {way}_{i}[] = {{{_list(sizes)}}};")
        rows.append(f'{{"{f.name()}", {f.name()}, {f.n_in()}, {f.n_out()}, in_{i}, out_{i}}}')
    largest = {
        "MAX_ARGUMENTS": max(max(f.n_in(), f.n_out(), f.sz_arg(), f.sz_res()) for f in every),
        "MAX_WORK": max(1, *(max(f.sz_w(), f.sz_iw()) for f in every)),
    }
    table = "static const Function FUNCTIONS[] = {\n    " + ",\n    ".join(rows) + "};\n"
    return "\n".join([*lists, table]) + _enumeration(largest)


def _row(block: Block, table: Mapping[str, ca.Function]) -> str:
    sizes = f"{len(block.x)}, {len(block.y)}, {len(block.guards)}, {len(block.domain)}"
    roles = ", ".join(table[role].name() if role in table else "0" for role in ROLES)
    return f'{{"{block.name}", {sizes}, {roles}}}'


def _describe(block: Block) -> dict[str, object]:
    groups = {"x": block.x, "p": block.p, "y": block.y, "guards": block.guards, "domain": block.domain}
    return {"name": block.name, **{group: list(entries) for group, entries in groups.items()}}


def _sizes(n: int, numel: Callable[[int], int]) -> list[int]:
    return [numel(i) for i in range(n)]


def _list(numbers: Sequence[int]) -> str:
    return ", ".join(map(str, numbers)) or "0"


def _enumeration(sizes: Mapping[str, int]) -> str:
    return "enum { " + ", ".join(f"{name} = {value}" for name, value in sizes.items()) + " };\n"
