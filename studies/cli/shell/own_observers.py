"""`--observer my.py:block`: a user's own Block from a Python file, which is run for it."""

from __future__ import annotations

import contextlib
import importlib.abc
import sys
import traceback
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType

from ....model.block import Block
from ...files.dask import let_in
from ...files.errors import ScenarioError
from ...files.quote import short, shown
from ...files.reading import cause, read_whole
from .stopping import Stopped

# a larger file is no program of a person
_LARGEST = 10_000_000
_FORM = "an observer of your own is FILE.py:NAME, the name of a Block in that file or of a function that returns one"


def loaded(observers: Sequence[str]) -> list[str | Block] | None:
    """What `--observer` names: registered names as they are, FILE.py:NAME as its Block; None if nothing is named.

    Runs the files, each once. ScenarioError says which cannot be read or run, or has no such Block.
    """
    modules: dict[Path, ModuleType] = {}
    blocks: dict[str, Block] = {}
    for observer in observers:
        file, colon, name = observer.rpartition(":")
        if not colon and not observer.endswith(".py"):
            continue  # a registered name, or none
        if not file.endswith(".py") or not name.isidentifier():
            raise ScenarioError(f"{shown(observer)} names no observer; {_FORM}")
        path = Path(file)
        if path not in modules:
            modules[path] = _run(path)
        blocks[observer] = _block(modules[path], path, name)
    return [blocks.get(observer, observer) for observer in observers] or None


class _Source(importlib.abc.SourceLoader):
    """A file that was read, as the source of a module; Python's own loader would leave a `__pycache__` beside it."""

    def __init__(self, path: Path, content: bytes) -> None:
        self._path, self._content = path, content

    def get_filename(self, fullname: str) -> str:
        """What tracebacks call the file."""
        return str(self._path)

    def get_data(self, path: str) -> bytes:
        """The bytes of the file."""
        return self._content


def _run(path: Path) -> ModuleType:
    """The file as a module. ScenarioError if it cannot be read, or ends with an exception."""
    try:
        loader = _Source(path, read_whole(path, _LARGEST))
    except (OSError, ValueError) as error:
        raise ScenarioError(f"{path}: cannot be read: {cause(error)}") from error
    # no import finds this name, and the file's folder is not searched for what the file imports
    module = ModuleType(f"observers of {path}")
    module.__file__ = str(path)
    # dataclasses look for their module here
    sys.modules[module.__name__] = module
    let_in()  # the file may import whatever is installed
    with _told(path):
        loader.exec_module(module)
    return module


def _block(module: ModuleType, path: Path, name: str) -> Block:
    """The Block that `name` is in the module, or that it returns. ScenarioError if there is none."""
    if not hasattr(module, name):
        raise ScenarioError(f"{path} has nothing called {name}; {_blocks(module)}")
    found = getattr(module, name)
    if callable(found) and not isinstance(found, type):
        with _told(path):
            found = found()
    if not isinstance(found, Block):
        raise ScenarioError(f"{name} in {path} is no Block and no function that returns one; {_blocks(module)}")
    return found


def _blocks(module: ModuleType) -> str:
    names = [name for name, value in vars(module).items() if isinstance(value, Block)]
    return f"its Blocks are {short(', '.join(names))}" if names else "it has no Blocks"


@contextlib.contextmanager
def _told(path: Path) -> Iterator[None]:
    """What a user's code raises, as a ScenarioError with the last line of the file that led there."""
    try:
        yield
    except Stopped:  # a signal is ours; all else is the file's, a KeyboardInterrupt too
        raise
    except BaseException as error:
        lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)]
        if isinstance(error, SyntaxError) and error.filename == str(path):
            lines.append(error.lineno)
        where = f", line {lines[-1]}" if lines else ""
        words = error.msg if isinstance(error, SyntaxError) else str(error)
        raise ScenarioError(f"{path}{where}: {type(error).__name__}: {short(words)}".rstrip(": ")) from error
