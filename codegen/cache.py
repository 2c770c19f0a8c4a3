"""Where compiled libraries live: found by the hash of all that determines them, checked before each load.

An entry is `<key>.json`, its manifest, `<key>-<hash of the library>.so`, and `<key>.cpp`, the source, for people to
read. What else follows from our code is `<key>.kept`, under a key of its own. Nothing on disk is believed unproved.
"""

from __future__ import annotations

import atexit
import contextlib
import errno
import hashlib
import json
import os
import re
import shutil
import tempfile
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import platformdirs

from ..model.errors import Error
from .system.locks import locked, wait_for
from .system.trust import DistrustError, folder_objection, make_folder, read_trusted, write_new

ABI = 1  # what a library and its caller agree on; raised with each change of the exported functions

MANIFEST_LIMIT, SOURCE_LIMIT = 1_000_000, 50_000_000  # bytes
ZIG_FOLDER = "hillobs-zig"

_OURS = re.compile(r"([0-9a-f]{64})(?:\.json|\.lock|\.cpp|\.kept|-[0-9a-f]{16}\.so|-\w+\.tmp)")
_KEPT = ".kept"
_CLAIM = re.compile(rb'"sha256":"([0-9a-f]{64})","size":([0-9]{1,12}),')
_UNWRITABLE = {errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOLCK, errno.ENOTSUP, errno.ETIMEDOUT}

_private: dict[str, Path] = {}  # reason -> the one private folder of this process
_private_guard = threading.Lock()


class BuildError(Error, RuntimeError):
    """A library could not be built, stored or loaded; the message says what to do."""


class CacheWarning(UserWarning):
    """The cache was damaged or could not be used; the result is not affected."""


class _DamageError(Exception):
    """An entry is there, but not as it was written."""


def entry_key(parts: Mapping[str, object]) -> str:
    """Return the name of an entry: the SHA-256 of all that determines its bytes."""
    return hashlib.sha256(_json(parts).encode()).hexdigest()


@dataclass(frozen=True)
class Order:
    """What is asked of the cache: the key of an entry, what its manifest must say of the library, and its source."""

    key: str
    description: Mapping[str, object]
    source: bytes


def obtain(order: Order, make: Callable[[Path], Path], patience: float) -> Path:
    """Return the verified library of an order, made by `make(scratch folder)` where there is none.

    Processes and threads that ask at once wait up to `patience` seconds for the one that makes it.
    """
    folder = cache_folder()
    _remove_abandoned(folder)
    with contextlib.suppress(_DamageError):
        if library := find(folder, order):
            return library
    try:
        return _make(folder, order, make, patience)
    except OSError as error:
        if error.errno not in _UNWRITABLE:
            raise _failure(folder, error) from error
        folder = _private_folder(f"{folder} cannot be used ({_words(error)})")
    try:
        return _make(folder, order, make, patience)
    except OSError as error:
        raise _failure(folder, error) from error


def find(folder: Path, order: Order) -> Path | None:
    """Return the library of an order if all files of its entry are exactly what is expected, None if there is none."""
    manifest = folder / f"{order.key}.json"
    try:
        text = _read(manifest, MANIFEST_LIMIT)
    except FileNotFoundError:
        return None
    except OSError as error:
        raise _DamageError(f"{manifest} cannot be read ({_words(error)})") from error
    claim = _CLAIM.search(text)  # found, not parsed: the whole text must then be the one we would write
    digest, size = (claim[1].decode(), int(claim[2])) if claim else ("", 0)
    if text != _manifest(order, digest, size):
        raise _DamageError(f"{manifest} is not the manifest of this library")
    library, source = folder / _library_name(order.key, digest), folder / f"{order.key}.cpp"
    content = _read_or_damage(library, size)
    if len(content) != size or hashlib.sha256(content).hexdigest() != digest:
        raise _DamageError(f"{library} is not what was compiled")
    if _read_or_damage(source, len(order.source)) != order.source:
        raise _DamageError(f"{source} is not the source of this library")
    return library


def kept(key: str, make: Callable[[], bytes]) -> bytes:
    """Return what is kept under a key; if nothing is, what `make` makes, which is kept then."""
    if (content := recall(key)) is None:
        remember(key, content := make())
    return content


def remember(key: str, content: bytes) -> None:
    """Keep some bytes under a key, where that can be: what cannot be kept is made again."""
    folder = cache_folder()
    # a disk that is full, or another process that does the same
    with (
        contextlib.suppress(OSError),
        locked(folder / f"{key}.lock", patience=0),
        _scratch(folder, key) as scratch,
    ):
        name = f"{key}{_KEPT}"
        write_new(scratch / name, _kept_seal(key, content) + b"\n" + content)
        os.replace(scratch / name, folder / name)


