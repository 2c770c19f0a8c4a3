"""The parts of an unfinished sweep: a folder beside its result, one sealed file a part, one process at a time."""

from __future__ import annotations

import contextlib
import json
import os
import re
import socket
from collections.abc import Iterator, Mapping
from pathlib import Path
from types import TracebackType

import numpy as np

from ...codegen.system.locks import take
from ...codegen.system.trust import DistrustError, open_folder, read_trusted
from ..files.datasets.netcdf import sealed, unsealed
from ..files.errors import ResultError
from ..files.reading import cause
from ..files.writing import opened, temporary_file, temporary_pattern, temporary_prefix
from .row import Rows

# bytes; a part is some thousand numbers
_LARGEST_PART = 1_000_000_000
_LARGEST_PLAN = 1_000_000_000
# of a process and its machine
_LONGEST_NAME = 1_000
_PLAN, _LOCK = "plan.json", "lock"
# what a part begins with
_HEAD = b"hillobs sweep "
# what a lock says of its holder
_HOLDER = re.compile(rb"process [^\x00-\x1f]*")
# one name per part, so that none is found twice
_PART = re.compile(r"(\d{8}|[1-9]\d{8,})\.part", re.ASCII)
# nobody else may read or write them
_RIGHTS = 0o600
_WAY_OUT = "; move it away, or name another --out"


