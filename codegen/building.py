"""Who is told that a library is being compiled: that takes a while, and is done once."""

from __future__ import annotations

import contextlib
import contextvars
from collections.abc import Callable, Iterator, Mapping
from typing import Any

Listener = Callable[[str], None]
# so many parts of a library are named
_FEW = 3

_listener: contextvars.ContextVar[Listener] = contextvars.ContextVar("listener", default=lambda sentence: None)


@contextlib.contextmanager
def told_of_builds(listener: Listener) -> Iterator[None]:
    """`listener` is given a sentence when a compilation begins, and an empty one when it has ended."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)


@contextlib.contextmanager
def building(description: Mapping[str, Any], compiler: str) -> Iterator[None]:
    """While the library described is compiled."""
    listener = _listener.get()
    listener(f"compiling {_parts(description)} with {compiler}: once, then the library is kept")
    try:
        yield
    finally:
        listener("")


def _parts(description: Mapping[str, Any]) -> str:
    names = [entry["name"] for key in ("blocks", "functions") for entry in description.get(key, ())]
    more = f" and {len(names) - _FEW} more" if len(names) > _FEW else ""
    return ", ".join(names[:_FEW]) + more
