"""CasADi functions and the hand-written kernel as one C++ translation unit, with a description of every array."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources

import casadi as ca

from ..model.block import Block
from .lowering import without_branches
from .stepper import NODES, WEIGHTS

_KERNEL = "hillobs.codegen.kernel"
# what a block of the loop can do: arguments and results of each role, in the order of the kernel's calls
ROLES = {
    "constants": (("h", "p"), ("c",)),
    "scales": (("h", "p"), ("scales",)),
    "clock": (("t", "c"), ("row",)),
    "init": (("t", "p", "held", "staged"), ("x_next",)),
    "step": (("t", "c", "x", "held", "staged"), ("x_next", "stages")),
    "stage": (("t", "node", "c", "x", "held", "staged"), ("dx", "seen")),
    "sample": (("t", "c", "x", "held", "staged"), ("x_next",)),
    "each": (("t", "c", "x", "held", "staged"), ("x_next",)),
    "out": (("t", "c", "x", "held", "staged"), ("y", "domain")),
    "watch": (("t", "c", "x", "held", "staged"), ("guards",)),
}


_BY_STAGES = """\
    INLINE void step(const V *t, const V *c, const V *x, const V *held, const V *staged, V *x_next, V *stages) {{
        by_stages<Part_{block}>(t, c, x, held, staged, x_next, stages);
    }}