class Parts:
    """The folder `RESULT.parts`, locked while it is used as a context; parts are found again by their content.

    The folder is ours if it belongs to the user, is no link, can be written by nobody else, holds no name but those we
    give, and its plan or one of its parts bears our seal, or a start was killed before there was either. It is used by
    descriptor: nothing is swapped between check and use. All else is refused, and nothing in it touched.
    """

    def __init__(self, result: Path, identity: str, description: Mapping[str, object], row: np.dtype[np.void]) -> None:
        """Parts of rows with the layout `row`, of the sweep that `identity` names and `description` tells by words."""
        self.folder = result.with_name(f"{result.name}.parts")
        self._result, self._identity, self._description, self._row = result, identity, description, row
        begins = [re.escape(temporary_prefix(name)) for name in (_PLAN, result.name)]
        self._temporary = temporary_pattern(*begins, rf"\.{_PART.pattern}-")
        self.damaged = 0  # files that were no part and are computed again

    def __enter__(self) -> Parts:
        """Lock the folder. ResultError if another process has it, it is not ours, or it holds another sweep."""
        with contextlib.ExitStack() as held:
            try:
                self._open(held)
            except DistrustError as error:
                raise ResultError(f"{self.folder} cannot be written to: it {error}{_WAY_OUT}") from error
            except (OSError, ValueError) as error:
                if isinstance(error, ResultError):
                    raise
                raise ResultError(f"{self.folder} cannot be written to: {cause(error)}") from error
            self._compare()
            self._remove(self._temporary)  # what a killed process left half written; nobody else writes here now
            self._held = held.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Unlock; the system does so too if we die."""
        self._held.close()

    def read(self, part: int) -> Rows | None:
        """The rows of a part, or None if it is not there whole."""
        content = self._read(_name(part), _LARGEST_PART)
        if content is None:
            return None
        head, _, body = (unsealed(content) or b"").partition(b"\n")
        if head != self._head(part):
            self.damaged += 1
            return None
        return np.frombuffer(body, self._row)

    def write(self, part: int, rows: Rows) -> None:
        """Keep the rows of a part. ResultError if that fails."""
        self._write(_name(part), sealed(self._head(part) + b"\n" + rows.tobytes()))

    def finish(self, content: bytes) -> None:
        """Give the result its name, which nothing may have, and remove the folder. ResultError if that fails."""
        name = self._result.name
        try:
            # written here, so that a kill leaves nothing beside the result; the umask says who may read it
            with temporary_file(self._handle, name, [content]) as (temporary, _):
                if _is_there(name, self._parent):
                    raise ResultError(f"{self._result} has come to be under way{_WAY_OUT}")
                os.replace(temporary, name, src_dir_fd=self._handle, dst_dir_fd=self._parent)
                os.fsync(self._parent)
        except OSError as error:
            raise ResultError(f"{self._result} cannot be written: {cause(error)}") from error
        self.remove()

    def remove(self) -> None:
        """Remove our files, and the folder if nothing else is in it."""
        for names in (_PART, self._temporary, re.compile(re.escape(_PLAN)), re.compile(_LOCK)):
            self._remove(names)
        with contextlib.suppress(OSError):
            os.rmdir(self.folder.name, dir_fd=self._parent)

    def remove_left(self) -> None:
        """Remove the folder of a process that was killed between its result and the end."""
        with contextlib.suppress(ResultError, OSError):
            if os.path.lexists(self.folder):
                with self:
                    self.remove()

    def _head(self, part: int) -> bytes:
        return _HEAD + f"{self._identity} part {part}".encode()

    def _open(self, held: contextlib.ExitStack) -> None:
        """The folder and its lock, which is ours while it is open."""
        self._parent = held.enter_context(opened(self.folder.parent))
        while True:
            with contextlib.suppress(FileExistsError):
                os.mkdir(self.folder.name, 0o700, dir_fd=self._parent)
            # a process that has just finished removes the folder, and the lock with it
            with contextlib.suppress(FileNotFoundError), contextlib.ExitStack() as taken:
                self._handle = open_folder(self.folder.name, self._parent)
                taken.callback(os.close, self._handle)
                self._refuse_foreign()
                try:
                    lock = take(_LOCK, self._handle)
                except BlockingIOError as error:
                    raise ResultError(f"{self._result} is being computed by {self._owner()}") from error
                taken.callback(os.close, lock)
                os.ftruncate(lock, 0)
                os.pwrite(lock, f"process {os.getpid()} on {socket.gethostname()}".encode(), 0)
                held.push(taken.pop_all())
                return

    def _refuse_foreign(self) -> None:
        """DistrustError if something in the folder is not of our making."""
        with os.scandir(self._handle) as entries:
            names = {entry.name: entry.is_file(follow_symlinks=False) for entry in entries}
        for name, is_file in names.items():
            if name not in (_PLAN, _LOCK) and not _PART.fullmatch(name) and not self._temporary.fullmatch(name):
                raise DistrustError(f"holds {name}, which hillobs has not written there")
            if not is_file:
                raise DistrustError(f"holds {name}, which is no file")
        said = self._read(_LOCK, _LONGEST_NAME) or b""
        # a full disk may have cut it short
        if not _HOLDER.fullmatch(said) and not b"process ".startswith(said):
            raise DistrustError(f"holds {_LOCK}, which hillobs has not written there")
        # the plan first: it is the smallest
        telling = sorted((name for name in names if name == _PLAN or _PART.fullmatch(name)), reverse=True)
        if telling and not any(_is_of_a_sweep(self._read(name, _LARGEST_PART) or b"") for name in telling):
            raise DistrustError("holds no part of a sweep that bears the seal of hillobs")

    def _compare(self) -> None:
        """Another sweep's parts are not mixed with ours."""
        ours = json.dumps(self._description, sort_keys=True).encode()
        theirs = unsealed(self._read(_PLAN, _LARGEST_PLAN) or b"")
        if theirs is None:  # none, or damaged: each part says itself whose it is
            self._write(_PLAN, sealed(ours))
        elif theirs != ours:
            try:
                other = dict(json.loads(theirs))
            except (ValueError, TypeError):  # sealed, but no plan
                other = {}
            changed = [key for key, value in json.loads(ours).items() if other.get(key) != value]
            raise ResultError(
                f"{self.folder} holds an unfinished sweep with other {' and '.join(changed)}; "
                "finish that one, name another --out, or remove the folder"
            )

    def _read(self, name: str, largest: int) -> bytes | None:
        """The bytes of a file of ours, or None if there is none."""
        try:
            return read_trusted(name, largest, self._handle)
        except FileNotFoundError:
            return None
        except DistrustError as error:
            raise ResultError(f"{self.folder / name} cannot be read: it {error}") from error
        except OSError as error:
            raise ResultError(f"{self.folder / name} cannot be read: {cause(error)}") from error

    def _write(self, name: str, content: bytes) -> None:
        try:
            with temporary_file(self._handle, name, [content], _RIGHTS) as (temporary, _):
                os.replace(temporary, name, src_dir_fd=self._handle, dst_dir_fd=self._handle)
                os.fsync(self._handle)
        except OSError as error:
            raise ResultError(f"{self.folder / name} cannot be written: {cause(error)}") from error

    def _remove(self, names: re.Pattern[str]) -> None:
        """Remove the files with such names; what cannot be removed is left to the next start."""
        for name in filter(names.fullmatch, self._names()):
            with contextlib.suppress(OSError):
                os.unlink(name, dir_fd=self._handle)

    def __iter__(self) -> Iterator[int]:
        """The parts that have a file, whole or not."""
        for name in sorted(self._names()):
            if part := _PART.fullmatch(name):
                yield int(part[1])

    def _names(self) -> list[str]:
        try:
            return os.listdir(self._handle)
        except OSError as error:
            raise ResultError(f"{self.folder} cannot be read: {cause(error)}") from error

    def _owner(self) -> str:
        """Who says in the lock file that it is theirs."""
        with contextlib.suppress(OSError, DistrustError):
            if name := read_trusted(_LOCK, _LONGEST_NAME, self._handle).decode(errors="replace").strip():
                return name
        return "another process"


def _is_of_a_sweep(content: bytes) -> bool:
    """A sealed part, or a sealed plan, which is JSON; a result that lies under such a name is neither."""
    whole = unsealed(content)
    return whole is not None and whole.startswith((_HEAD, b"{"))


def _name(part: int) -> str:
    return f"{part:08d}.part"


def _is_there(name: str, folder: int) -> bool:
    try:
        os.stat(name, dir_fd=folder, follow_symlinks=False)
    except FileNotFoundError:
        return False
    return True
