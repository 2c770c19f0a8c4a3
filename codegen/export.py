"""CasADi functions and the hand-written kernel as one C++ translation unit, with a description of every array."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources

import casadi as ca

from ..model.block import Block, BlockError
from .constants import hoisted
from .stepper import STAGES, functions

_KERNEL = "hillobs.codegen.kernel"
# what a block of the loop can do: arguments and results of each role, in the order of the kernel's calls
_ROLES = {
    "constants": (("h", "p"), ("c",)),
    "init": (("t", "p", "held", "staged"), ("x_next",)),
    "step": (("t", "c", "x", "held", "staged"), ("x_next", "stages")),
    "sample": (("t", "c", "x", "held", "staged"), ("x_next",)),
    "each": (("t", "c", "x", "held", "staged"), ("x_next",)),
    "out": (("t", "c", "x", "held", "staged"), ("y", "domain")),
    "watch": (("t", "c", "x", "held", "staged"), ("guards",)),
}


@dataclass(frozen=True)
class Source:
    """One translation unit, and names and sizes of its arrays in order."""

    text: str
    description: Mapping[str, object]


@dataclass(frozen=True, eq=False)  # one is itself: symbols have no equality
class Loop:
    """A closed loop to export: the truth, the sensors that look at it, the observers, and the score of each.

    What observers compute from the measurements alone is the `front`, without states; observers with the same numbers
    for it share its values. Its parameters are theirs of the same names. `near`, if given, is the front at all stages
    of a step at once (`y2.0`, … in, `L_S1.0`, … and `doubt` out), for less; where it doubts, the front is taken.
    """

    truth: Block
    sensors: Block  # no states; inputs are outputs of the truth and noise
    front: Block
    near: Block | None
    observers: tuple[Block, ...]
    score: Block
    noise: tuple[str, ...]  # held inputs that the kernel draws, in (−1, 1]
    pulses: tuple[str, ...]  # held inputs that the kernel switches on and off
    flags: tuple[str, str] = ("window", "sample")  # held inputs of the score: errors count, a sample instant

    @property
    def held(self) -> tuple[str, ...]:
        """All held inputs in array order."""
        return (*self.noise, *self.pulses, *self.flags)

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
        return (*self.blocks, self.front, *([self.near] if self.near else []))

    def __post_init__(self) -> None:
        names = [block.name for block in self.exported]
        if double := {name for name in names if names.count(name) > 1}:
            raise BlockError(f"two blocks of the loop are called {', '.join(sorted(double))}")
        outputs = list(self.observers[0].y)
        if odd := [observer.name for observer in self.observers if list(observer.y) != outputs]:
            raise BlockError(f"{odd[0]}: its outputs must be {', '.join(outputs)}")

    def functions(self, block: Block) -> dict[str, ca.Function]:
        """The roles of one Block of the loop, with its parameters as an argument."""
        measured = tuple(self.sensors.y)
        staged = {
            self.truth.name: (),
            self.sensors.name: self.seen,
            self.front.name: measured,
            self.score.name: (*self.truth.y, *self.observers[0].y),
        }.get(block.name, (*measured, *self.front.y))
        if block is self.near:
            staged = tuple(f"{name}.{i}" for i in range(STAGES) for name in (*measured, *self.front.y))
        return functions(block, self.held, staged, self.seen if block is self.truth else ())


def export_functions(every: Sequence[ca.Function]) -> Source:
    """A library of functions, to be evaluated at many points."""
    for function in every:
        _refuse_sparse(function)
    parts = [*_lanes(), _casadi("static", every), _function_table(every), _kernel("call.cpp")]
    listed = [
        {"name": f.name(), "in": _sizes(f.n_in(), f.numel_in), "out": _sizes(f.n_out(), f.numel_out)} for f in every
    ]
    return Source("\n".join(parts), {"functions": listed})


def export_loop(loop: Loop) -> Source:
    """A library that runs the loop for any parameters, initial values, seeds, durations and choice of observers."""
    tables = {block.name: hoisted(block.name, loop.functions(block)) for block in loop.exported}
    every = [function for table in tables.values() for function in table.values()]
    parts = [_part(block, tables[block.name]) for block in loop.exported]
    sizes = {
        "N_NOISE": len(loop.noise),
        "N_PULSES": len(loop.pulses),
        "N_SEEN": len(loop.seen),
        "N_MEASURED": len(loop.sensors.y),
        "N_FRONT": len(loop.front.y),
        "HAS_NEAR": int(loop.near is not None),
        "N_TRUTH": len(loop.truth.y),
        "N_ESTIMATES": len(loop.observers[0].y),
        "N_OBSERVERS": len(loop.observers),
    }
    names = {
        "Truth": loop.truth.name,
        "Sensors": loop.sensors.name,
        "Score": loop.score.name,
        "Front": loop.front.name,
        "Near": (loop.near or loop.front).name,
    }
    aliases = [f"typedef Part_{name} {alias};" for alias, name in names.items()]
    lists = {"Observers": loop.observers, "Everything": loop.exported}
    aliases += [
        f"typedef List<{', '.join(f'Part_{block.name}' for block in blocks)}> {alias};"
        for alias, blocks in lists.items()
    ]
    inline = "static inline __attribute__((always_inline))"
    text = [*_lanes(), _casadi(inline, every), _kernel("philox.hpp"), *parts, _enumeration(sizes)]
    text += ["template <class... Blocks> struct List {};", *aliases, _kernel("loop.cpp")]
    description = {
        "held": list(loop.held),
        "blocks": [_describe(block, tables[block.name]) for block in loop.exported],
    }
    return Source("\n".join(text), description)


def _lanes() -> list[str]:
    return [_kernel("lanes.hpp"), _kernel("functions.hpp")]


def _casadi(linkage: str, every: Sequence[ca.Function]) -> str:
    """The C that CasADi writes, unchanged, with lanes in the place of double."""
    generator = ca.CodeGenerator("generated.c")
    for function in every:
        generator.add(function)
    before = f"#define CASADI_SYMBOL_EXPORT {linkage}\n" + _kernel("before.hpp")
    return "\n".join([before, str(generator.dump()), _kernel("after.hpp")])


def _part(block: Block, table: Mapping[str, ca.Function]) -> str:
    """A type of the kernel's for `block`: its sizes, and its functions with plain arrays as arguments."""
    sizes = {
        "NX": len(block.x),
        "NP": len(block.p),
        "NC": table["constants"].numel_out(0),
        "NY": len(block.y),
        "N_GUARDS": len(block.guards),
        "N_DOMAIN": len(block.domain),
        **{f"HAS_{role.upper()}": int(role in table) for role in ("sample", "each")},
    }
    roles = [_role(role, table[role]) for role in _ROLES if role in table]
    return f"struct Part_{block.name} {{\n    {_enumeration(sizes)}{_total(block)}{''.join(roles)}}};\n"


