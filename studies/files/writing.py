"""Files that we write: whole or not at all."""

from __future__ import annotations

import contextlib
import os
import tempfile
from collections.abc import Iterable
from pathlib import Path

from .errors import ResultError
from .reading import cause


def write_whole(path: Path, content: bytes, folder: Path | None = None) -> None:
    """`content` under `path`, or nothing new there. ResultError names the file and the cause.

    folder: where it is written before it gets its name; beside `path` by default.
    """
    write_pieces(path, [content], folder)


def write_pieces(path: Path, pieces: Iterable[bytes], folder: Path | None = None) -> None:
    """The pieces, one after the other, as one file under `path`, or nothing new there. As above."""
    try:
        handle, temporary = tempfile.mkstemp(dir=folder or path.parent, prefix=f".{path.name[:40]}-")
        try:
            with os.fdopen(handle, "wb") as file:
                file.writelines(pieces)
                file.flush()
                os.fsync(file.fileno())
            os.chmod(temporary, 0o666 & ~_umask())
            os.replace(temporary, path)
        except BaseException:  # a signal too leaves nothing half written
            with contextlib.suppress(OSError):
                os.unlink(temporary)
            raise
        _sync_folder(path.parent)
    except OSError as error:
        raise ResultError(f"{path} cannot be written: {error.strerror}") from error


def writable_folder(folder: Path) -> Path:
    """`folder`, created if need be and proved writable. ResultError otherwise."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except FileExistsError as error:
        raise ResultError(f"{folder} cannot be written to: it is not a folder") from error
    except (OSError, ValueError) as error:
        raise ResultError(f"{folder} cannot be written to: {cause(error)}") from error


def _sync_folder(folder: Path) -> None:
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
