"""`make portable`: what compiled code computes, for every target, division and compiler that can be tried here.

No processor is at hand but this one, so two compilers stand for others: one that schedules for AMD's, and one that
rounds every source in its own way. Tests that compare two libraries to the last bit pass by chance without them. ARM's
is emulated, which takes half an hour for the tests of the kernel alone.
"""

import os
import platform
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path

import arm64
from hillobs.codegen.cache import BuildError
from hillobs.codegen.toolchain import NATIVE, PORTABLE, TARGETS, find_compiler, target_flags
from places import ROOT
from targets import DIVISIONS, NEWTON, PLAIN

COMPILERS = ("g++", "clang++")
UNEVEN = f"sh {shlex.quote(str(Path(__file__).with_name('uneven.sh')))}"
STAND_INS = (*(["g++ -mtune=znver3"] if platform.machine() == "x86_64" else []), UNEVEN)
# the kernel divides by Newton's method in vectors of 512 bits only
WIDE = (NATIVE, "x86-64-v4")
# tests of the kernel
KERNEL = ("tests/codegen", "tests/model", "tests/observers")
# tests of what zig compiles for other systems and for pages
ABROAD = ("tests/codegen/test_generated_c.py", "tests/studies/export")


def runs() -> Iterator[tuple[str, str, str]]:
    """Compiler, target and division of each run."""
    for compiler in COMPILERS:
        for target in TARGETS:
            for division in DIVISIONS if target in WIDE else (PLAIN,):
                yield compiler, target, division
    for compiler in STAND_INS:
        for target in dict.fromkeys([NATIVE, PORTABLE]):
            yield compiler, target, PLAIN


def refusal(compiler: str, target: str, division: str) -> str:
    """Why this cannot be tried here, or an empty text."""
    if shutil.which("g++" if compiler in STAND_INS else compiler) is None:
        return "not installed"
    try:
        target_flags(target, find_compiler())
        if division == NEWTON:
            target_flags(WIDE[-1], find_compiler())
    except BuildError as error:
        return str(error)
    return ""


def tried(target: str, division: str, *more: str, python: Sequence[str] = (sys.executable,)) -> tuple[bool, str]:
    """Whether all tests of numerics passed for a target, and pytest's last line."""
    return passes("-m", "numerics", "--target", target, "--division", division, *more, python=python)


def passes(*arguments: str, python: Sequence[str] = (sys.executable,)) -> tuple[bool, str]:
    """Whether all tests passed, and pytest's last line; what is wrong is printed."""
    command = [*python, "-m", "pytest", "-p", "no:cacheprovider", *arguments, *sys.argv[1:]]
    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    if ran.returncode:
        print(ran.stdout + ran.stderr)
    return ran.returncode == 0, (ran.stdout.strip().splitlines() or ["nothing was run"])[-1]


def on_arm() -> tuple[bool, str]:
    """The same of an emulated ARM processor, for the tests of the kernel; a worker cannot start others there."""
    if reason := arm64.missing():
        return True, f"skipped: {reason}"
    return tried("arm64", PLAIN, "-n0", *KERNEL, python=arm64.python())


def main() -> int:
    """Try them all; 0 if each passed. Further arguments are pytest's."""
    start, table, passed = time.monotonic(), [], True
    for compiler, target, division in runs():
        os.environ["CXX"] = compiler  # the compiler that `find_compiler` takes, here and in pytest
        reason = refusal(compiler, target, division)
        good, words = (True, f"skipped: {reason}") if reason else tried(target, division)
        name = "g++, unevenly" if compiler == UNEVEN else compiler
        table.append(f"{name:18} {target:14} {division:7} {words}")
        print(table[-1], flush=True)
        passed &= good
    for name, compiler, trial in (
        ("zig, for other systems", COMPILERS[0], lambda: passes(*ABROAD)),
        (f"{arm64.COMPILER}, under {arm64.EMULATOR}", arm64.COMPILER, on_arm),
    ):
        os.environ["CXX"] = compiler
        good, words = trial()
        table.append(f"{name:41} {words}")
        print(table[-1], flush=True)
        passed &= good
    print("\n".join(["", *table, f"{'all' if passed else 'not all'} passed, {time.monotonic() - start:.0f} s"]))
    return 0 if passed else 1


if __name__ == "__main__":
    sys.exit(main())
