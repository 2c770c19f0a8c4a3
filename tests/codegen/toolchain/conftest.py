"""An empty cache, the compiler of the machine, and scripts of a few lines that stand for bad ones."""

import subprocess
import textwrap

import pytest

from hillobs.codegen import cache, toolchain
from hillobs.codegen.toolchain import find_compiler


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """An empty cache; the compiler of the machine, whatever CXX says outside."""
    monkeypatch.setenv("HILLOBS_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(cache, "_private", {})
    for name in ("CXX", "CC", "HILLOBS_COMPILE_TIMEOUT"):
        monkeypatch.delenv(name, raising=False)
    return tmp_path / "cache"


@pytest.fixture
def real():
    """The compiler of the machine, by an absolute path."""
    return find_compiler().command[0]


@pytest.fixture
def fake(tmp_path, monkeypatch, real):
    """Write a compiler that knows its version and otherwise does what its text says; CXX names it."""

    def write(text, version="fake 1.0", name="compiler", interpreter="/bin/sh"):
        path = tmp_path / name
        head = f'#!{interpreter}\ncase "$*" in *--version*) echo "{version}"; exit 0;; esac\nreal={real}\n'
        path.write_text(head + textwrap.dedent(text))
        path.chmod(0o755)
        monkeypatch.setenv("CXX", subprocess.list2cmdline([str(path)]))
        return path

    return write


@pytest.fixture
def compiled(monkeypatch):
    """The scratch folder of each compile from now on."""
    folders, compile_library = [], toolchain.compile_library

    def counting(source, folder, *rest, **options):
        folders.append(folder)
        return compile_library(source, folder, *rest, **options)

    monkeypatch.setattr(toolchain, "compile_library", counting)
    return folders
