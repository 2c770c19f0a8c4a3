"""The C++ as a compiler sees it: no warning, no report of the sanitizers, its own exports only."""

import functools
import importlib.util
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import casadi as ca
import pytest

from hillobs.codegen.batch import compile_loop
from hillobs.codegen.export import Source, export_functions
from hillobs.codegen.loop import Loop, export_loop
from hillobs.codegen.recordings.filters import export_bank
from hillobs.codegen.toolchain import NATIVE, Compiler, find_compiler, target_flags
from hillobs.model.curves import NGUYEN2019
from hillobs.model.plant import DRIVES
from hillobs.model.system import PAIR
from hillobs.observers import OBSERVERS, PAPER
from hillobs.studies.estimate.follow import follower_bank
from hillobs.studies.scenarios.loops import all_paths, paper_loop
from tools import needs_zig

SANITIZE = (
    "-O0",
    "-g",
    "-march=native",
    "-Wno-psabi",
    "-fsanitize=address,undefined,float-cast-overflow",
    "-fno-sanitize-recover=all",
)


def compile_text(
    text: str, folder: Path, *flags: str, by: Sequence[str] | None = None
) -> subprocess.CompletedProcess[str]:
    (folder / "loop.cpp").write_text(text)
    command = [*(by or find_compiler().command), "-std=c++17", "-DHILLOBS_ABI=1", "loop.cpp", "-o", "loop", *flags]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def source(drive: str) -> Source:
    return export_loop(paper_loop(drive, NGUYEN2019))


SOURCES: dict[str, Callable[[], Source]] = {
    **{drive: functools.partial(source, drive) for drive in DRIVES},
    "followers": lambda: export_bank(follower_bank(PAIR, True, tuple(OBSERVERS.values()))),
    "functions": lambda: export_functions([ca.Function("nothing", [], [ca.SX(1)])]),
}
COMPILERS = {
    "g++": ["g++"],
    "clang++": ["clang++"],
    "zig": [sys.executable, "-P", "-m", "ziglang", "c++"],
}


@pytest.mark.parametrize("what", SOURCES)
@pytest.mark.parametrize("name", COMPILERS)
def test_it_compiles_without_a_warning(name: str, what: str, tmp_path: Path) -> None:
    """With each compiler that is installed, for all its lanes."""
    command, zig = COMPILERS[name], name == "zig"
    if shutil.which(command[0]) is None or (zig and importlib.util.find_spec("ziglang") is None):
        pytest.skip(f"{name} is not installed")
    compiler = Compiler(tuple(command), "zig" if zig else "", "", Path())
    checked = ("-O0", "-c", "-o", "loop.o") if zig else ("-fsyntax-only",)
    strict = ("-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wno-psabi")
    done = compile_text(SOURCES[what]().text, tmp_path, *target_flags(NATIVE, compiler), *strict, *checked, by=command)
    assert done.returncode == 0, done.stderr[-2000:]


@needs_zig
@pytest.mark.parametrize("system", ["aarch64-macos", "x86_64-macos", "x86_64-windows-gnu", "aarch64-windows-gnu"])
def test_so_it_does_for_other_systems(system: str, tmp_path: Path) -> None:
    """To an object file: there is none of their linkers here, and none of their processors."""
    strict = ("-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O0", "-c", "-o", "loop.o")
    done = compile_text(SOURCES["given"]().text, tmp_path, "-target", system, *strict, by=COMPILERS["zig"])
    assert done.returncode == 0, done.stderr[-2000:]


# every array has exactly the size that the description promises, so that the sanitizer sees one number too many
MAIN = """
#include <stdio.h>
#include <stdlib.h>

static V *numbers(int n) {{ return n ? (V *)calloc(n, sizeof(V)) : (V *)aligned_alloc(64, 64); }}

static V *filled(int n, const double *from) {{
    V *to = numbers(n);
    for (int i = 0; i < n; ++i) to[i] = V(from[i]);
    return to;
}}

template <class B> static void make(List<B>, Part *part, const double *const *p, int64_t points) {{
    part->p = filled(B::NP, *p);
    part->c = numbers(B::NC);
    part->x = numbers(B::NX);
    part->scales = numbers(B::NX + B::NY);
    part->sums = numbers(Score::NX);
    part->guards = numbers(B::N_GUARDS);
    part->record_x = (double *)calloc(B::NX * points, sizeof(double));
    part->record_y = (double *)calloc(B::NY * points, sizeof(double));
    part->failed = (int64_t *)calloc(LANES, sizeof(int64_t));
    part->cause = (int64_t *)calloc(LANES, sizeof(int64_t));
}}

template <class B, class C, class... Rest>
static void make(List<B, C, Rest...>, Part *part, const double *const *p, int64_t points) {{
    make(List<B>(), part, p, points);
    make(List<C, Rest...>(), part + 1, p + 1, points);
}}

typedef List<{types}> All;

// the arguments are the step, then the numbers of each part
int main(int argc, char **argv) {{
    double *values = (double *)calloc(argc, sizeof(double));
    for (int i = 1; i < argc; ++i) values[i] = strtod(argv[i], 0);
    const char *const names[] = {{{quoted}}};
    const int sizes[] = {{{sizes}}}, n = (int)(sizeof sizes / sizeof *sizes) - 1;  // the front's come last
    const double *p[n + 1], *next = values + 2;
    for (int i = 0; i <= n; ++i) {{ p[i] = next; next += sizes[i]; }}
    const int64_t on[2] = {{20, 40}}, off[2] = {{30, 60}};
    uint64_t seeds[LANES];
    for (int l = 0; l < LANES; ++l) seeds[l] = l;
    Part *parts = (Part *)calloc(n, sizeof(Part));
    make(All(), parts, p, 51);
    FrontPart front = {{filled(Front::NP, p[n]), numbers(Front::NC), numbers(Near::NC)}};
    Runs runs = {{1, seeds, parts, &front, 1, numbers(N_NOISE)}};
    Batch batch = {{values[1], 0, 500, 10, 100, 10, on, off, 1, &runs, 0, 0, 64}};
    hillobs_start(&batch);
    while (batch.k <= batch.steps) hillobs_advance(&batch, batch.k + 137);
    for (int i = 0; i < n; ++i) printf("%s %lld\\n", names[i], (long long)parts[i].failed[0]);
    return 0;
}}
"""


