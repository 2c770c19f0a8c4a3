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
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

from . import cache
from .cache import ABI, BuildError

FLAGS = (
    *("-x", "c++", "-std=c++17", "-O2", "-fPIC", "-shared", "-fvisibility=hidden"),
    *("-ffp-contract=off", "-fno-math-errno", "-fno-trapping-math"),  # -ffast-math would change the caller's FPU
    *("-Wall", "-Wextra", f"-DHILLOBS_ABI={ABI}"),
)
COMPILE_TIMEOUT = 300.0  # seconds
KEPT_LINES, KEPT_BYTES = 20, 16_000  # of what a compiler prints

compiled: list[str] = []  # SHA-free record of this process: the folder of each compile that was started

_SOURCE, _LIBRARY = "hillobs.cpp", "hillobs.so"
_PATH_VARIABLES = ("CPATH", "CPLUS_INCLUDE_PATH", "LIBRARY_PATH", "COMPILER_PATH", "GCC_EXEC_PREFIX", "SDKROOT")
_INSTALL = "install one (`apt install g++`, or `pip install 'hillobs[compiler]'`) or name one in CXX"


@dataclass(frozen=True)
class Compiler:
    """A C++ compiler that has answered: its command line, kind (gcc, clang, zig, unknown), version text, program."""

    command: tuple[str, ...]
    kind: str
    version: str
    path: Path


def build(source: str, description: Mapping[str, object]) -> Path:
    """Return the verified library of `source`, one C++ translation unit, compiled unless the cache has it.

    `description` is what the caller knows about the library: it is stored with it and must be met by it.
    """
    compiler = find_compiler()
    parts = {"source": source, "description": description, **_circumstances(compiler)}
    return cache.obtain(
        cache.entry_key(parts),
        description,
        make=lambda folder: compile_library(source, folder, compiler),
        patience=_timeout() + 60,
    )


def find_compiler() -> Compiler:
    """Return the compiler of CXX or CC, else g++, clang++ or c++, else the `ziglang` wheel."""
    for variable in ("CXX", "CC"):
        if given := os.environ.get(variable, "").strip():
            try:
                return _examine(shlex.split(given))
            except (ValueError, BuildError) as error:
                raise BuildError(f"{variable}={given!r} names no working compiler: {error}") from error
    candidates = [["g++"], ["clang++"], ["c++"]]
    if importlib.util.find_spec("ziglang"):
        candidates.append([sys.executable, "-P", "-m", "ziglang", "c++"])
    for command in candidates:
        with contextlib.suppress(BuildError):
            return _examine(command)
    raise BuildError(f"No C++ compiler was found: {_INSTALL}.")


def compile_library(
    source: str, output_folder: Path, compiler: Compiler, flags: Sequence[str] = (), timeout: float | None = None
) -> Path:
    """Compile one C++ translation unit into a library in `output_folder`; `flags` follow our own, `timeout` in s."""
    compiled.append(str(output_folder))
    cache.write_new(output_folder / _SOURCE, source.encode())
    command = [*compiler.command, *_flags(compiler), *flags, "-o", _LIBRARY, _SOURCE, "-lm"]
    code, output = _run(command, output_folder, _timeout() if timeout is None else timeout)
    if code != 0:
        raise BuildError(f"The compiler {_ending(code)}: {shlex.join(command)}\n{output}")
    if reason := _incomplete(output_folder / _LIBRARY):
        raise BuildError(f"The compiler reported success but {reason}: {shlex.join(command)}\n{output}")
    return output_folder / _LIBRARY


def _circumstances(compiler: Compiler) -> dict[str, object]:
    """Return all but the source that determines the bytes of a library and where they may run."""
    return {
        "abi": ABI,
        "command": compiler.command,
        "flags": _flags(compiler),
        "version": compiler.version,
        "size": compiler.path.stat().st_size,
        "environment": [os.environ.get(name) for name in _PATH_VARIABLES],
        "packages": [_package_version(name) for name in ("hillobs", "casadi")],
        "platform": [sys.platform, *platform.libc_ver(), platform.mac_ver()[0]],
        "cpu": [platform.machine(), *_cpu_features()],
    }


def _examine(command: Sequence[str]) -> Compiler:
    """Return the compiler behind a command line, or raise with the reason why there is none."""
    program = shutil.which(command[0])
    if program is None:
        raise BuildError(f"{command[0]!r} is not a program on the PATH; {_INSTALL}")
    command = (os.path.abspath(program), *command[1:])
    code, version = _run([*command, "--version"], Path("/"), _timeout())
    if code != 0:
        raise BuildError(f"{shlex.join(command)} --version {_ending(code)}\n{version}")
    if "ziglang" in command:
        version += f"\nziglang {_package_version('ziglang')}"
    return Compiler(tuple(command), _kind(version), version, Path(program).resolve())


def _kind(version: str) -> str:
    for kind, sign in (("zig", "zig"), ("clang", "clang"), ("gcc", "Free Software Foundation")):
        if sign in version:
            return kind
    return "unknown"


def _flags(compiler: Compiler) -> tuple[str, ...]:
    """Return our flags; zig would build the C++ library first, a minute, for sources that need none of it."""
    return (*FLAGS, "-nostdlib++") if compiler.kind == "zig" else FLAGS


def _run(command: Sequence[str], folder: Path, timeout: float) -> tuple[int, str]:
    """Run a command in `folder`, in a session of its own; return its exit code and the last lines it printed."""
    environment = {**os.environ, "LC_ALL": "C"}
    try:
        process = subprocess.Popen(
            command,
            cwd=folder,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
            umask=0o077,
        )
    except OSError as error:
        raise BuildError(f"{command[0]} cannot be started: {error.strerror}.") from error
    with process:
        try:
            output = _listen(process, time.monotonic() + timeout)
        except TimeoutError as error:
            raise BuildError(f"{command[0]} took more than {timeout:g} s and was ended.") from error
        finally:
            with contextlib.suppress(ProcessLookupError, PermissionError):
                os.killpg(process.pid, signal.SIGKILL)
        return process.wait(), output
