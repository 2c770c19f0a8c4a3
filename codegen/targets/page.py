"""A closed loop as a page: one HTML file with the compiled equations in it, which runs in any browser."""

from __future__ import annotations

import base64
import dataclasses
import gzip
import html
import json
from collections.abc import Iterator, Mapping
from importlib import resources
from string import Template

import casadi as ca

from ...model.block import Block
from ..constants import hoisted
from ..export import ROLES
from ..loop import Loop
from ..stepper import NODES, STAGES, WEIGHTS
from .javascript import javascript
from .study import Study
from .webassembly import Call, webassembly

_FILES = resources.files("hillobs.codegen.targets.templates.page")
# in the order of use; those that need no document come first
_COMPUTING = ("noise.js", "places.js", "passes.js", "runner.js", "settings.js")
_SHOWING = ("elements.js", "kernel.js", "choices.js", "charts.js", "table.js", "controls.js", "view.js")
# no guard is counted on a page
_UNUSED = ("watch",)


def page(study: Study) -> str:
    """The HTML file: in WebAssembly where its compiler is installed, else in JavaScript.

    BlockError for what cannot be expressed in either.
    """
    blocks = _blocks(study)
    tables = {block.name: hoisted(block.name, study.loop.functions(block)) for block in blocks}
    calls = [
        *_calls(tables),
        Call("measures", study.formulas, ("sums", "h", "steps", "window"), ("values",)),
        Call("sides", study.sides, ("numbers",), ("both",)),
    ]
    # written in any case: what it cannot express, the other one cannot either
    script = _in_javascript(calls)
    module = webassembly(calls)
    kernel = module or script.encode()
    constants = {name: table["constants"].numel_out("c") for name, table in tables.items()}
    words = {
        "title": html.escape(study.name),
        "sentence": html.escape(study.sentence),
        "version": html.escape(study.version),
        "language": "webassembly" if module else "javascript",
        "kernel": _packed(kernel),
        "study": _packed(json.dumps(_described(study, blocks, constants), separators=(",", ":")).encode()),
        "style": _text("page.css") + _text("uPlot/uPlot.min.css"),
        "licence": _text("uPlot/LICENSE"),
        "uplot": _text("uPlot/uPlot.iife.min.js"),
        "computing": "\n".join(map(_text, _COMPUTING)),
        "showing": "\n".join(map(_text, _SHOWING)),
    }
    return Template(_text("page.html")).substitute(words)


def _blocks(study: Study) -> list[Block]:
    """Those that run: of the observers the ones asked for."""
    loop = study.loop
    return [block for block in loop.exported if block not in loop.observers or block.name in study.observers]


def _calls(tables: Mapping[str, Mapping[str, ca.Function]]) -> Iterator[Call]:
    for name, table in tables.items():
        for role, function in table.items():
            if role not in _UNUSED:
                yield Call(f"{name}_{role}", function, *ROLES[role])


def _in_javascript(calls: list[Call]) -> str:
    functions = (javascript(call.function, call.name, call.arguments, call.results) for call in calls)
    return "return {" + ",\n".join(functions) + "}"


def _described(study: Study, blocks: list[Block], constants: Mapping[str, int]) -> Mapping[str, object]:
    """What the scripts of the page know of the study."""
    loop, grid = study.loop, study.grid
    return {
        "name": study.name,
        "seed": study.seed,
        "grid": dataclasses.asdict(grid),
        "observers": study.observers,
        "quantities": [dataclasses.asdict(quantity) for quantity in study.quantities],
        "first": study.first,
        "measures": study.measures,
        "numbers": [dataclasses.asdict(number) for number in study.numbers],
        "rules": study.rules,
        "ruled": study.ruled,
        "paths": study.paths,
        "shared": study.shared,
        "given": study.given,
        "roles": _roles(loop),
        "stages": STAGES,
        "nodes": NODES,
        "weights": WEIGHTS,
        "noise": len(loop.noise),
        "held": len(loop.held),
        "seen": len(loop.seen),
        "blocks": {block.name: _part(block, constants[block.name]) for block in blocks},
    }


def _roles(loop: Loop) -> Mapping[str, str | None]:
    bank = loop.bank
    named = {"truth": loop.truth, "sensors": loop.sensors, "score": loop.score, "front": bank.front, "near": bank.near}
    return {role: block.name if block else None for role, block in named.items()}


def _part(block: Block, constants: int) -> Mapping[str, object]:
    """The names of a Block's arrays in order."""
    groups = {group: list(getattr(block, group)) for group in ("x", "p", "y", "domain")}
    return {**groups, "constants": constants, "sampled": block.sampled}


def _packed(content: bytes) -> str:
    """As letters; the same for the same content."""
    return base64.b64encode(gzip.compress(content, mtime=0)).decode()


def _text(name: str) -> str:
    return (_FILES / name).read_text(encoding="utf-8")
