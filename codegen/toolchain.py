"""From C++ source to a compiled library: finds a compiler, runs it without a shell, keeps the result in the cache."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import platform
import re
import selectors
import shlex
import shutil
import signal
import stat
import struct
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import IO, cast

from . import cache
from .building import building
from .cache import ABI, BuildError
from .system.processor import divides_slowly, features, lacking
from .system.signals import HeldSignals
from .system.trust import write_new

FLAGS = (
    *("-x", "c++", "-std=c++17", "-O3", "-fPIC", "-shared", "-fvisibility=hidden"),
    *("-ffp-contract=fast", "-fno-math-errno", "-fno-trapping-math"),  # -ffast-math would change the caller's FPU
    *("-Wall", "-Wextra", "-Wno-psabi", f"-DHILLOBS_ABI={ABI}"),  # vectors as arguments stay within one library
)
# contracted sums would round otherwise on another kind of processor
C_FLAGS = ("-std=c99", "-O2", "-shared", "-fvisibility=hidden", "-ffp-contract=off", "-Wall", "-Wextra")
# of a module for a page, which gives it mathematics; it tells where the page's arrays may begin
WEB = "wasm32-freestanding"
_WEB_FLAGS = (
    *("-target", WEB, "-std=c99", "-O3", "-fno-math-errno", "-nostdlib"),
    *(f"-Wl,{word}" for word in ("--no-entry", "--strip-all", "--import-symbols", "--export=__heap_base")),
)
NATIVE = "native"
SINGLE = "native-scalar"
_MACHINE = re.sub("x86_64|amd64", "x86-64", platform.machine().lower()).replace("aarch64", "arm64")
_SCALAR = "-DHILLOBS_SCALAR"
_THIS_ONE = "-mcpu=native" if _MACHINE == "arm64" else "-march=native"
# what a library is compiled for: this processor; a class of them, for equal numbers on several machines; any, one run
# at a time; this one, one run at a time
TARGETS: Mapping[str, tuple[str, ...]] = {
    NATIVE: (_THIS_ONE,),
    "x86-64-v2": ("-march=x86-64-v2",),
    "x86-64-v3": ("-march=x86-64-v3",),
    "x86-64-v4": ("-march=x86-64-v4",),
    "arm64": ("-mcpu=generic",),
    "scalar": (_SCALAR,),
    SINGLE: (_THIS_ONE, _SCALAR),
}
# fast on almost all processors of this kind
PORTABLE = {"x86-64": "x86-64-v3", "arm64": "arm64"}.get(_MACHINE, "scalar")
# how libraries of other systems begin: Mach-O for one processor and for several, Windows, WebAssembly
_NOT_ELF = (b"\xcf\xfa\xed\xfe", b"\xca\xfe\xba\xbe", b"MZ", b"\0asm")
COMPILE_TIMEOUT = 300.0  # seconds
KEPT_LINES, KEPT_BYTES = 20, 16_000  # of what a compiler prints

_SOURCE, _LIBRARY = "hillobs.cpp", "hillobs.so"
_PATH_VARIABLES = ("CPATH", "CPLUS_INCLUDE_PATH", "LIBRARY_PATH", "COMPILER_PATH", "GCC_EXEC_PREFIX", "SDKROOT")
_POLL = 0.02  # seconds between two looks at a silent compiler
_INSTALL = "Install one: `apt install g++`, or `pip install 'hillobs[compiler]'`."


@dataclass(frozen=True)
class Compiler:
    """A C++ compiler: its command line, kind (gcc, clang, zig, unknown), what it says of its version, its program."""

    command: tuple[str, ...]
    kind: str
    version: str
    path: Path


def build(source: str, description: Mapping[str, object], target: str = NATIVE) -> Path:
    """Return the verified library of `source`, one C++ translation unit, compiled unless the cache has it.

    `description` is what the caller knows of it (names in array order, sizes); the manifest must say the same.
    `target` is a name of TARGETS.
    """
    compiler = find_compiler()
    flags = target_flags(target, compiler)
    circumstances = {**_circumstances(compiler), "target": flags}
    key = cache.entry_key({"source": source, "description": description, **circumstances})

    def make(folder: Path) -> Path:
        with building(description, compiler.kind):
            return compile_library(source, folder, compiler, flags)

    order = cache.Order(key, description, source.encode())
    return cache.obtain(order, make, patience=_timeout() + 60)


def build_c(files: Mapping[str, str], title: str, target: str = "") -> Path:
    """Return the verified library of C files, by name, compiled unless the cache has it.

    title: what it is, in a few words. target: a machine as zig names it, for which the `ziglang` wheel compiles; by
    default this one, with the compiler found here.
    """
    compiler = zig() if target else find_compiler()
    if compiler is None:
        raise BuildError(f"For {target} the compiler `ziglang` is needed: `pip install 'hillobs[compiler]'`.")
    # g++ forgets after a file that it is to take it for C
    sources = [word for name in files if name.endswith(".c") for word in ("-x", "c", name)]
    libraries = () if target == WEB else ("-lm",)
    command = [*compiler.command, *_c_flags(compiler, target), "-o", _LIBRARY, *sources, *libraries]
    description = {"functions": [{"name": title}]}
    circumstances = {**_circumstances(compiler), "command": command}
    key = cache.entry_key({"files": dict(files), "description": description, **circumstances})

    def make(folder: Path) -> Path:
        with building(description, compiler.kind):
            return _compile(command, folder, files)

    text = "\n".join([f"// {title}", *(f"// {name}\n{text}" for name, text in files.items())])
    return cache.obtain(cache.Order(key, description, text.encode()), make, patience=_timeout() + 60)


def _c_flags(compiler: Compiler, target: str) -> tuple[str, ...]:
    """Return the flags for C that others load: for any processor of its kind, and the C library alone."""
    if target == WEB:
        return _WEB_FLAGS
    if target:
        position = () if "windows" in target else ("-fPIC",)
        return (*C_FLAGS, *position, "-nostdlib++", "-s", "-target", target)
    # the C++ compiler would ask for its own libraries too
    lean = ("-nostdlib++", "-mcpu=baseline") if compiler.kind == "zig" else ()
    needed = () if sys.platform == "darwin" else ("-Wl,--as-needed",)
    return (*C_FLAGS, "-fPIC", *lean, *needed)


def find_compiler() -> Compiler:
    """Return the compiler of CXX or CC, else g++, clang++ or c++, else the `ziglang` wheel."""
    limit = _timeout()
    for variable in ("CXX", "CC"):
        if given := os.environ.get(variable, "").strip():
            try:
                return _examine(shlex.split(given), limit)
            except (ValueError, BuildError) as error:
                # what is no compiler may say a page about itself
                words = str(error).splitlines()[0].rstrip(".")
                raise BuildError(f"{variable}={given!r} is no working compiler: {words}. {_INSTALL}") from error
    refusals = []
    for name in ("g++", "clang++", "c++"):
        try:
            return _examine([name], limit)
        except BuildError as error:
            refusals.append(str(error))
    if wheel := zig():
        return wheel
    raise BuildError(f"No C++ compiler was found. {' '.join(refusals)} {_INSTALL}")


def compile_library(
    source: str, output_folder: Path, compiler: Compiler, flags: Sequence[str] = (), timeout: float | None = None
) -> Path:
    """Return the library of one C++ translation unit, compiled in `output_folder`, an empty folder.

    `flags` come after our own; `timeout` is in seconds, by default that of HILLOBS_COMPILE_TIMEOUT.
    """
    command = [*compiler.command, *_flags(compiler), *flags, "-o", _LIBRARY, _SOURCE, "-lm"]
    return _compile(command, output_folder, {_SOURCE: source}, timeout)


def _compile(command: Sequence[str], folder: Path, files: Mapping[str, str], timeout: float | None = None) -> Path:
    """Return the library that a command makes of files in an empty folder."""
    library = folder / _LIBRARY
    scratch = {"TMPDIR": str(folder), "ZIG_LOCAL_CACHE_DIR": str(folder / "zig")}
    shared = {"ZIG_GLOBAL_CACHE_DIR": str(folder.parent / cache.ZIG_FOLDER)}
    try:
        for name, text in files.items():
            write_new(folder / name, text.encode())
        code, output = _run(command, folder, _timeout() if timeout is None else timeout, scratch | shared)
        problem = _ending(code) if code else _incomplete(library)
    except OSError as error:
        # the folder that stays; this one is gone when the sentence is read
        raise BuildError(f"Nothing can be compiled in {folder.parent}: {error.strerror}.") from error
    if problem:
        raise BuildError(f"The compiler {problem}: {shlex.join(command)}\n{output}")
    return library


def _circumstances(compiler: Compiler) -> dict[str, object]:
    """Return all but the source that determines the bytes of a library and where they may run."""
    return {
        "abi": ABI,
        "command": compiler.command,
        "flags": _flags(compiler),
        "version": compiler.version,
        "size": compiler.path.stat().st_size if compiler.path.is_file() else 0,
        "environment": [os.environ.get(name) for name in _PATH_VARIABLES],
        "packages": [_package_version(name) for name in ("hillobs", "casadi")],
        "platform": [sys.platform, *platform.libc_ver(), platform.mac_ver()[0]],
        "cpu": [platform.machine(), *features()],
    }


def _examine(given: Sequence[str], limit: float) -> Compiler:
    """Return the compiler behind a command line, or raise with the reason why there is none."""
    program = shutil.which(given[0])
    if program is None:
        raise BuildError(f"There is no program {given[0]!r}.")
    command = (os.path.abspath(program), *given[1:])
    code, version = _run([*command, "--version"], Path("/"), limit)
    if code:
        raise BuildError(f"{shlex.join(command)} --version {_ending(code)}. {version}")
    return Compiler(command, _kind(version), version, Path(program).resolve())


def zig() -> Compiler | None:
    """Return the compiler of the `ziglang` wheel, or None; its version needs no start of it."""
    found = importlib.util.find_spec("ziglang")
    if found is None or found.origin is None:
        return None
    # -P: a folder `ziglang` in the current one is never imported
    command = (sys.executable, "-P", "-m", "ziglang", "c++")
    return Compiler(command, "zig", f"ziglang {_package_version('ziglang')}", Path(found.origin).with_name("zig"))


def _kind(version: str) -> str:
    for kind, sign in (("zig", "zig"), ("clang", "clang"), ("gcc", "Free Software Foundation")):
        if sign in version:
            return kind
    return "unknown"


def target_flags(target: str, compiler: Compiler) -> tuple[str, ...]:
    """Return the flags for a name of TARGETS; BuildError if there is none, or this processor cannot execute it."""
    flags = TARGETS.get(target)
    if flags is None:
        raise BuildError(f"Unknown target {target!r}; there are {', '.join(TARGETS)}.")
    machine = _MACHINE if target in (NATIVE, SINGLE, "scalar") else target.partition("-v")[0]
    if machine != _MACHINE:
        raise BuildError(f"The target {target} is for {machine}; this machine is {_MACHINE}.")
    if missing := lacking(target):
        raise BuildError(f"The target {target} needs {', '.join(missing)}, which this processor does not have.")
    # registers of 512 bits, where there are any: gcc would rather use half of them; only x86 knows the flag
    vectors = _MACHINE == "x86-64" and any(flag.startswith("-march=") for flag in flags)
    wide = ("-mprefer-vector-width=512",) if vectors else ()
    # a class of processors has members with slow and with fast dividers
    slow = ("-DHILLOBS_SLOW_DIVISION",) if target == NATIVE and divides_slowly() else ()
    return (*(_in_zig(flags) if compiler.kind == "zig" else flags), *wide, *slow)


def _in_zig(flags: Sequence[str]) -> tuple[str, ...]:
    """Return flags for processors as zig spells them; where none is named, zig would take this one."""
    named = any(flag.startswith(("-march=", "-mcpu=")) for flag in flags)
    return (*(flag.replace("x86-64-v", "x86_64_v") for flag in flags), *(() if named else ("-mcpu=baseline",)))


# what one kind of compiler wants beside FLAGS
_OWN_FLAGS: Mapping[str, tuple[str, ...]] = {
    # scheduling before register allocation; clang does so by default
    "gcc": ("-fschedule-insns", "-fsched-pressure"),
    # else zig first builds the C++ library, a minute, though our sources use C headers only
    "zig": ("-nostdlib++",),
}


def _flags(compiler: Compiler) -> tuple[str, ...]:
    """Return our flags for this compiler."""
    return (*FLAGS, *_OWN_FLAGS.get(compiler.kind, ()))


def _timeout() -> float:
    """Return how long a compile may take, in seconds."""
    given = os.environ.get("HILLOBS_COMPILE_TIMEOUT", "").strip()
    if not given:
        return COMPILE_TIMEOUT
    if not re.fullmatch(r"[0-9]{1,9}(\.[0-9]{1,9})?", given) or float(given) == 0:
        raise BuildError(f"HILLOBS_COMPILE_TIMEOUT must be a number of seconds above 0, not {given!r}.")
    return float(given)


def _run(
    command: Sequence[str], folder: Path, timeout: float, variables: Mapping[str, str] | None = None
) -> tuple[int, str]:
    """Run a command in `folder` and a session of its own; return its exit code and the last lines it printed."""
    held = HeldSignals()
    try:
        with subprocess.Popen(
            command,
            cwd=folder,
            env={**os.environ, **(variables or {}), "LC_ALL": "C"},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            umask=0o077,
        ) as process:
            try:
                held.release()
                output = _listen(process, timeout)
            finally:
                with contextlib.suppress(ProcessLookupError, PermissionError):
                    os.killpg(process.pid, signal.SIGKILL)
        return process.returncode, output
    except subprocess.TimeoutExpired as error:
        raise BuildError(f"{command[0]} took more than {timeout:g} s (HILLOBS_COMPILE_TIMEOUT).") from error
    except OSError as error:
        raise BuildError(f"{command[0]} cannot be run: {error.strerror}.") from error
    finally:
        held.release()


def _listen(process: subprocess.Popen[bytes], timeout: float) -> str:
    """Wait for a process and return its last lines; of what it prints no more than them is kept."""
    deadline = time.monotonic() + timeout
    stream = cast(IO[bytes], process.stdout).fileno()
    kept = b""
    with selectors.DefaultSelector() as selector:
        selector.register(stream, selectors.EVENT_READ)
        while (left := deadline - time.monotonic()) > 0:
            # polled before reading: what it wrote before it ended is then still read
            ended = process.poll() is not None
            if selector.select(0 if ended else _POLL):
                piece = os.read(stream, 1 << 16)
                kept = (kept + piece)[-KEPT_BYTES:]
                if not piece:
                    process.wait(left)
                    break
            elif ended:  # something it started keeps the stream open
                break
        else:
            raise subprocess.TimeoutExpired(process.args, timeout)
    return _last_lines(kept)


def _last_lines(output: bytes) -> str:
    """Return the last lines with every control character spelled out, so that a terminal does not obey them."""
    lines = output.decode("utf-8", "replace").splitlines()[-KEPT_LINES:]
    return "\n".join("".join(c if c.isprintable() else repr(c)[1:-1] for c in line.expandtabs()) for line in lines)


def _ending(code: int) -> str:
    if code > 0:
        return f"failed with exit code {code}"
    with contextlib.suppress(ValueError):
        return f"was ended by {signal.Signals(-code).name}"
    return f"was ended by signal {-code}"


def _incomplete(library: Path) -> str:
    """Return what is wrong with the file that a compiler left, or an empty text."""
    try:
        if not stat.S_ISREG(library.stat().st_mode):  # a pipe would be waited for
            return "reported success but what it wrote is no file"
        with library.open("rb") as file:
            head, size = file.read(64), os.fstat(file.fileno()).st_size
    except FileNotFoundError:
        return "reported success but wrote no library"
    if head.startswith(_NOT_ELF):
        return ""
    if head[:4] != b"\x7fELF" or len(head) < 64:
        return "reported success but what it wrote is not a library"
    # the section table comes last: a file that holds all of it was not cut short
    start, (entry, count) = int.from_bytes(head[40:48], sys.byteorder), struct.unpack("=HH", head[58:62])
    return "" if start + entry * count <= size else "reported success but wrote only part of a library"


def _package_version(name: str) -> str:
    with contextlib.suppress(metadata.PackageNotFoundError):
        return metadata.version(name)
    return "unknown"
