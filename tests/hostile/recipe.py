"""A case as lines for a shell: its files, then its command."""

from __future__ import annotations

import base64
import gzip
import json
import os
import shlex
from collections.abc import Iterator, Mapping
from typing import Any

from hostile.case import Case

_ULIMIT = {"RLIMIT_NOFILE": "-n", "RLIMIT_FSIZE": "-f", "RLIMIT_NPROC": "-u", "RLIMIT_AS": "-v"}
_STREAMS = {"full": ">/dev/full", "closed": ">&-", "broken": "| true"}
_SOURCES = {"closed": "<&-", "unreadable": "</proc/self/mem"}
_NUMBERS = {"stdout": "", "stderr": "2"}


def recipe(case: Case) -> Iterator[str]:
    """The lines; what a shell cannot do is a remark."""
    yield "mkdir -p BOX/{desk,home,tmp,other} && cd BOX/desk && echo 'dear reader' > ../other/letter.txt"
    for name, entry in case.files.items():
        yield from _file(name, entry)
    for name, at in case.signals:
        yield f"# {name} comes at call {at}"
    for name, number in case.limits.items():
        yield f"# ulimit {_ULIMIT[name]}, as for {name} = {number:,}"
    yield " ".join([*_given(case), *_environment(case), *_command(case), *_redirections(case)])


def _file(name: str, entry: Mapping[str, Any]) -> Iterator[str]:
    quoted = _quoted(name)
    if folder := os.path.dirname(name):
        yield f"mkdir -p {_quoted(folder)}"
    match entry:
        case {"link": target}:
            yield f"ln -s -- {_quoted(target)} {quoted}"
        case {"hard": target}:
            here, last = os.path.split(name)
            yield f"(cd ./{_quoted(here)} && ln -- {_quoted(target)} {_quoted(last)})"
        case {"folder": _}:
            yield f"mkdir -p -- {quoted}"
        case {"pipe": _}:
            yield f"mkfifo -- {quoted}"
        case {"result": result, **damage}:
            yield f"# {name}: the result of {result} in hostile/results.py, changed by {json.dumps(damage)}"
        case {"forged": changes}:
            yield f"# {name}: the state in hostile/results.py, forged with {json.dumps(changes)}"
        case {"shipped": shipped}:
            yield f"# {name}: {shipped} in studies/laboratory/recordings"
        case _:
            yield f"{_printed(entry)}> ./{quoted}"
    if "mode" in entry:
        yield f"chmod {entry['mode']:o} ./{quoted}"


def _printed(entry: Mapping[str, Any]) -> str:
    """A command that prints the content of a file."""
    raw = entry.get("text", entry.get("gzip", "")).encode("utf-8", "surrogateescape")
    pressed = base64.b64encode(gzip.compress(raw, mtime=0)).decode()
    return f"printf %s {pressed} | base64 -d {'' if 'gzip' in entry else '| gzip -d '}"


def _given(case: Case) -> Iterator[str]:
    if case.input:
        yield f"{_printed(case.input)}|"


def _environment(case: Case) -> Iterator[str]:
    if case.environment:
        yield "env"
        yield from (f"-u {name}" for name, value in case.environment.items() if value is None)
        yield from (f"{name}={_quoted(value)}" for name, value in case.environment.items() if value is not None)


def _command(case: Case) -> Iterator[str]:
    yield from ("python", "-c", _quoted(case.python)) if case.python else ("hillobs", *map(_quoted, case.words))


def _redirections(case: Case) -> Iterator[str]:
    for name, where in case.streams.items():
        yield _SOURCES[where] if name == "stdin" else f"{_NUMBERS[name]}{_STREAMS[where]}"


def _quoted(text: str) -> str:
    r"""A word for bash; with \x… where it holds what cannot be printed."""
    if all(c.isprintable() or c == "\n" for c in text):
        return shlex.quote(text)
    raw = text.encode("utf-8", "surrogateescape")
    return "$'" + "".join(chr(b) if 32 <= b < 127 and b not in b"'\\" else f"\\x{b:02x}" for b in raw) + "'"