def recall(key: str) -> bytes | None:
    """Return what is kept under a key; None if there is nothing, or not what was written there."""
    with contextlib.suppress(OSError, _DamageError):
        seal, _, content = _read(cache_folder() / f"{key}{_KEPT}", SOURCE_LIMIT).partition(b"\n")
        if seal == _kept_seal(key, content):
            return content
    return None


def _kept_seal(key: str, content: bytes) -> bytes:
    return hashlib.sha256(key.encode() + content).hexdigest().encode()


def cache_folder() -> Path:
    """Return the folder of the libraries, made 0700; a private one, with a warning, where it cannot be trusted."""
    folder = _location()
    if not os.path.lexists(folder) and folder.is_absolute():
        try:
            make_folder(folder)
        except OSError as error:
            return _private_folder(f"{folder} cannot be made ({_words(error)})")
    if reason := _distrust(folder):
        return _private_folder(f"{folder} {reason}")
    return folder


def clean_cache() -> list[Path]:
    """Remove all that this module wrote, but what another process is building; return what was removed."""
    folder = _location()
    if not os.path.lexists(folder):
        return []
    if reason := _distrust(folder):
        raise BuildError(f"The cache was not cleaned: {folder} {reason}.")
    zig = folder / ZIG_FOLDER
    found = [zig] if zig.is_dir() else []
    _remove(*found)
    try:
        for key in sorted({match[1] for name in os.listdir(folder) if (match := _OURS.fullmatch(name))}):
            with contextlib.suppress(TimeoutError), locked(folder / f"{key}.lock", patience=0):
                names = [name for name in os.listdir(folder) if name.startswith(key) and _OURS.fullmatch(name)]
                _remove(*(folder / name for name in names))
                found += [folder / name for name in names if not name.endswith(".lock")]
    except OSError as error:
        raise BuildError(f"The cache in {folder} cannot be cleaned: {_words(error)}.") from error
    return sorted(path for path in found if not os.path.lexists(path))


def describe_cache() -> dict[str, object]:
    """Return folder, what is wrong with it, number of libraries and their bytes, without touching anything."""
    folder = _location()
    problem = _distrust(folder) if os.path.lexists(folder) else ""
    sizes = []
    with contextlib.suppress(OSError):
        for file in () if problem else os.scandir(folder):
            if file.name.endswith(".so") and _OURS.fullmatch(file.name):
                sizes.append(file.stat().st_size)
    return {"folder": str(folder), "problem": problem, "libraries": len(sizes), "bytes": sum(sizes)}


def kept_sources() -> dict[Path, str]:
    """Return the C++ of each library in the cache, and its title, which is its first line; the newest first."""
    folder = _location()
    if not os.path.lexists(folder) or _distrust(folder):
        return {}
    dated = []
    for path in folder.glob("*.cpp"):
        with contextlib.suppress(OSError, _DamageError):
            if _OURS.fullmatch(path.name):
                title = _read(path, SOURCE_LIMIT).partition(b"\n")[0].decode("utf-8", "replace").removeprefix("// ")
                dated.append((path.stat().st_mtime_ns, path, title))
    return {path: title for _, path, title in sorted(dated, reverse=True)}


def _location() -> Path:
    """Return where the cache should be: HILLOBS_CACHE, `build/cache` of a checkout, the user's cache folder."""
    if given := os.environ.get("HILLOBS_CACHE"):
        if not os.path.isabs(given):
            raise BuildError(f"HILLOBS_CACHE must be an absolute path, not {given!r}.")
        return Path(given)
    root = Path(__file__).parents[1]
    with contextlib.suppress(OSError, UnicodeDecodeError):
        if (root / "build").is_dir() and 'name = "hillobs"' in (root / "pyproject.toml").read_text("utf-8"):
            return root / "build" / "cache"
    try:
        return platformdirs.user_cache_path("hillobs")
    except RuntimeError:  # neither HOME nor an entry for the user
        return Path("~/.cache/hillobs")


def _distrust(folder: Path) -> str:
    """Return why libraries from `folder` must not be loaded, or an empty text."""
    if not folder.is_absolute():
        return "is not an absolute path"
    try:
        return folder_objection(os.lstat(folder))
    except OSError as error:
        return f"cannot be looked at ({_words(error)})"


def _private_folder(reason: str) -> Path:
    """Return a folder of this process alone, removed at exit; warn once for each reason."""
    with _private_guard:
        known = reason in _private
        folder = next(iter(_private.values()), None) or _make_private_folder(reason)
        _private[reason] = folder
    if not known:
        message = f"{reason}: libraries are compiled into {folder} and removed at exit."
        warnings.warn(message, CacheWarning, stacklevel=2)
    return folder


