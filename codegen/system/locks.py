"""Lock files: held by one process at a time, and let go by the system when that process dies."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import time
from collections.abc import Iterator
from pathlib import Path

_POLL = 0.02  # seconds between two looks at a lock


def take(path: Path | str, folder: int | None = None) -> int:
    """Return a descriptor that holds the lock file `path`, made if need be, until it is closed or its process dies.

    folder: a descriptor of the folder that a relative path begins at. BlockingIOError if another process holds it;
    another OSError if there can be no such file, or if it is a link.
    """
    while True:
        handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600, dir_fd=folder)
        try:
            os.fchmod(handle, 0o600)  # the umask may have taken our own rights
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            # its last holder may have removed the file after we opened it: then there may be another one by now
            with contextlib.suppress(FileNotFoundError):
                if os.path.samestat(os.fstat(handle), os.stat(path, dir_fd=folder)):
                    return handle
        except BaseException:
            os.close(handle)
            raise
        os.close(handle)


def wait_for(path: Path, patience: float) -> int:
    """Return a descriptor as `take` does; TimeoutError if another process holds the lock for `patience` seconds."""
    deadline = time.monotonic() + patience
    while True:
        try:
            return take(path)
        except BlockingIOError:
            if time.monotonic() > deadline:
                raise TimeoutError(errno.ETIMEDOUT, "another process does not release it") from None
        time.sleep(_POLL)


@contextlib.contextmanager
def locked(path: Path, patience: float) -> Iterator[None]:
    """Hold the lock `path`; TimeoutError if another process holds it for `patience` seconds."""
    handle = wait_for(path, patience)
    try:
        yield
    finally:
        os.close(handle)