def sanitized_loop(drive: str) -> Loop:
    """The sanitizers take a minute for all observers: the paper's with each change, all of them in the long run."""
    return paper_loop(drive, NGUYEN2019, tuple(OBSERVERS[name] for name in PAPER) if drive == "virtual" else None)


def numbers_of(drive: str, given: dict[str, float]) -> dict[str, list[float]]:
    loop, table = sanitized_loop(drive), all_paths()
    numbers = {block.name: table.values(block, given) for block in loop.blocks}
    whose = loop.observers[0]
    numbers["front"] = [numbers[whose.name][list(whose.p).index(name)] for name in loop.bank.front.p]
    return numbers


def program(drive: str) -> str:
    numbers = numbers_of(drive, {})
    loop = sanitized_loop(drive)
    return export_loop(loop).text + MAIN.format(
        quoted=", ".join(f'"{name}"' for name in numbers),
        sizes=", ".join(str(len(values)) for values in numbers.values()),
        types=", ".join(f"Part_{block.name}" for block in loop.blocks),
    )


RUNS = {
    "virtual": [
        ({"noise.x1": 1e-3, "pulse1.amplitude": -0.5, "pulse2.amplitude": 0.5}, 5e-4, False),
        ({"high_gain.eps_h": 1e-5, "adaptive_sliding_mode.tau_a": 1e-6}, 0.01, True),
    ],
    "given": [({"noise.force": 1e-2, "activation1.offset": 0.0}, 5e-4, False)],
}


@pytest.mark.parametrize("drive", ["virtual", pytest.param("given", marks=pytest.mark.chaos)])
def test_the_sanitizers_are_silent(drive: str, tmp_path: Path) -> None:
    """Also while observers fail: in one run two of them overflow."""
    # all lanes in one drive, one run at a time in the other
    width = ["-DHILLOBS_SCALAR"] if drive == "given" else []
    # gcc takes half the time for checks that are calls
    calls = ["--param", "asan-instrumentation-with-call-threshold=0"] if find_compiler().kind == "gcc" else []
    built = compile_text(program(drive), tmp_path, *SANITIZE, *width, *calls)
    if "cannot find" in built.stderr:
        pytest.skip("this compiler has no sanitizer libraries")
    assert built.returncode == 0, built.stderr[-2000:]
    # what is left at exit is the arrays of MAIN
    environment = {**os.environ, "ASAN_OPTIONS": "detect_leaks=0"}
    for given, step, failed in RUNS[drive]:
        numbers = [value for values in numbers_of(drive, given).values() for value in values]
        arguments = [tmp_path / "loop", *map(repr, (step, *numbers))]
        ran = subprocess.run(arguments, env=environment, capture_output=True, text=True, check=False)
        assert ran.returncode == 0, ran.stderr[-3000:]
        state = dict(line.split() for line in ran.stdout.splitlines())
        assert (state["high_gain"] != "-1") is failed
        assert state["sliding_mode"] == "-1"


EXTREME = """
int main() {
    const double extreme[] = {NAN, -NAN, INFINITY, -INFINITY, 1e308, -1e308, 710, -746, 5e-324};
    double sum = 0;
    for (double x : extreme) sum += lane(exp(V(x)), 0) + lane(sin(V(x)), 0) + lane(cos(V(x)), 0);
    return sum == sum;
}
"""


@pytest.mark.parametrize("width", [[], ["-DHILLOBS_SCALAR"]], ids=["lanes", "scalar"])
def test_the_sanitizers_are_silent_on_numbers_without_an_end(width: list[str], tmp_path: Path) -> None:
    """An observer that fails gives them to exp."""
    built = compile_text(SOURCES["functions"]().text + EXTREME, tmp_path, *SANITIZE, *width)
    if "cannot find" in built.stderr:
        pytest.skip("this compiler has no sanitizer libraries")
    assert built.returncode == 0, built.stderr[-2000:]
    ran = subprocess.run([tmp_path / "loop"], capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stderr) == (0, "")


def test_only_our_own_names_are_exported() -> None:
    path = compile_loop(paper_loop("virtual", NGUYEN2019)).path
    listed = subprocess.run(["nm", "-D", "--defined-only", str(path)], capture_output=True, text=True, check=True)
    names = [line.split()[-1] for line in listed.stdout.splitlines()]
    assert names
    assert all(name.startswith("hillobs_") for name in names if not name.startswith("_"))
    undefined = subprocess.run(["nm", "-D", "--undefined-only", str(path)], capture_output=True, text=True, check=True)
    assert not {"malloc", "free", "printf", "fopen", "system"} & {
        w.split()[-1].split("@")[0] for w in undefined.stdout.splitlines()
    }