"""


@dataclass(frozen=True)
class Source:
    """One translation unit, and names and sizes of its arrays in order."""

    text: str
    description: Mapping[str, object]


def export_functions(functions: Sequence[ca.Function], caller: str = "call.cpp") -> Source:
    """A library of functions, to be evaluated at many points, or by another `caller` of the kernel."""
    for function in functions:
        _refuse_sparse(function)
    functions = [without_branches(function) for function in functions]
    title = f"// Functions: {', '.join(function.name() for function in functions)}"
    parts = [title, *_lanes(), _casadi("static", functions), _function_table(functions), _kernel(caller)]
    listed = [
        {"name": f.name(), "in": _sizes(f.n_in(), f.numel_in), "out": _sizes(f.n_out(), f.numel_out)} for f in functions
    ]
    return Source("\n".join(parts), {"functions": listed})


def export_blocks(
    tables: Mapping[str, Mapping[str, ca.Function]],
    blocks: Sequence[Block],
    sizes: Mapping[str, int],
    named: Mapping[str, Block],
    lists: Mapping[str, Sequence[Block]],
    files: Sequence[str],
    held: Sequence[str] = (),
) -> Source:
    """A library of Blocks at work: the functions of each by role, and the kernel `files` that call them.

    The files know the Blocks by the names in `named` and `lists`, and the `sizes`.
    """
    functions = [function for table in tables.values() for function in table.values()]
    aliases = [f"typedef Part_{block.name} {alias};" for alias, block in named.items()]
    aliases += [
        f"typedef List<{', '.join(f'Part_{block.name}' for block in some)}> {alias};" for alias, some in lists.items()
    ]
    title = f"// Blocks, run by {files[-1]}: {', '.join(block.name for block in blocks)}"
    text = [title, *_lanes(), _casadi("static inline __attribute__((always_inline))", functions)]
    text += [*(_part(block, tables[block.name]) for block in blocks), _enumeration(sizes)]
    text += ["template <class... Blocks> struct List {};", *aliases, *map(_kernel, files)]
    described = [_describe(block, tables[block.name]) for block in blocks]
    return Source("\n".join(text), {"held": list(held), "blocks": described})


def _lanes() -> list[str]:
    # those of the stepper, which has them
    nodes, weights = (", ".join(map(repr, numbers)) for numbers in (NODES, WEIGHTS))
    stages = "".join(
        f"static const double {name}[] __attribute__((unused)) = {{{numbers}}};\n"
        for name, numbers in (("NODES", nodes), ("WEIGHTS", weights))
    )
    return [_kernel("lanes.hpp"), _kernel("functions.hpp"), stages, _kernel("stages.hpp")]


def _casadi(linkage: str, functions: Sequence[ca.Function]) -> str:
    """The C that CasADi writes, unchanged, with lanes in the place of double."""
    generator = ca.CodeGenerator("generated.c")
    for function in functions:
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
        "N_TIME": table["clock"].numel_out(0) if "clock" in table else 1,
        "SAMPLED": int(block.sampled),
    }
    roles = [_role(role, table[role]) for role in ROLES if role in table]
    if "stage" in table:
        sizes |= {"N_AT_STAGE": table["stage"].numel_in("staged"), "N_SEEN_AT_STAGE": table["stage"].numel_out("seen")}
        roles.append(_BY_STAGES.format(block=block.name))
    return f"struct Part_{block.name} {{\n    {_enumeration(sizes)}{_magnitude(block)}{''.join(roles)}}};\n"


def _magnitude(block: Block) -> str:
    """The sum of |value| · scale of all states and outputs: each is within its limit if that is at most 1.

    An output that is a state counts once.
    """
    states = {symbol.element_hash() for symbol in block.x.values()}
    terms = [f"fabs(x[{i}]) * scales[{i}]" for i in range(len(block.x))]
    terms += [
        f"fabs(y[{i}]) * scales[{len(block.x) + i}]"
        for i, output in enumerate(block.y.values())
        if output.element_hash() not in states
    ]
    total = " + ".join(terms or ["V(0.0)"])
    return (
        "    INLINE V magnitude(const V *x, const V *y, const V *scales) {\n"
        f"        (void)x, (void)y, (void)scales;\n        return {total};\n    }}\n"
    )


def _role(role: str, function: ca.Function) -> str:
    names_in, names_out = ROLES[role]
    arguments = ", ".join([*(f"const V *{name}" for name in names_in), *(f"V *{name}" for name in names_out)])
    given = ", ".join(function.name_in())
    results = ", ".join(function.name_out())
    sizes = {
        **{name: function.numel_in(i) for i, name in enumerate(function.name_in())},
        **{name: function.numel_out(i) for i, name in enumerate(function.name_out())},
    }
    # what a compiler knows of the pointers spares CasADi's question whether they are null
    known = "".join(f" {'given' if sizes.get(name) else 'unused'}({name});" for name in (*names_in, *names_out))
    # a large one is called, not copied to where it is called from
    linkage = "static __attribute__((noinline)) void" if role == "stage" else "INLINE void"
    return (
        f"    {linkage} {role}({arguments}) {{\n       {known}\n"
        f"        const V *arg[] = {{{given}}};\n        V *res[] = {{{results}}};\n"
        f"        {function.name()}(arg, res, 0, 0, 0);\n    }}\n"
    )


def _refuse_sparse(function: ca.Function) -> None:
    if not all(function.sparsity_in(i).is_dense() for i in range(function.n_in())) or not all(
        function.sparsity_out(i).is_dense() for i in range(function.n_out())
    ):
        raise ValueError(f"{function.name()}: arguments and results must be dense")


def _kernel(name: str) -> str:
    return (resources.files(_KERNEL) / name).read_text(encoding="utf-8")


def _function_table(functions: Sequence[ca.Function]) -> str:
    rows = []
    lists = []
    for i, f in enumerate(functions):
        for way, sizes in (("in", _sizes(f.n_in(), f.numel_in)), ("out", _sizes(f.n_out(), f.numel_out))):
            lists.append(f"static const int {way}_{i}[] = {{{_list(sizes)}}};")
        rows.append(f"{{{f.name()}, {f.n_in()}, {f.n_out()}, in_{i}, out_{i}}}")
    largest = {
        "MAX_ARGUMENTS": max(max(f.n_in(), f.n_out(), f.sz_arg(), f.sz_res()) for f in functions),
        "MAX_NUMBERS": max(1, *(f.nnz_in() + f.nnz_out() for f in functions)),
        "MAX_WORK": max(1, *(max(f.sz_w(), f.sz_iw()) for f in functions)),
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
