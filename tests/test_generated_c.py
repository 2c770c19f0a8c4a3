"""The C++ as a compiler sees it: no warning, no report of the sanitizers, its own exports only."""

import os
import subprocess
from pathlib import Path

import pytest

from hillobs.codegen.export import Source, export_loop
from hillobs.codegen.library import Library
from hillobs.codegen.toolchain import find_compiler
from hillobs.model.curves import NGUYEN2019
from hillobs.model.pair import DRIVES
from hillobs.studies.loops import full_table, paper_loop

SANITIZE = ("-O0", "-g", "-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")


def compile_text(text: str, folder: Path, *flags: str) -> subprocess.CompletedProcess[str]:
    (folder / "loop.cpp").write_text(text)
    command = [*find_compiler().command, "-std=c++17", "-DHILLOBS_ABI=1", *flags, "loop.cpp", "-o", "loop"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def source(drive: str) -> Source:
    return export_loop(paper_loop(drive, NGUYEN2019))


@pytest.mark.parametrize("drive", DRIVES)
def test_it_compiles_without_a_warning(drive: str, tmp_path: Path) -> None:
    done = compile_text(source(drive).text, tmp_path, "-fsyntax-only", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
    assert done.returncode == 0, done.stderr[-2000:]


# every array has exactly the size that the description promises, so that the sanitizer sees one number too many
MAIN = """
#include <stdio.h>
#include <stdlib.h>

static double *array(int n) {{ return (double *)calloc(n ? n : 1, sizeof(double)); }}

int main(void) {{
    {parameters}
    const double *p[] = {{{names}}};
    const int n = (int)(sizeof p / sizeof *p) - 1;
    const int64_t points = 51, on[2] = {{20, 40}}, off[2] = {{30, 60}};
    Part *parts = (Part *)calloc(n, sizeof(Part));
    for (int i = 0; i < n; ++i) {{
        const Block &b = BLOCKS[i];
        parts[i].block = i;
        parts[i].p = p[i];
        parts[i].x = array(b.nx);
        parts[i].y = array(b.ny);
        parts[i].guards = array(b.n_guards);
        parts[i].score = array(SCORE.nx);
        parts[i].record_x = array(b.nx * points);
        parts[i].record_y = array(b.ny * points);
    }}
    Run run = {{{step}, 7, 0, 500, 10, 100, 10, on, off, p[n], parts, n, array(N_NOISE + N_PULSES + 2)}};
    hillobs_start(&run);
    while (run.k <= run.steps) hillobs_advance(&run, run.k + 137);
    for (int i = 0; i < n; ++i) printf("%s %lld\\n", BLOCKS[i].name, (long long)parts[i].failed);
    return 0;
}}
"""


def program(drive: str, given: dict[str, float], step: float) -> str:
    loop, table = paper_loop(drive, NGUYEN2019), full_table()
    numbers = {block.name: table.values(block, given) for block in loop.blocks}
    arrays = [
        f"static const double p_{name}[] = {{{', '.join(map(repr, v)) or '0.0'}}};" for name, v in numbers.items()
    ]
    names = ", ".join(f"p_{name}" for name in numbers)
    return source(drive).text + MAIN.format(parameters="\n    ".join(arrays), names=names, step=step)


@pytest.mark.parametrize(
    ("drive", "given", "step", "failed"),
    [
        ("virtual", {"noise.x1": 1e-3, "pulse1.amplitude": -0.5, "pulse2.amplitude": 0.5}, 5e-4, False),
        ("given", {"noise.force": 1e-2, "activation1.offset": 0.0}, 5e-4, False),
        ("virtual", {"high_gain.eps_h": 1e-5, "adaptive_sliding_mode.tau_a": 1e-6}, 0.01, True),
    ],
)
def test_the_sanitizers_are_silent(
    drive: str, given: dict[str, float], step: float, failed: bool, tmp_path: Path
) -> None:
    """Also while observers fail; the third run makes two of them overflow."""
    built = compile_text(program(drive, given, step), tmp_path, *SANITIZE)
    if "cannot find" in built.stderr:
        pytest.skip("this compiler has no sanitizer libraries")
    assert built.returncode == 0, built.stderr[-2000:]
    # what is left at exit is the arrays of MAIN
    environment = {**os.environ, "ASAN_OPTIONS": "detect_leaks=0"}
    ran = subprocess.run([tmp_path / "loop"], env=environment, capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr[-3000:]
    state = dict(line.split() for line in ran.stdout.splitlines())
    assert (state["high_gain"] != "-1") is failed
    assert state["sliding_mode"] == "-1"


def test_only_our_own_names_are_exported() -> None:
    library = Library(source("virtual"))
    listed = subprocess.run(
        ["nm", "-D", "--defined-only", str(library.path)], capture_output=True, text=True, check=True
    )
    names = [line.split()[-1] for line in listed.stdout.splitlines()]
    assert names
    assert all(name.startswith("hillobs_") for name in names if not name.startswith("_"))
    undefined = subprocess.run(
        ["nm", "-D", "--undefined-only", str(library.path)], capture_output=True, text=True, check=True
    )
    assert not {"malloc", "free", "printf", "fopen", "system"} & {
        w.split()[-1].split("@")[0] for w in undefined.stdout.splitlines()
    }
