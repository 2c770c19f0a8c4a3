"""A registry of few observers: where curves or observers are a test's own, each one more takes seconds to compile."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from hillobs.observers import OBSERVERS
from hillobs.studies.scenarios.loops import all_paths, paper_loop


@contextmanager
def few_observers(*names: str) -> Iterator[pytest.MonkeyPatch]:
    """Let the registry hold those that are named and no others, with an empty memory of loops; it may be patched."""
    whole = dict(OBSERVERS)
    try:
        with pytest.MonkeyPatch.context() as patched:
            for name in set(OBSERVERS) - set(names):
                patched.delitem(OBSERVERS, name)
            _forget()
            yield patched
    finally:
        # what was left out has come back at the end; libraries and sentences have the order of the registry
        OBSERVERS.clear()
        OBSERVERS.update(whole)
        _forget()


def _forget() -> None:
    for memory in (paper_loop, all_paths):
        memory.cache_clear()
