"""Functions of CasADi as a module of WebAssembly, by the compiler of the extra `compiler`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import resources
from string import Template

import casadi as ca

from ..toolchain import WEB, build_c, zig

_TEMPLATE = resources.files("hillobs.codegen.targets.templates.page") / "module.c"


@dataclass(frozen=True, eq=False)  # functions have no usable ==
class Call:
    """A function of the page: its name there, and the names of its arguments and results in order."""

    name: str
    function: ca.Function
    arguments: tuple[str, ...]
    results: tuple[str, ...]


def webassembly(calls: Sequence[Call]) -> bytes | None:
    """A module with memory, and each function by its name: given where arguments and results begin, in doubles.

    None where the compiler is not installed; BuildError if it fails.
    """
    if zig() is None:
        return None
    generator = ca.CodeGenerator("page.c", {"casadi_int": "int", "include_math": False, "with_header": False})
    for call in calls:
        generator.add(call.function)
    source = Template(_TEMPLATE.read_text(encoding="utf-8")).substitute(
        code=str(generator.dump()).strip(), functions="\n".join(map(_exported, calls))
    )
    return build_c({"page.c": source}, "a page", WEB).read_bytes()


def _exported(call: Call) -> str:
    """The function as the page calls it. What the compiler knows of the pointers spares CasADi's null checks."""
    function, names = call.function, (*call.arguments, *call.results)
    taken = [*function.name_in(), *function.name_out()]
    unused = "".join(f" (void){name};" for name in names if name not in taken)
    arg, res = (", ".join(f"AT({name})" for name in some) for some in (function.name_in(), function.name_out()))
    known = "".join(f" GIVEN({name});" for name in taken)
    return (
        f'EXPORTED("{call.name}") void page_{call.name}({", ".join(f"int {name}" for name in names)}) {{\n'
        f"   {unused}{known}\n    const double *arg[] = {{{arg}}};\n    double *res[] = {{{res}}};\n"
        f"    {function.name()}(arg, res, 0, 0, 0);\n}}"
    )
