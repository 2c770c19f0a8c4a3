"""The parts of an unfinished sweep: a folder beside its result, one sealed file a part, one process at a time."""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import socket
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import TracebackType

import numpy as np

from ...codegen.system.locks import take
from ..files.errors import ResultError
from ..files.netcdf import sealed, unsealed
from ..files.reading import cause, read_whole
from ..files.writing import write_whole
from .row import Rows

# bytes; a part is some thousand numbers
_LARGEST_PART = 1_000_000_000
_LARGEST_PLAN = 1_000_000_000
# of a process and its machine
_LONGEST_NAME = 1_000
# one name per part, so that none is found twice
_PART = re.compile(r"(\d{8}|[1-9]\d{8,})\.part", re.ASCII)


class Parts:
    """The folder `RESULT.parts`, locked while it is used as a context; parts are found again by their content."""

    def __init__(self, result: Path, identity: str, description: Mapping[str, object], row: np.dtype[np.void]) -> None:
        """Parts of rows with the layout `row`, of the sweep that `identity` names and `description` tells by words."""
        self.folder = result.with_name(f"{result.name}.parts")
        self._result, self._identity, self._description, self._row = result, identity, description, row
        self.damaged = 0  # files that were no part and are computed again

    def __enter__(self) -> Parts:
        """Lock the folder. ResultError if another process has it, or it holds parts of another sweep."""
        try:
            self._lock = self._locked()
        except ResultError:
            raise
        except (OSError, ValueError) as error:
            raise ResultError(f"{self.folder} cannot be written to: {cause(error)}") from error
        try:
            self._compare()
            self._remove_halves()
        except BaseException:
            os.close(self._lock)
            raise
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Unlock; the system does so too if we die."""
        os.close(self._lock)

    def read(self, part: int) -> Rows | None:
        """The rows of a part, or None if it is not there whole."""
        path = self._path(part)
        try:
            content = unsealed(read_whole(path, _LARGEST_PART))
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            raise ResultError(f"{path} cannot be read: {cause(error)}") from error
        head, _, body = (content or b"").partition(b"\n")
        if head != self._head(part):
            self.damaged += 1
            return None
        return np.frombuffer(body, self._row)

    def write(self, part: int, rows: Rows) -> None:
        """Keep the rows of a part. ResultError if that fails."""
        write_whole(self._path(part), sealed(self._head(part) + b"\n" + rows.tobytes()))

    def remove(self) -> None:
        """Remove the folder, once the result is there."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def remove_left(self) -> None:
        """Remove the folder of a process that was killed between its result and the end."""
        with contextlib.suppress(ResultError, OSError):
            if self.folder.is_dir():
                with self:
                    self.remove()

    def _path(self, part: int) -> Path:
        return self.folder / f"{part:08d}.part"

    def _head(self, part: int) -> bytes:
        return f"hillobs sweep {self._identity} part {part}".encode()

    def _locked(self) -> int:
        """A descriptor of the lock in the folder, which is ours while it is open."""
        path = self.folder / "lock"
        while True:
            self.folder.mkdir(exist_ok=True)
            # a process that has just finished removes the folder, and the lock with it
            with contextlib.suppress(FileNotFoundError):
                try:
                    lock = take(path)
                except BlockingIOError as error:
                    raise ResultError(f"{self._result} is being computed by {_owner(path)}") from error
                os.ftruncate(lock, 0)
                os.pwrite(lock, f"process {os.getpid()} on {socket.gethostname()}".encode(), 0)
                return lock

    def _compare(self) -> None:
        """Another sweep's parts are not mixed with ours."""
        path, ours = self.folder / "plan.json", json.dumps(self._description, sort_keys=True).encode()
        try:
            theirs = unsealed(read_whole(path, _LARGEST_PLAN))
        except FileNotFoundError:
            theirs = None
        except (OSError, ValueError) as error:
            raise ResultError(f"{path} cannot be read: {cause(error)}") from error
        if theirs is None:  # none, or damaged: each part says itself whose it is
            write_whole(path, sealed(ours))
        elif theirs != ours:
            other = json.loads(theirs)
            changed = [key for key, value in json.loads(ours).items() if other.get(key) != value]
            raise ResultError(
                f"{self.folder} holds an unfinished sweep with other {' and '.join(changed)}; "
                "finish that one, name another --out, or remove the folder"
            )

    def _remove_halves(self) -> None:
        """Remove what a killed process left half written; nobody else writes here while we have the lock."""
        for name in self._names():
            if name.startswith("."):
                with contextlib.suppress(OSError):
                    os.unlink(self.folder / name)

    def __iter__(self) -> Iterator[int]:
        """The parts that have a file, whole or not."""
        for name in sorted(self._names()):
            if part := _PART.fullmatch(name):
                yield int(part[1])

    def _names(self) -> list[str]:
        try:
            return os.listdir(self.folder)
        except OSError as error:
            raise ResultError(f"{self.folder} cannot be read: {cause(error)}") from error


def _owner(lock: Path) -> str:
    """Who says in a lock file that it is theirs."""
    with contextlib.suppress(OSError, ValueError):
        if name := read_whole(lock, _LONGEST_NAME).decode(errors="replace").strip():
            return name
    return "another process"
