"""What is built runs, is built once, and is written to the cache alone."""

import stat

import numpy as np
import pytest

from compilers import BUILD, DESCRIPTION, SOURCE, finish, python, twice
from hillobs.codegen import toolchain
from hillobs.codegen.cache import BuildError
from hillobs.codegen.shared_library import open_library
from hillobs.codegen.toolchain import build, compile_library, find_compiler


def test_a_library_is_built_once_and_runs(folder, compiled):
    path = build(SOURCE, DESCRIPTION)
    assert twice(path) == 8.0
    assert build(SOURCE, DESCRIPTION) == path
    assert len(compiled) == 1
    assert path.parent == folder
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_a_second_process_compiles_nothing(folder):
    path = build(SOURCE, DESCRIPTION)
    code, out, err = finish(python(BUILD))
    assert (code, err) == (0, "")
    assert out.split() == [str(path), "0", "8.0"]


def test_a_build_writes_into_the_cache_and_nowhere_else(tmp_path, folder):
    places = [tmp_path / name for name in ("home", "current", "temporary")]
    for place in places:
        place.mkdir()
    env = {"HOME": str(places[0]), "TMPDIR": str(places[2])}
    assert finish(python(BUILD, cwd=places[1], env=env))[0] == 0
    assert [list(place.iterdir()) for place in places] == [[], [], []]
    assert sorted(path.suffix for path in folder.iterdir()) == [".cpp", ".json", ".lock", ".so"]


def test_the_source_compiles_without_a_warning(tmp_path):
    compile_library(SOURCE, tmp_path, find_compiler(), flags=["-Werror", "-pedantic"])


def test_flags_of_the_caller_come_last(tmp_path):
    with pytest.raises(BuildError, match="asked for"):
        compile_library("#ifdef PLEASE\n#error asked for\n#endif\n", tmp_path, find_compiler(), flags=["-DPLEASE"])


def test_numbers_that_are_almost_zero_stay_after_loading():
    before = np.float64(1e-310) / 2
    path = build(SOURCE, DESCRIPTION)
    open_library(path)
    assert before == np.float64(1e-310) / 2 != 0
    assert twice(path, 5e-324) == 1e-323
    assert not {"-ffast-math", "-Ofast", "-funsafe-math-optimizations"} & set(toolchain.FLAGS)


def test_a_result_does_not_depend_on_the_temporary_folder(monkeypatch):
    monkeypatch.setenv("TMPDIR", "/nowhere")
    assert twice(build(SOURCE, DESCRIPTION)) == 8.0
