"""What a user may have to be told: a sentence each, no traceback."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from pathlib import Path

from ...model.errors import Error


class ScenarioError(Error, ValueError):
    """What is wrong with a scenario, a path or a value, in one sentence."""


class RecordingError(Error, ValueError):
    """A recording or a mapping that cannot be read; the sentence says what is wrong, and where."""


class TomlError(ScenarioError):
    """A file that cannot be read as TOML; the sentence names it and says why."""


class ResultError(Error, ValueError):
    """A result that cannot be written or read; the sentence says which and why."""


class ClusterError(Error, RuntimeError):
    """A cluster cannot be used or was lost; the message says what to do."""


@contextlib.contextmanager
def in_file(path: Path | str) -> Iterator[None]:
    """What is wrong with the content of a file, or a part of one, as a ScenarioError that names it."""
    try:
        yield
    except ScenarioError as error:
        raise ScenarioError(f"{path}: {error}") from error
