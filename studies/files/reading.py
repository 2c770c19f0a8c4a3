"""Files of others: regular ones of a bounded size, read at once, or the reason why not."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO


@contextlib.contextmanager
def open_regular(path: Path, largest: int) -> Iterator[tuple[BinaryIO, int]]:
    """A regular file and its size. OSError or ValueError if there is none, or it has more than `largest` bytes."""
    # a pipe without a writer would block
    with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)) as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode):
            raise OSError(errno.EINVAL, "it is no regular file")
        if status.st_size > largest:
            raise OSError(errno.EFBIG, f"it is larger than {largest:,} bytes")
        yield file, status.st_size


def read_whole(path: Path, largest: int) -> bytes:
    """The bytes of a regular file. OSError or ValueError as in `open_regular`."""
    with open_regular(path, largest) as (file, size):
        return file.read(size)


def cause(error: OSError | ValueError) -> str:
    """Why the system refuses a path."""
    # a ValueError is about the path itself: it holds \0, or half a character
    return (error.strerror if isinstance(error, OSError) else None) or "no file can have this name"