def _total(block: Block) -> str:
    """The sum of all states and outputs, which is finite only if they are; an output that is a state counts once."""
    states = {symbol.element_hash() for symbol in block.x.values()}
    terms = [f"x[{i}]" for i in range(len(block.x))]
    terms += [f"y[{i}]" for i, output in enumerate(block.y.values()) if output.element_hash() not in states]
    return f"    INLINE V total(const V *x, const V *y) {{ (void)x, (void)y; return {' + '.join(terms or ['V(0.0)'])}; }}\n"


def _role(role: str, function: ca.Function) -> str:
    names_in, names_out = _ROLES[role]
    arguments = ", ".join([*(f"const V *{name}" for name in names_in), *(f"V *{name}" for name in names_out)])
    given = ", ".join(function.name_in())
    wanted = ", ".join(function.name_out())
    sizes = {
        **{name: function.numel_in(i) for i, name in enumerate(function.name_in())},
        **{name: function.numel_out(i) for i, name in enumerate(function.name_out())},
    }
    # what a compiler knows of the pointers spares CasADi's question whether they are null
    known = "".join(f" {'given' if sizes.get(name) else 'unused'}({name});" for name in (*names_in, *names_out))
    return (
        f"    INLINE void {role}({arguments}) {{\n       {known}\n"
        f"        const V *arg[] = {{{given}}};\n        V *res[] = {{{wanted}}};\n"
        f"        {function.name()}(arg, res, 0, 0, 0);\n    }}\n"
    )


def _refuse_sparse(function: ca.Function) -> None:
    if not all(function.sparsity_in(i).is_dense() for i in range(function.n_in())) or not all(
        function.sparsity_out(i).is_dense() for i in range(function.n_out())
    ):
        raise ValueError(f"{function.name()}: arguments and results must be dense")


def _kernel(name: str) -> str:
    return (resources.files(_KERNEL) / name).read_text(encoding="utf-8")


def _function_table(every: Sequence[ca.Function]) -> str:
    rows = []
    lists = []
    for i, f in enumerate(every):
        for way, sizes in (("in", _sizes(f.n_in(), f.numel_in)), ("out", _sizes(f.n_out(), f.numel_out))):
            lists.append(f"static const int {way}_{i}[] = {{{_list(sizes)}}};")
        rows.append(f"{{{f.name()}, {f.n_in()}, {f.n_out()}, in_{i}, out_{i}}}")
    largest = {
        "MAX_ARGUMENTS": max(max(f.n_in(), f.n_out(), f.sz_arg(), f.sz_res()) for f in every),
        "MAX_NUMBERS": max(1, *(f.nnz_in() + f.nnz_out() for f in every)),
        "MAX_WORK": max(1, *(max(f.sz_w(), f.sz_iw()) for f in every)),
    }
    table = _kernel("function.hpp") + "static const Function FUNCTIONS[] = {\n    " + ",\n    ".join(rows) + "};\n"
    return "\n".join([*lists, table]) + _enumeration(largest)


def _describe(block: Block, table: Mapping[str, ca.Function]) -> dict[str, object]:
    groups = {"x": block.x, "p": block.p, "y": block.y, "guards": block.guards, "domain": block.domain}
    return {
        "name": block.name,
        **{group: list(entries) for group, entries in groups.items()},
        "constants": table["constants"].numel_out(0),
    }


def _sizes(n: int, numel: Callable[[int], int]) -> list[int]:
    return [numel(i) for i in range(n)]


def _list(numbers: Sequence[int]) -> str:
    return ", ".join(map(str, numbers)) or "0"


def _enumeration(sizes: Mapping[str, int]) -> str:
    return "enum { " + ", ".join(f"{name} = {value}" for name, value in sizes.items()) + " };\n"
