"""What the C of a loop follows from, as one hash: a start that finds that C in the cache exports nothing."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict

import casadi as ca

from ..model.block import EXPRESSIONS, STEP, Block
from .cache import entry_key, kept
from .export import Source
from .loop import Loop, export_loop
from .own_code import own_code

# what exports: this package with its kernel, and what Blocks are
_PACKAGES = ("codegen", "model")


def exported(loop: Loop) -> Source:
    """What `export_loop` makes of the loop, from the cache if it is there."""
    if not (code := own_code(*_PACKAGES)):
        return export_loop(loop)
    return Source(**json.loads(kept(fingerprint(loop, code), lambda: json.dumps(asdict(export_loop(loop))).encode())))


def fingerprint(loop: Loop, code: str) -> str:
    """The hash of all expressions and names of a loop, and of the `code` that exports them."""
    return entry_key(
        {
            "code": code,
            "casadi": [ca.CasadiMeta.version(), ca.GlobalOptions.getSimplificationOnTheFly()],
            "blocks": [_told(block) for block in loop.exported],
            "roles": [len(loop.observers), loop.bank.near is not None],
            "ports": [loop.bank.measured, loop.noise, loop.pulses, loop.flags],
        }
    )


def _told(block: Block) -> list[object]:
    """Names of a Block, and its expressions operation by operation; what its numbers usually are is not in its C."""
    given = {group: getattr(block, group) for group in ("x", "u", "p")}
    follow = {group: getattr(block, group) for group in ("x0", "limits", *EXPRESSIONS)}
    inputs = [symbol for group in given.values() for symbol in group.values()]
    results = [expression for group in follow.values() for expression in group.values()]
    f = ca.Function("f", [_column([*inputs, STEP])], [_column(results)])
    names = {group: list(entries) for group, entries in {**given, **follow}.items()}
    return [block.name, names, sorted(block.held), f.serialize()]


def _column(entries: Sequence[ca.SX]) -> ca.SX:
    return ca.vertcat(*entries) if entries else ca.SX(0, 1)
