"""What hillobs has written into a folder: a list there of hashes and names, by which it knows what it may replace.

Each user has a list of their own, so that in a shared folder nobody's list speaks for another's files.
"""

from __future__ import annotations

import hashlib
import os
import stat

from .errors import ResultError
from .quote import escaped

# bytes; a line has about a hundred
_LARGEST_LIST = 100_000_000


def is_ours(folder: int, name: str) -> bool:
    """Whether the file `name` in the folder with this descriptor is, to the byte, what hillobs has written there."""
    try:
        handle = os.open(name, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, dir_fd=folder)
    except OSError:  # a link, a socket, or nothing
        return False
    if not stat.S_ISREG(os.fstat(handle).st_mode):
        os.close(handle)
        return False
    with os.fdopen(handle, "rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    try:
        return _line(name, digest) in _list(folder, os.O_RDONLY)
    except FileNotFoundError:
        return False


def remember(folder: int, name: str, digest: str) -> None:
    """Enter a file into the list before it gets its name, so that no kill can make a stranger of it."""
    line = _line(name, digest)
    if line in _list(folder, os.O_RDONLY | os.O_CREAT):
        return
    with os.fdopen(_open_list(folder, os.O_WRONLY | os.O_APPEND), "ab") as file:
        file.write(line)
        file.flush()
        os.fsync(file.fileno())


def list_name() -> str:
    """What the list of this user is called."""
    return f".hillobs-{os.geteuid()}"


def _line(name: str, digest: str) -> bytes:
    # it begins with an end of line: one that a full disk has cut stays alone
    return f"\n{digest}  {escaped(name)}\n".encode()


def _list(folder: int, flags: int) -> bytes:
    """The whole list."""
    handle = _open_list(folder, flags)
    with os.fdopen(handle, "rb") as file:
        return file.read(_LARGEST_LIST)


def _open_list(folder: int, flags: int) -> int:
    """A descriptor of the list. ResultError if others have made it."""
    name = list_name()
    handle = os.open(name, flags | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, 0o600, dir_fd=folder)
    info = os.fstat(handle)
    # a second name would be a hard link to some file of the user's; rights are not asked: not all file systems keep any
    if stat.S_ISREG(info.st_mode) and info.st_uid == os.geteuid() and info.st_nlink == 1:
        return handle
    os.close(handle)
    raise ResultError(f"{name} in the folder of the results was not made by hillobs: remove it, or name another folder")
