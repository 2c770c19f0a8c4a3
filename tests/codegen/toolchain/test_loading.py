"""What the loader refuses is a sentence."""

import ctypes
import sys
from pathlib import Path

import pytest

from compilers import DESCRIPTION, EXPORT, SOURCE, twice
from hillobs.codegen import cache
from hillobs.codegen.cache import BuildError
from hillobs.codegen.shared_library import open_library
from hillobs.codegen.toolchain import build, compile_library, find_compiler


def header_of(machine):
    """Change the machine in an ELF header, as a library of another architecture has it."""

    def change(content):
        return content[:18] + machine.to_bytes(2, sys.byteorder) + content[20:]

    return change


LOADER = {
    "text": (lambda content: b"not a library\n", "cannot be loaded"),
    "empty": (lambda content: b"", "cannot be loaded"),
    "another architecture": (header_of(243), "cannot be loaded"),
    "the header alone": (lambda content: content[:64], "cannot be loaded"),
}


@pytest.mark.skipif(sys.platform != "linux", reason="ELF")
@pytest.mark.parametrize(("change", "words"), LOADER.values(), ids=LOADER)
def test_what_the_loader_refuses_is_a_sentence(tmp_path, change, words):
    path = tmp_path / "x.so"
    path.write_bytes(change(build(SOURCE, DESCRIPTION).read_bytes()))
    with pytest.raises(BuildError, match=words):
        open_library(path)


@pytest.mark.skipif(sys.platform != "linux", reason="ELF")
def test_a_library_of_another_architecture_in_the_cache_is_built_again():
    path = build(SOURCE, DESCRIPTION)
    path.write_bytes(header_of(243)(path.read_bytes()))
    with pytest.warns(cache.CacheWarning, match="built again"):
        assert twice(build(SOURCE, DESCRIPTION)) == 8.0


def test_a_library_is_loaded_by_its_absolute_path_only():
    with pytest.raises(BuildError, match="absolute path"):
        open_library(Path("libm.so.6"))


def test_a_library_without_our_number_is_refused(tmp_path):
    path = compile_library(f"{EXPORT} int other(void) {{ return 1; }}\n", tmp_path, find_compiler())
    with pytest.raises(BuildError, match="exports no hillobs_abi"):
        open_library(path)


def test_a_library_with_another_number_is_refused(tmp_path):
    path = compile_library(f"{EXPORT} int hillobs_abi(void) {{ return 99; }}\n", tmp_path, find_compiler())
    with pytest.raises(BuildError, match=f"interface 99, but this hillobs speaks {cache.ABI}"):
        open_library(path)


def test_a_library_that_misses_a_function_is_refused(tmp_path):
    source = f'extern "C" int nowhere(void);\n{EXPORT} int hillobs_abi(void) {{ return nowhere(); }}\n'
    with pytest.raises(BuildError, match="nowhere"):
        open_library(compile_library(source, tmp_path, find_compiler()))


def test_a_folder_mounted_noexec_is_explained(tmp_path, monkeypatch):
    def refuse(path):
        raise OSError(f"{path}: failed to map segment from shared object")

    monkeypatch.setattr(ctypes, "CDLL", refuse)
    with pytest.raises(BuildError, match=f"{tmp_path} is mounted noexec; name another folder in HILLOBS_CACHE"):
        open_library(tmp_path / "x.so")


def test_only_what_is_exported_can_be_seen():
    library = open_library(build(SOURCE + "double hidden(double x) { return x; }\n", DESCRIPTION))
    assert not hasattr(library, "hidden")
