"""Which compiler is taken, and what is said where there is none."""

import os
import re
import shutil
import textwrap
from pathlib import Path

import pytest

from compilers import BUILD, DESCRIPTION, SOURCE, fails, finish, python, twice
from hillobs.codegen import toolchain
from hillobs.codegen.toolchain import build, find_compiler


def test_a_compiler_has_answered(real):
    compiler = find_compiler()
    assert compiler.kind in ("gcc", "clang", "zig")
    assert compiler.path.is_absolute()
    assert Path(compiler.command[0]).is_absolute()
    assert re.search(r"\d+\.\d+", compiler.version)


def test_cxx_goes_before_cc(fake, monkeypatch):
    path = fake("exit 1", version="mine")
    assert find_compiler().version == "mine"
    monkeypatch.setenv("CC", os.environ.pop("CXX"))
    assert find_compiler().path == path
    monkeypatch.setenv("CXX", "  ")
    assert find_compiler().path == path


@pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no gcc here")
def test_a_command_with_arguments(monkeypatch):
    monkeypatch.setenv("CC", "gcc -O1")
    assert find_compiler().command[1:] == ("-O1",)
    assert twice(build(SOURCE, DESCRIPTION)) == 8.0


def test_a_compiler_in_a_folder_with_a_space(fake, tmp_path, monkeypatch):
    (tmp_path / "my 'tools'").mkdir()
    path = fake('exec $real "$@"', name="my 'tools'/c++ mine")
    monkeypatch.setenv("CXX", f'"{path}" -O1')
    assert twice(build(SOURCE, DESCRIPTION)) == 8.0


@pytest.mark.parametrize(
    "command",
    [
        "g++; touch {}",
        "g++ && touch {}",
        "g++ `touch {}`",
        "g++ $(touch {})",
        "g++ | tee {}",
        "g++ > {}",
        "'g++; touch {}'",
    ],
)
@pytest.mark.parametrize("variable", ["CXX", "CC"])
def test_no_shell_reads_the_command(tmp_path, monkeypatch, variable, command):
    marker = tmp_path / "marker"
    monkeypatch.setenv(variable, command.format(marker))
    fails(f"{variable}|The compiler failed")
    assert not marker.exists()


def test_quotes_that_do_not_close(monkeypatch):
    monkeypatch.setenv("CXX", 'g++ "')
    fails(r"^CXX='g\+\+ \"' is no working compiler: No closing quotation")


@pytest.mark.parametrize("command", ["no-such-compiler", "/no/such/compiler", "/", "/etc/passwd"])
def test_a_compiler_that_is_not_there(monkeypatch, command):
    monkeypatch.setenv("CXX", command)
    fails(
        r"^CXX='.*' is no working compiler: There is no program .*apt install g\+\+.*pip install 'hillobs\[compiler\]'"
    )


def test_no_compiler_at_all(monkeypatch):
    monkeypatch.setenv("PATH", "/nowhere")
    monkeypatch.setattr(toolchain.importlib.util, "find_spec", lambda name: None)
    fails(r"^No C\+\+ compiler was found\. .*apt install g\+\+.*pip install 'hillobs\[compiler\]'")


def test_a_compiler_that_only_pretends_is_passed_over(tmp_path, monkeypatch, real):
    for name, text in (("g++", "#!/bin/sh\nexit 1\n"), ("clang++", f'#!/bin/sh\nexec {real} "$@"\n')):
        (tmp_path / name).write_text(text)
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    assert find_compiler().path == tmp_path / "clang++"


def test_a_script_without_an_interpreter(fake):
    fake("exit 0", interpreter="/no/such/shell")
    fails("cannot be run: No such file or directory")


WHEEL = """
    import os, sys
    arguments = [word for word in sys.argv[2:] if word != "-nostdlib++"]
    assert sys.argv[1] == "c++" and "-nostdlib++" in sys.argv
    open(os.path.join(os.environ["ZIG_GLOBAL_CACHE_DIR"] + ".log"), "w").close()
    assert os.path.isdir(os.path.dirname(os.environ["ZIG_LOCAL_CACHE_DIR"]))
    os.execv({real!r}, [{real!r}, *arguments])
"""


def test_the_wheel_is_the_last_resort(tmp_path, monkeypatch, folder):
    wheel = tmp_path / "site" / "ziglang"
    wheel.mkdir(parents=True)
    (wheel / "__init__.py").touch()
    (wheel / "zig").write_bytes(b"zig")
    (wheel / "__main__.py").write_text(textwrap.dedent(WHEEL.format(real=find_compiler().command[0])))
    program = f"toolchain.shutil.which = lambda name: None\n{BUILD}\nprint(toolchain.find_compiler().kind)"
    code, out, err = finish(python(program, env={"PYTHONPATH": str(wheel.parent)}, cwd=tmp_path))
    assert code == 0, out + err
    assert out.split()[1:] == ["1", "8.0", "zig"]
    assert (folder / "hillobs-zig.log").exists()
