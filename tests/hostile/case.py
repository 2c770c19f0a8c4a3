"""A case: a command, the files around it, and what else it meets; as layers, so that it shrinks by leaving some out."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

# one drawn case in so many has a process of its own, whatever else it meets
FRESH = 15
# some of the fields of a Case; of two layers the later one is added to the earlier one
Layer = Mapping[str, Any]


@dataclass(frozen=True)
class Case:
    """All that determines what happens; everything can be written as JSON.

    words: `hillobs WORDS`. python: a program instead, which uses the façade.
    files: path from the working folder → what is there before, see `sandbox.lay`.
    input: what is on standard input, as of a file; nothing if it is left out.
    names: name in words and files → the one that takes its place.
    environment: variable → value, or None to unset it.
    limits: resource → number; of RLIMIT_AS what is left beyond the memory that a loaded process has.
    streams: stdout, stderr → full, closed, broken (its reader is gone); stdin → closed, unreadable.
    signals: [name, n]: it comes at the n-th call that Python reports to audit hooks.
    fresh: in a process of its own, from its first import on. writes: where a program may write.
    code: the exit code, where only one is right.
    """

    words: tuple[str, ...] = ()
    python: str = ""
    files: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    input: Mapping[str, Any] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)
    environment: Mapping[str, str | None] = field(default_factory=dict)
    limits: Mapping[str, int] = field(default_factory=dict)
    streams: Mapping[str, str] = field(default_factory=dict)
    signals: tuple[tuple[str, int], ...] = ()
    fresh: bool = False
    writes: tuple[str, ...] = ()
    code: int | None = None


def merged(layers: Iterable[Layer]) -> Case:
    """The case of some layers: lists are joined, of two entries of one name the later counts."""
    whole: dict[str, Any] = {}
    for layer in layers:
        for key, value in layer.items():
            match value:
                case Mapping():
                    whole[key] = {**whole.get(key, {}), **value}
                case list() | tuple():
                    whole[key] = [*whole.get(key, ()), *value]
                case _:
                    whole[key] = value
    names = whole.get("names", {})
    words = tuple(_renamed(word, names) for word in whole.get("words", ()))
    files = {names.get(path, path): entry for path, entry in whole.get("files", {}).items()}
    signals = tuple((name, at) for name, at in whole.get("signals", ()))
    lists = {"words": words, "signals": signals, "writes": tuple(whole.get("writes", ())), "names": {}}
    return Case(**{**whole, **lists, "files": files})


def _renamed(word: str, names: Mapping[str, str]) -> str:
    return names.get(word, word)


def as_json(case: Case) -> str:
    """The case without what is empty, one field a line."""
    fields = {key: value for key, value in asdict(case).items() if value not in (None, "", (), {}, False)}
    return "{\n" + ",\n".join(f" {json.dumps(key)}: {json.dumps(value)}" for key, value in fields.items()) + "\n}\n"


def read_case(path: Path) -> tuple[Case, str]:
    """A case of the corpus, and the sentence that says what it has found."""
    content = json.loads(path.read_text())
    found = content.pop("found", "")
    return merged([content]), found


def without(layers: Sequence[Layer], left_out: int) -> list[Layer]:
    """The layers but one."""
    return [layer for i, layer in enumerate(layers) if i != left_out]
