"""Files that we write: whole or not at all, and over nothing that was read or that is not ours."""

from __future__ import annotations

import contextlib
import hashlib
import os
import re
import secrets
import stat
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path

from .errors import ResultError
from .reading import cause, was_read
from .written import is_ours, remember

# bytes of a name that its temporary name repeats; a name has at most 255
_REPEATED = 40
# bytes of chance that make a temporary name of ours unlike any that a user would think of
_CHANCE = 8


def write_whole(path: Path, content: bytes) -> None:
    """`content` under `path`, or nothing new there. ResultError as in `write_pieces`."""
    write_pieces(path, [content])


def write_pieces(path: Path, pieces: Iterable[bytes]) -> None:
    """The pieces, one after the other, as one file under `path`, or nothing new there.

    ResultError names the file and the cause, also where something is that `refuse_overwriting` refuses.
    """
    with (
        _told(path),
        opened(path.parent) as folder,
        temporary_file(folder, path.name, pieces) as (temporary, digest),
    ):
        _refuse(folder, path)
        remember(folder, path.name, digest)
        os.replace(temporary, path.name, src_dir_fd=folder, dst_dir_fd=folder)
        os.fsync(folder)


@contextlib.contextmanager
def temporary_file(folder: int, name: str, pieces: Iterable[bytes], rights: int = 0o666) -> Iterator[tuple[str, str]]:
    """The temporary name and the SHA-256 of a new file in a folder, which is there until it is given its `name`."""
    temporary = f"{temporary_prefix(name)}{secrets.token_hex(_CHANCE)}"
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC
    handle = os.open(temporary, flags, rights, dir_fd=folder)
    try:
        digest = hashlib.sha256()
        with os.fdopen(handle, "wb") as file:
            for piece in pieces:
                file.write(piece)
                digest.update(piece)
            file.flush()
            os.fsync(handle)
        yield temporary, digest.hexdigest()
    except BaseException:  # a signal too leaves nothing half written
        with contextlib.suppress(OSError):
            os.unlink(temporary, dir_fd=folder)
        raise


def temporary_prefix(name: str) -> str:
    """What the temporary names of a file begin with."""
    return f".{name[:_REPEATED]}-"


def temporary_pattern(*prefixes: str) -> re.Pattern[str]:
    """What temporary names match, and no others; prefixes: patterns of what they begin with."""
    return re.compile(rf"(?:{'|'.join(prefixes)})[0-9a-f]{{{2 * _CHANCE}}}", re.ASCII)


def refuse_overwriting(paths: Iterable[Path]) -> None:
    """ResultError for a path where something is that this command reads, or that hillobs has not written there.

    A link is never ours, nor is a file that was changed since. Also if two results would have one path.
    """
    for path, times in Counter(paths).items():
        if times > 1:
            raise ResultError(f"two results would be called {path}; run them one by one, with an --out each")
        with _told(path), opened(path.parent) as folder:
            _refuse(folder, path)


def refuse_read(paths: Iterable[Path]) -> None:
    """ResultError for a path that leads to a file which this command reads."""
    for path in paths:
        with _told(path), opened(path.parent) as folder:
            _refuse_read(folder, path)


def remove_ours(path: Path) -> None:
    """Remove what is there if hillobs has written it and has not read it now. ResultError if that cannot be."""
    with _told(path), opened(path.parent) as folder:
        if is_ours(folder, path.name) and not was_read(path.name, folder):
            os.unlink(path.name, dir_fd=folder)


@contextlib.contextmanager
def _told(path: Path) -> Iterator[None]:
    """Why the system refuses to write a path, as a ResultError."""
    try:
        yield
    except ResultError:
        raise
    except (OSError, ValueError) as error:
        raise ResultError(f"{path} cannot be written: {cause(error)}") from error


def _refuse(folder: int, path: Path) -> None:
    """ResultError if something is at `path` that may not be replaced; `folder` is a descriptor of its folder."""
    try:
        os.stat(path.name, dir_fd=folder, follow_symlinks=False)
    except FileNotFoundError:
        return
    _refuse_read(folder, path)
    if not is_ours(folder, path.name):
        raise ResultError(
            f"{path} is there already, and not as hillobs wrote it; move it away, or name another folder with --out"
        )


def _refuse_read(folder: int, path: Path) -> None:
    if was_read(path.name, folder):
        raise ResultError(f"{path} is read by this command and would be lost; name another folder with --out")


def writable_folder(folder: Path) -> Path:
    """`folder`, created if need be and proved writable. ResultError otherwise, also if another user's link leads on."""
    try:
        _refuse_foreign_links(folder)  # before anything is made beyond one
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except FileExistsError as error:
        raise ResultError(f"{folder} cannot be written to: it is not a folder") from error
    except ResultError:
        raise
    except (OSError, ValueError) as error:
        raise ResultError(f"{folder} cannot be written to: {cause(error)}") from error


def _refuse_foreign_links(folder: Path) -> None:
    """ResultError if a link of another user, who is not root, is on the way to `folder`."""
    for place in (folder, *folder.parents):
        try:
            info = os.lstat(place)
        except (FileNotFoundError, NotADirectoryError):  # no link of anybody's
            continue
        if stat.S_ISLNK(info.st_mode) and info.st_uid not in (0, os.geteuid()):
            raise ResultError(f"{folder} cannot be written to: {place} is a link of another user")


@contextlib.contextmanager
def opened(folder: Path) -> Iterator[int]:
    """A descriptor of a folder: what is done by it is done there, whatever its path becomes.

    OSError if it cannot be opened, ResultError if another user's link leads there.
    """
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        _refuse_foreign_links(folder)
        yield handle
    finally:
        os.close(handle)
