"""An observer as C99: a header and a source, a program that reads CSV, a page, and a file for CMake."""

from __future__ import annotations

import hashlib
import math
import re
import struct
from collections.abc import Iterator, Mapping, Sequence
from importlib import resources
from string import Template
from typing import Any

import casadi as ca

from ...model.block import BlockError
from .manifest import Manifest, Member

_TEMPLATES = "hillobs.codegen.targets.templates"
# words that C and C++ keep for themselves, and macros of their libraries: no struct may have them as members
_TAKEN = frozenset((resources.files(_TEMPLATES) / "taken.txt").read_text(encoding="utf-8").split())
DOUBLE, FLOAT = "double", "float"
# that tell two numbers apart
_DIGITS = {DOUBLE: 17, FLOAT: 9}
# functions that CasADi calls, by their names for doubles
_MATHEMATICS = frozenset(
    {
        "acos",
        "acosh",
        "asin",
        "asinh",
        "atan",
        "atan2",
        "atanh",
        "ceil",
        "copysign",
        "cos",
        "cosh",
        "erf",
        "exp",
        "expm1",
    }
    | {"fabs", "floor", "fmax", "fmin", "fmod", "hypot", "log", "log1p", "pow", "sin", "sinh", "sqrt", "tan", "tanh"}
)


def file_names(name: str) -> tuple[str, ...]:
    """The files of an observer of this name."""
    return f"{name}.h", f"{name}.c", "main.c", "CMakeLists.txt", "README.md"


def c_files(manifest: Manifest, real: str = DOUBLE) -> dict[str, str]:
    """Name → text of each file. BlockError if a name or a number cannot be expressed in C.

    real: the type of all numbers.
    """
    prefix = c_prefix(manifest.name)
    code = _casadi([*manifest.functions.values()], prefix, real)
    groups = {
        group: _identifiers(manifest.name, getattr(manifest, group))
        for group in ("state", "params", "input", "estimate")
    }
    sizes = {f"n_{group}": str(len(names)) for group, names in groups.items()}
    sizes |= {
        "n_arg": str(max(f.sz_arg() for f in manifest.functions.values())),
        "n_motion": str(manifest.functions["depart"].numel_out(0)),
        "n_res": str(max(f.sz_res() for f in manifest.functions.values())),
    }
    common = {
        **sizes,
        "name": manifest.name,
        "prefix": prefix,
        "PREFIX": prefix.upper(),
        "label": _text(manifest.label),
        "title": f"{_text(manifest.label)}: {_text(manifest.sentence)}",
        "sentence": _text(manifest.sentence),
        "units_sentence": manifest.units,
        "version": manifest.version,
        "graph": f"sha256:{hashlib.sha256(code.encode()).hexdigest()}",
        "real": real,
        "period": f"{manifest.period:g} {manifest.time_unit}".rstrip(),
        "substeps": str(manifest.substeps),
        "columns": ", ".join(manifest.columns),
    }
    header = {group: "\n".join(_members(getattr(manifest, group), names, prefix)) for group, names in groups.items()}
    defaults = [
        f"    {_number(manifest.name, member.name, value, real)}, /* {name} */"
        for member, name, value in zip(manifest.params, groups["params"], manifest.defaults, strict=True)
    ]
    period = {
        "period_literal": _number(manifest.name, "the period", manifest.period, real),
        "period_sentence": _time(manifest.time_unit),
    }
    source = {
        "code": code,
        "defaults": "\n".join(defaults),
        "advance": _filled("advance.c", common) if manifest.substeps else "",
        "mathematics": "".join(_of_floats(code)) if real == FLOAT else "",
    }
    program = {
        "column_strings": ", ".join(f'"{column}"' for column in manifest.columns),
        "header": ",".join(groups["estimate"]),
        "read": "\n".join(
            f"    input->{name} = ({prefix}_real)numbers[{i}];" for i, name in enumerate(groups["input"])
        ),
        "print": "\n".join(
            f'        printf("%.{_DIGITS[real]}g,", (double)estimate.{name});' for name in groups["estimate"]
        ),
    }
    page = {"input_members": "`, `".join(groups["input"]), "steps_sentence": _steps(manifest.substeps)}
    page["Sentence"] = common["sentence"][:1].upper() + common["sentence"][1:]
    texts = (
        _filled("observer.h", {**common, **header, **period}),
        _filled("observer.c", {**common, **source}),
        _filled("main.c", {**common, **program}),
        _filled("CMakeLists.txt", common),
        _filled("README.md", {**common, **page}),
    )
    return dict(zip(file_names(manifest.name), texts, strict=True))


