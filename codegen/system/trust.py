"""Folders and files that nobody else can have made or changed: ours, and no link; all others are refused."""

from __future__ import annotations

import contextlib
import os
import stat
from pathlib import Path


class DistrustError(Exception):
    """Something is there, but not as we would have made it; the message continues a sentence that begins with it."""


def folder_objection(info: os.stat_result) -> str:
    """Return why what `lstat` tells of is no folder of ours alone, or an empty text."""
    if not stat.S_ISDIR(info.st_mode):
        return "is a link" if stat.S_ISLNK(info.st_mode) else "is not a folder"
    return _owner_objection(info)


def make_folder(folder: Path) -> None:
    """Make a folder for us alone, and folders on the way to it; OSError if that cannot be."""
    if not folder.parent.is_dir():
        make_folder(folder.parent)
    with contextlib.suppress(FileExistsError):
        os.mkdir(folder, 0o700)
        os.chmod(folder, 0o700)  # the umask may have taken our own rights


def open_folder(path: Path | str, folder: int | None = None) -> int:
    """Return a descriptor of a folder of ours alone: what is done by it cannot be led elsewhere by a later swap.

    folder: a descriptor of the folder that a relative path begins at. DistrustError if it is a link, something else or
    another user's; OSError if it cannot be opened.
    """
    if objection := folder_objection(os.stat(path, dir_fd=folder, follow_symlinks=False)):
        raise DistrustError(objection)
    handle = os.open(path, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC, dir_fd=folder)
    if objection := folder_objection(os.fstat(handle)):
        os.close(handle)
        raise DistrustError(objection)
    return handle


def read_trusted(path: Path | str, limit: int, folder: int | None = None) -> bytes:
    """Return the bytes of a regular file of ours that no one else may write.

    folder: a descriptor as for `open_folder`. DistrustError if it is something else or larger than `limit` bytes;
    OSError if it cannot be read.
    """
    handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC, dir_fd=folder)
    info = os.fstat(handle)
    if not stat.S_ISREG(info.st_mode):
        os.close(handle)
        raise DistrustError("is not a file")
    with os.fdopen(handle, "rb") as file:
        if objection := _owner_objection(info):
            raise DistrustError(objection)
        if info.st_size > limit:
            raise DistrustError(f"has {info.st_size:,} bytes, more than {limit:,}")
        return file.read(info.st_size + 1)


def write_new(path: Path, content: bytes) -> None:
    """Write a file that must not exist yet, for us alone whatever the umask, and wait for the disk."""
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)
    with os.fdopen(handle, "wb") as file:
        os.fchmod(handle, 0o600)
        file.write(content)
        file.flush()
        os.fsync(handle)


def _owner_objection(info: os.stat_result) -> str:
    if info.st_uid != os.geteuid():
        return "belongs to another user"
    return "can be written by others" if info.st_mode & 0o022 else ""
