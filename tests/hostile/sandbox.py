"""The folder of a case: a working folder among things that are none of its business, and what became of them all."""

from __future__ import annotations

import contextlib
import gzip
import hashlib
import os
import shutil
import stat
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from hillobs.studies.files.datasets.netcdf import sealed
from hostile.results import forged_state
from places import RECORDINGS

# bytes of the seal at the end of a result
SEAL = len(sealed(b""))

# where a case works, has its home and its temporary files; `other` belongs to nobody here
DESK, HOME, TEMPORARY, OTHER = "desk", "home", "tmp", "other"
_PRECIOUS = {
    f"{OTHER}/letter.txt": "dear reader\n",
    f"{OTHER}/.hidden": "a dot file\n",
    f"{HOME}/.profile": "umask 022\n",
    f"{DESK}/my.csv": "t,x\n0,1\n",
}
# so that a file that is written again with the same content is noticed
_LONG_AGO = 1_000_000_000

# path → kind, mode, time of the last change, content
Snapshot = dict[str, tuple[str, int, int, str]]


def lay(box: Path, files: Mapping[str, Mapping[str, Any]], result: Callable[[str], bytes]) -> None:
    """Make the folder of a case.

    An entry has one of text (bytes that are no UTF-8 as surrogates), gzip (the same, compressed), link (where to),
    hard (a second name of), folder, pipe, shipped (a file of the laboratory), result and forged (see `results`); and
    mode.
    A result may have edits (place from 0 to 1, and bytes as hex), cut (what is left of it), and seal (whether it is
    sealed again, as a forger would).
    """
    for name in (DESK, HOME, TEMPORARY, OTHER):
        (box / name).mkdir()
    for name, text in _PRECIOUS.items():
        (box / name).write_text(text)
    for name, entry in files.items():
        path = os.path.join(box, DESK, name)
        # a drawn name may be that of a file and of a folder: who comes first has it
        with contextlib.suppress(FileExistsError, NotADirectoryError, IsADirectoryError):
            os.makedirs(os.path.dirname(path), exist_ok=True)
            _put(path, entry, result)
            if "mode" in entry:
                os.chmod(path, entry["mode"])
    for path in _all(box):
        os.utime(path, ns=(_LONG_AGO, _LONG_AGO), follow_symlinks=False)


def _put(path: str, entry: Mapping[str, Any], result: Callable[[str], bytes]) -> None:
    match entry:
        case {"link": target}:
            os.symlink(target, path)
        case {"hard": target}:
            os.link(os.path.join(os.path.dirname(path), target), path)
        case {"folder": _}:
            os.makedirs(path, exist_ok=True)
        case {"pipe": _}:
            os.mkfifo(path)
        case _:
            Path(path).write_bytes(content(entry, result))


def content(entry: Mapping[str, Any], result: Callable[[str], bytes]) -> bytes:
    """The bytes of an entry that is a file."""
    match entry:
        case {"text": text}:
            return text.encode("utf-8", "surrogateescape")
        case {"gzip": text}:
            return gzip.compress(text.encode("utf-8", "surrogateescape"), mtime=0)
        case {"shipped": name}:
            return (RECORDINGS / name).read_bytes()
        case {"forged": changes}:
            return forged_state(changes)
    raw = bytearray(result(entry["result"]))
    for place, piece in entry.get("edits", ()):
        at = int(place * len(raw))
        raw[at : at + len(piece) // 2] = bytes.fromhex(piece)
    whole = bytes(raw[: int(entry.get("cut", 1.0) * len(raw))])
    return sealed(whole[:-SEAL]) if entry.get("seal") else whole


def snapshot(box: Path) -> Snapshot:
    """All that is in the folder of a case."""
    return {os.path.relpath(path, box): _looked_at(path) for path in _all(box)}


def _looked_at(path: str) -> tuple[str, int, int, str]:
    status = os.lstat(path)
    kind = stat.S_IFMT(status.st_mode)
    mode, time = stat.S_IMODE(status.st_mode), status.st_mtime_ns
    if kind == stat.S_IFLNK:
        return "link", 0, time, os.readlink(path)
    if kind == stat.S_IFDIR:
        return "folder", mode, 0, ""
    if kind == stat.S_IFREG:
        return "file", mode, time, hashlib.sha256(Path(path).read_bytes()).hexdigest()
    return "special", mode, time, ""


def _all(box: Path) -> Iterable[str]:
    for folder, folders, files in os.walk(box):
        yield from (os.path.join(folder, name) for name in (*folders, *files))


def remove(box: Path) -> None:
    """The folder of a case, whatever its files may do."""
    for folder, _, _ in os.walk(box):
        os.chmod(folder, 0o700)
    shutil.rmtree(box, ignore_errors=True)