def c_prefix(name: str) -> str:
    """What all symbols of an observer of this name begin with."""
    return f"hillobs_{name}"


def _casadi(functions: Sequence[ca.Function], prefix: str, real: str) -> str:
    """What CasADi writes of the functions."""
    # the name is what its helpers' names begin with
    options: dict[str, Any] = {"casadi_real": real, "casadi_int": "int", "include_math": False, "with_header": False}
    generator = ca.CodeGenerator(f"{prefix}_casadi.c", options)
    for function in functions:
        generator.add(function)
    return str(generator.dump()).strip()


def _of_floats(code: str) -> Iterator[str]:
    """Lines that make CasADi call the functions of floats."""
    yield "\n/* CasADi calls all functions by their names for doubles */\n"
    for name in sorted({*re.findall(r"\b([a-z0-9]+)\(", code)} & _MATHEMATICS):
        yield f"#define {name} {name}f\n"


def _filled(template: str, words: Mapping[str, str]) -> str:
    return Template((resources.files(_TEMPLATES) / template).read_text(encoding="utf-8")).substitute(words)


def _identifiers(observer: str, members: Sequence[Member]) -> list[str]:
    """The names of a struct's members, such as muscle1_L_slack. BlockError for one that C has no letters for."""
    names: dict[str, str] = {}
    for member in members:
        name = member.name.replace(".", "_")
        if not re.fullmatch("[A-Za-z_][A-Za-z0-9_]*", name):
            raise BlockError(f"{observer}: {member.name!r} is no name in C; use letters without accents, digits, _")
        name = f"{name}_" if name in _TAKEN else name
        if name in names:
            raise BlockError(f"{observer}: {names[name]!r} and {member.name!r} would both be called {name} in C")
        names[name] = member.name
    return list(names)


def _members(members: Sequence[Member], names: Sequence[str], prefix: str) -> Iterator[str]:
    for member, name in zip(members, names, strict=True):
        about = ", ".join(words for words in (member.unit, member.bounds) if words)
        yield f"    {prefix}_real {name}; /* {_text(member.sentence)} [{_text(about)}] */"


def _number(observer: str, name: str, value: float, real: str) -> str:
    """A literal. BlockError for a number that a float cannot hold."""
    if real == DOUBLE:
        return repr(float(value))
    try:
        kept = struct.unpack("f", struct.pack("f", value))[0]
    except OverflowError:
        kept = math.inf
    if math.isinf(kept) or (value and not kept):
        raise BlockError(f"{observer}: {name} = {value:g} is no number of type float")
    return f"{float(value)!r}f"


def _text(words: str) -> str:
    """Words of others on one line of a comment, which they do not end."""
    line = "".join(c if c.isprintable() else " " for c in words)
    return re.sub(r"\*(?=/)|/(?=\*)", lambda mark: f"{mark[0]} ", line)


def _time(unit: str) -> str:
    return f"from sample to sample, in {unit}" if unit else "from sample to sample, in the paper's time τ = v_max t"


def _steps(substeps: int) -> str:
    if not substeps:
        return "It moves at samples only."
    many = f"{substeps} step{'s' * (substeps > 1)}"
    return f"It makes {many} from sample to sample, for the numbers exported: faster gains may ask for another export."