def _make_private_folder(reason: str) -> Path:
    try:
        parent = Path(tempfile.gettempdir())
        _remove_abandoned_private(parent)
        folder = Path(tempfile.mkdtemp(prefix="hillobs-", dir=parent))
        os.chmod(folder, 0o700)
        wait_for(folder / "owner.lock", patience=0)  # held until this process ends, however it ends
    except OSError as error:
        raise BuildError(f"{reason}, and no temporary folder can be made ({_words(error)}).") from error
    owner = os.getpid()
    atexit.register(lambda: _remove(folder) if os.getpid() == owner else None)
    return folder


def _remove_abandoned_private(parent: Path) -> None:
    """Remove private folders whose process has died."""
    for path in parent.glob("hillobs-*/owner.lock"):
        if not _distrust(path.parent):
            with contextlib.suppress(OSError), locked(path, patience=0):
                _remove(path.parent)


def _remove_abandoned(folder: Path) -> None:
    """Remove scratch folders whose process has died: those whose key nobody has locked."""
    with contextlib.suppress(OSError):
        for name in os.listdir(folder):
            if name.endswith(".tmp") and (match := _OURS.fullmatch(name)):
                with contextlib.suppress(OSError), locked(folder / f"{match[1]}.lock", patience=0):
                    _remove(folder / name)


def _make(folder: Path, order: Order, make: Callable[[Path], Path], patience: float) -> Path:
    """Make and publish the entry, unless another process has done so while we waited."""
    damage = ""
    with locked(folder / f"{order.key}.lock", patience):
        try:
            if library := find(folder, order):
                return library
        except _DamageError as error:
            damage = str(error)
        with _scratch(folder, order.key) as scratch:
            _publish(folder, scratch, order, make(scratch).read_bytes())
        try:
            library = find(folder, order)
        except _DamageError as error:
            raise BuildError(f"The disk does not keep what is written to it: {error}.") from error
    if library is None:
        raise BuildError(f"{folder} was emptied while a library was built into it; run again.")
    if damage:
        warnings.warn(f"{damage}; it has been built again.", CacheWarning, stacklevel=2)
    return library


def _publish(folder: Path, scratch: Path, order: Order, content: bytes) -> None:
    """Move source, library and at last the manifest to their final names, which are never opened for writing."""
    digest = hashlib.sha256(content).hexdigest()
    files = {
        f"{order.key}.cpp": order.source,
        _library_name(order.key, digest): content,
        f"{order.key}.json": _manifest(order, digest, len(content)),
    }
    for name, data in files.items():
        write_new(scratch / name, data)
        os.replace(scratch / name, folder / name)
    with contextlib.suppress(OSError):  # some file systems cannot; what is lost then is found by its hash
        handle = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
        os.fsync(handle)
        os.close(handle)


def _manifest(order: Order, digest: str, size: int) -> bytes:
    """Return the one text that may stand in the manifest of this library; the key speaks for the source."""
    name = _library_name(order.key, digest)
    about = {"abi": ABI, "key": order.key, "library": name, "sha256": digest, "size": size}
    body = {**about, "description": order.description}
    seal = hashlib.sha256(_json(body).encode()).hexdigest()
    text = _json({**body, "manifest_sha256": seal}).encode() + b"\n"
    if len(text) > MANIFEST_LIMIT:
        raise BuildError(f"The description of the library takes {len(text)} bytes, more than {MANIFEST_LIMIT}.")
    return text


def _read_or_damage(path: Path, limit: int) -> bytes:
    try:
        return _read(path, limit)
    except OSError as error:
        raise _DamageError(f"{path} cannot be read ({_words(error)})") from error


def _read(path: Path, limit: int) -> bytes:
    try:
        return read_trusted(path, limit)
    except DistrustError as error:
        raise _DamageError(f"{path} {error}") from error


@contextlib.contextmanager
def _scratch(folder: Path, key: str) -> Iterator[Path]:
    """Give a folder to build in, next to the final names; without its lock, another start removes it."""
    path = Path(tempfile.mkdtemp(prefix=f"{key}-", suffix=".tmp", dir=folder))
    try:
        os.chmod(path, 0o700)
        yield path
    finally:
        _remove(path)


def _remove(*paths: Path) -> None:
    """Remove files and folders; what cannot be removed is left to the next start."""
    for path in paths:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path, ignore_errors=True)
        else:
            with contextlib.suppress(OSError):
                path.unlink()


def _library_name(key: str, digest: str) -> str:
    return f"{key}-{digest[:16]}.so"


def _json(value: object) -> str:
    """Return the one JSON text of a value; the order of keys counts, as array positions may hang on it."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False)


def _words(error: OSError) -> str:
    return error.strerror or type(error).__name__


def _failure(folder: Path, error: OSError) -> BuildError:
    return BuildError(f"The compiled library cannot be stored in {folder}: {_words(error)}.")
