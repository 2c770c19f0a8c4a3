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
from .manifest import Manifest, Member, one_line

DOUBLE, FLOAT = "double", "float"

_TEMPLATES = resources.files("hillobs.codegen.targets.templates")
# words that C and C++ keep for themselves, and macros of their libraries: no struct may have them as members
_TAKEN = frozenset((_TEMPLATES / "taken.txt").read_text(encoding="utf-8").split())
# functions that CasADi calls, by their names for doubles
_MATHEMATICS = frozenset((_TEMPLATES / "mathematics.txt").read_text(encoding="utf-8").split())
# digits that tell two numbers apart
_DIGITS = {DOUBLE: 17, FLOAT: 9}
_GROUPS = ("state", "params", "input", "estimate")
_PROGRAM = "main.c"

Words = Mapping[str, str]


def c_files(manifest: Manifest, real: str = DOUBLE) -> dict[str, str]:
    """Name → text of each file. BlockError if a name or a number cannot be expressed in C.

    real: the type of all numbers.
    """
    if f"{manifest.name}.c" == _PROGRAM:
        raise BlockError(f"{manifest.name}: {_PROGRAM} is the program beside the observer; give yours another name")
    name, code = manifest.name, _casadi([*manifest.functions.values()], manifest.prefix, real)
    names = {group: _identifiers(name, getattr(manifest, group)) for group in _GROUPS}
    common = _common(manifest, names, code, real)
    return {
        f"{name}.h": _filled("observer.h", common, _header(manifest, names, real)),
        f"{name}.c": _filled("observer.c", common, _source(manifest, names, code, real)),
        _PROGRAM: _filled("main.c", common, _program(manifest, names, real)),
        "CMakeLists.txt": _filled("CMakeLists.txt", common),
        "README.md": _filled("README.md", common, _page(manifest, names)),
    }


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


def _common(manifest: Manifest, names: Mapping[str, Sequence[str]], code: str, real: str) -> Words:
    """What several files say."""
    functions, prefix = manifest.functions.values(), manifest.prefix
    return {
        **{f"n_{group}": str(max(len(members), 1)) for group, members in names.items()},
        "n_arg": str(max(f.sz_arg() for f in functions)),
        "n_res": str(max(f.sz_res() for f in functions)),
        "n_motion": str(manifest.functions["depart"].numel_out(0)),
        "name": manifest.name,
        "prefix": prefix,
        "PREFIX": prefix.upper(),
        "label": _text(manifest.label),
        "sentence": _text(manifest.sentence),
        "version": manifest.version,
        "graph": f"sha256:{hashlib.sha256(code.encode()).hexdigest()}",
        "real": real,
        "period": f"{manifest.period:g} {manifest.time_unit}".rstrip(),
        "substeps": str(manifest.substeps),
        "columns": ", ".join(manifest.columns),
    }


def _header(manifest: Manifest, names: Mapping[str, Sequence[str]], real: str) -> Words:
    prefix = manifest.prefix
    return {
        **{group: "\n".join(_members(getattr(manifest, group), of, prefix)) for group, of in names.items()},
        "period_literal": _number(manifest.name, "the period", manifest.period, real),
        "period_unit": manifest.time_unit or "the paper's time τ = v_max t",
    }


def _source(manifest: Manifest, names: Mapping[str, Sequence[str]], code: str, real: str) -> Words:
    values = zip(manifest.params, names["params"], manifest.defaults, strict=True)
    literals = ((name, _number(manifest.name, member.name, value, real)) for member, name, value in values)
    return {
        "code": code,
        "defaults": "\n".join(f"    {literal}, /* {name} */" for name, literal in literals),
        "advance": _filled("advance.c", _common(manifest, names, code, real)) if manifest.substeps else "",
        "mathematics": "".join(_of_floats(code)) if real == FLOAT else "",
    }


def _program(manifest: Manifest, names: Mapping[str, Sequence[str]], real: str) -> Words:
    read = f"    input->{{}} = ({manifest.prefix}_real)numbers[{{}}];"
    printed = f'        printf("%.{_DIGITS[real]}g,", (double)estimate.{{}});'
    return {
        "column_strings": ", ".join(f'"{column}"' for column in manifest.columns),
        "header": ",".join(names["estimate"]),
        "read": "\n".join(read.format(name, i) for i, name in enumerate(names["input"])),
        "print": "\n".join(map(printed.format, names["estimate"])),
    }


def _page(manifest: Manifest, names: Mapping[str, Sequence[str]]) -> Words:
    return {
        "units_sentence": manifest.units,
        "input_members": "`, `".join(names["input"]),
        "steps_sentence": _steps(manifest.substeps),
    }


def _filled(template: str, *words: Words) -> str:
    return Template((_TEMPLATES / template).read_text(encoding="utf-8")).substitute(*words[:1], **dict(*words[1:]))


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
    if not members:
        yield f"    {prefix}_real nothing; /* no struct is empty in C */"
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
    return re.sub(r"\*(?=/)|/(?=\*)", lambda mark: f"{mark[0]} ", one_line(words))


def _steps(substeps: int) -> str:
    if not substeps:
        return "It moves at samples only."
    many = f"{substeps} step{'s' * (substeps > 1)}"
    return f"It makes {many} from sample to sample, for the numbers exported: faster gains may ask for another export."
