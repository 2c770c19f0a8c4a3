"""Files of others: regular ones of a bounded size, read at once, or the reason why not."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections.abc import Iterator
from contextvars import ContextVar
from pathlib import Path
from typing import BinaryIO

# device and number of each file that was read, while somebody wants to know
_read: ContextVar[set[tuple[int, int]] | None] = ContextVar("_read", default=None)


@contextlib.contextmanager
def remembered_reading() -> Iterator[None]:
    """What is read from here on is known to `was_read`."""
    token = _read.set(set())
    try:
        yield
    finally:
        _read.reset(token)


def was_read(name: str, folder: int) -> bool:
    """Whether `name` in the folder with this descriptor leads to a file that was read, by whatever path."""
    with contextlib.suppress(OSError):
        return _identity(os.stat(name, dir_fd=folder)) in (_read.get() or ())
    return False


@contextlib.contextmanager
def open_regular(path: Path, largest: int) -> Iterator[tuple[BinaryIO, int]]:
    """A regular file and its size. OSError or ValueError if there is none, or it has more than `largest` bytes."""
    # a pipe without a writer would block, a terminal would become ours
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK | os.O_NOCTTY)) as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "it is no regular file")
        if status.st_size > largest:
            raise OSError(errno.EFBIG, f"it is larger than {largest:,} bytes")
        if (read := _read.get()) is not None:
            read.add(_identity(status))
        yield file, status.st_size


def read_whole(path: Path, largest: int) -> bytes:
    """The bytes of a regular file. OSError or ValueError as in `open_regular`."""
    with open_regular(path, largest) as (file, size):
        return file.read(size)


def cause(error: OSError | ValueError) -> str:
    """Why the system refuses a path."""
    # a ValueError is about the path itself: it holds \0, or half a character
    return (error.strerror if isinstance(error, OSError) else None) or "no file can have this name"


def _identity(status: os.stat_result) -> tuple[int, int]:
    return status.st_dev, status.st_ino
