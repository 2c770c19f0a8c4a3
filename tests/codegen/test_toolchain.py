"""Finding and running a compiler: ten-line scripts stand for bad ones, and every failure is one sentence."""

import ctypes
import os
import re
import shutil
import signal
import stat
import subprocess
import sys
import textwrap
import threading
from pathlib import Path

import numpy as np
import pytest

from hillobs.codegen import cache, toolchain
from hillobs.codegen.cache import BuildError
from hillobs.codegen.held import HeldSignals
from hillobs.codegen.library import open_library
from hillobs.codegen.toolchain import build, compile_library, find_compiler

EXPORT = 'extern "C" __attribute__((visibility("default")))'
SOURCE = f"""
#include <math.h>
{EXPORT} int hillobs_abi(void) {{ return HILLOBS_ABI; }}
{EXPORT} double twice(double x) {{ return 2.0 * x + 0.0 * exp(x); }}
"""
DESCRIPTION = {"names": ["x"], "size": 1}


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


def twice(path, x=4.0):
    library = open_library(path)
    library.twice.restype, library.twice.argtypes = ctypes.c_double, [ctypes.c_double]
    return library.twice(x)


def fails(words):
    """The build must end with a sentence that holds `words`, and leave nothing in the cache but the lock."""
    with pytest.raises(BuildError) as caught:
        build(SOURCE, DESCRIPTION)
    assert re.search(words, str(caught.value)), str(caught.value)
    left = list(cache.cache_folder().iterdir())
    assert [path.suffix for path in left] in ([], [".lock"])
    return str(caught.value)


def python(program, *arguments, env=None, **options):
    """A process of its own that has SOURCE, build and twice."""
    head = f"""
        import ctypes, os, resource, signal, sys
        from hillobs.codegen import cache, toolchain
        SOURCE, DESCRIPTION = {SOURCE!r}, {DESCRIPTION!r}
        def twice(path):
            function = ctypes.CDLL(str(path)).twice
            function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double]
            return function(4.0)
    """
    command = [sys.executable, "-c", textwrap.dedent(head) + textwrap.dedent(program), *map(str, arguments)]
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"} | (env or {})
    return subprocess.Popen(
        command,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


def finish(process):
    out, err = process.communicate(timeout=120)
    return process.returncode, out, err


BUILD = "path = toolchain.build(SOURCE, DESCRIPTION); print(path, len(toolchain.compiled), twice(path))"


# what works


def test_a_library_is_built_once_and_runs(folder):
    path = build(SOURCE, DESCRIPTION)
    done = len(toolchain.compiled)
    assert twice(path) == 8.0
    assert build(SOURCE, DESCRIPTION) == path
    assert len(toolchain.compiled) == done
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
    assert sorted(path.suffix for path in folder.iterdir()) == [".json", ".lock", ".so"]


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


# the key


def test_the_key_changes_with_all_that_determines_the_bytes(monkeypatch):
    def key(source=SOURCE, description=DESCRIPTION):
        monkeypatch.setattr(cache, "obtain", lambda key, *rest, **more: key)
        return build(source, description)

    keys = [key(), key(SOURCE + "\n"), key(description={"names": ["y"], "size": 1})]
    changes = [
        (toolchain, "FLAGS", (*toolchain.FLAGS, "-g")),
        (toolchain, "ABI", 99),
        (toolchain, "_package_version", lambda name: "9.9"),
        (toolchain, "_cpu", lambda *entries: ["avx1024"]),
        (toolchain.platform, "machine", lambda: "riscv64"),
        (toolchain.platform, "libc_ver", lambda: ("glibc", "9.9")),
        (toolchain, "find_compiler", lambda: other_compiler),
    ]
    other_compiler = toolchain.Compiler(("g++",), "gcc", "g++ 99", Path(sys.executable))
    for module, name, value in changes:
        with monkeypatch.context() as patch:
            patch.setattr(module, name, value)
            keys.append(key())
    with monkeypatch.context() as patch:
        patch.setenv("CPATH", "/elsewhere")
        keys.append(key())
    assert len(set(keys)) == len(keys) == 11
    assert key() == keys[0]


def test_the_key_does_not_change_with_path_user_and_hash_seed(tmp_path):
    build(SOURCE, DESCRIPTION)
    name = next(cache.cache_folder().glob("*.json")).name
    for seed in ("0", "1"):
        env = {
            "PYTHONHASHSEED": seed,
            "HILLOBS_CACHE": str(tmp_path / seed),
            "USER": seed,
            "LC_ALL": "de_DE.UTF-8",
            "TZ": "Asia/Tokyo",
        }
        assert finish(python(BUILD, env=env, cwd="/"))[0] == 0
        assert (tmp_path / seed / name).exists()


def test_another_compiler_under_the_same_name_builds_again(fake):
    fake('exec $real "$@"', version="1.0")
    first = build(SOURCE, DESCRIPTION)
    fake('exec $real "$@"', version="1.1")
    second = build(SOURCE, DESCRIPTION)
    fake('exec  $real "$@"', version="1.1")
    third = build(SOURCE, DESCRIPTION)
    assert len({path.name[:64] for path in (first, second, third)}) == 3


# finding a compiler


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


# bad compilers


def test_a_compile_error_is_told_in_the_words_of_the_compiler():
    with pytest.raises(BuildError) as caught:
        build("int main( { }", DESCRIPTION)
    assert re.search(r"^The compiler failed with exit code 1: .*g\+\+|clang", str(caught.value))
    assert "hillobs.cpp:1" in str(caught.value)


def test_of_many_lines_the_last_twenty_are_told(fake):
    fake("seq 1 500; exit 3")
    message = fails("failed with exit code 3")
    assert message.splitlines()[1:] == [str(number) for number in range(481, 501)]


def test_what_a_terminal_would_obey_is_spelled_out(fake):
    fake(r"printf '\033[2J\007\r[bold]a\tb\n\xff\302\233m\342\200\256x'; exit 1")
    message = fails("exit code 1")
    assert all(c.isprintable() or c == "\n" for c in message)
    assert r"\x1b[2J\x07" in message


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("exit 0", "reported success but wrote no library"),
        ("touch hillobs.so", "what it wrote is not a library"),
        ("echo done > hillobs.so", "what it wrote is not a library"),
        ("mkdir hillobs.so", "Is a directory"),
        ("ln -s /nowhere hillobs.so", "wrote no library"),
        ('$real "$@" && truncate -s 60 hillobs.so', "not a library"),
        ('$real "$@" && truncate -s 3000 hillobs.so', "only part of a library"),
        ('$real "$@" && truncate -s -1 hillobs.so', "only part of a library"),
        ('$real "$@"; rm -rf "$PWD"; exit 0', "wrote no library|Nothing can be compiled"),
        ("kill -SEGV $$", "was ended by SIGSEGV"),
        ("kill -KILL $$", "was ended by SIGKILL"),
        ("exit 255", "failed with exit code 255"),
        ("exec 1>&- 2>&-; exit 7", "failed with exit code 7"),
    ],
)
def test_a_bad_compiler(fake, text, words):
    fake(text)
    message = fails(words)
    assert message.startswith(("The compiler ", "Nothing can be compiled in "))
    fake('exec $real "$@"')
    assert twice(build(SOURCE, DESCRIPTION)) == 8.0


def test_a_compiler_that_waits_for_input_gets_none(fake):
    fake('read line; exec $real "$@"')
    assert twice(build(SOURCE, DESCRIPTION)) == 8.0


def test_a_compiler_whose_child_keeps_the_output_open(fake, tmp_path):
    pipe = alive(tmp_path)
    fake(f'exec 9>{tmp_path}/alive; sleep 60 & exec $real "$@"')
    assert twice(build(SOURCE, DESCRIPTION)) == 8.0
    assert os.read(pipe, 1) == b""
    os.close(pipe)


def alive(tmp_path):
    """A pipe whose end is reached only when all that opened `alive` for writing have gone."""
    os.mkfifo(tmp_path / "alive")
    pipe = os.open(tmp_path / "alive", os.O_RDONLY | os.O_NONBLOCK)
    os.set_blocking(pipe, True)
    return pipe


@pytest.mark.parametrize("ignore", ["", "trap '' TERM INT HUP;"], ids=["plain", "stubborn"])
def test_a_compiler_that_hangs_is_ended_with_all_its_children(fake, tmp_path, monkeypatch, ignore):
    pipe = alive(tmp_path)
    fake(f"{ignore} exec 9>{tmp_path}/alive; (sleep 60 & sleep 60 & wait) & echo working; wait")
    monkeypatch.setenv("HILLOBS_COMPILE_TIMEOUT", "1")
    fails("took more than 1 s")
    assert os.read(pipe, 1) == b""
    os.close(pipe)


def test_a_compiler_that_hangs_on_its_version(tmp_path, monkeypatch):
    (tmp_path / "hangs").write_text("#!/bin/sh\nsleep 60\n")
    (tmp_path / "hangs").chmod(0o755)
    monkeypatch.setenv("CXX", str(tmp_path / "hangs"))
    monkeypatch.setenv("HILLOBS_COMPILE_TIMEOUT", "0.5")
    fails("took more than 0.5 s")


@pytest.mark.parametrize("text", ["0", "-1", "nan", "inf", "1e3", "1_000", "٣", "five", "1" * 12])
def test_a_timeout_that_is_no_number_of_seconds(monkeypatch, text):
    monkeypatch.setenv("HILLOBS_COMPILE_TIMEOUT", text)
    fails("^HILLOBS_COMPILE_TIMEOUT must be a number of seconds above 0")


@pytest.mark.parametrize("line", ["yes 'error: no'", "cat /dev/zero"], ids=["lines", "one line"])
def test_a_compiler_that_prints_a_gigabyte(fake, line):
    fake(f"{line} | head -c 1000000000; exit 1")
    program = """
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        try:
            toolchain.build(SOURCE, DESCRIPTION)
        except cache.BuildError as error:
            print(len(str(error)), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)
    """
    code, out, err = finish(python(program))
    assert code == 0, err
    length, memory = map(int, out.split())
    assert length < 5 * toolchain.KEPT_BYTES
    assert memory < 50_000 if sys.platform == "linux" else 50_000_000


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL], ids=lambda n: n.name)
def test_when_we_are_ended_while_compiling(fake, tmp_path, folder, number):
    """Ctrl-C ends the compiler too; after kill -9 the next start sweeps what is left."""
    os.mkfifo(tmp_path / "alive")
    fake(f'exec 9>{tmp_path}/alive; [ -e {tmp_path}/go ] || {{ echo $$ >&9; sleep 60; }}; exec $real "$@"')
    process = python(BUILD)
    with open(tmp_path / "alive") as pipe:  # opens when the compiler runs
        compiler = int(pipe.readline())
        process.send_signal(number)
        process.communicate(timeout=60)
        if number == signal.SIGKILL:
            assert process.returncode == -9
            os.killpg(compiler, signal.SIGKILL)
        assert pipe.read() == ""  # the end: nobody is left
    assert [path.suffix for path in folder.iterdir() if number == signal.SIGINT] in ([], [".lock"])
    (tmp_path / "alive").unlink()
    (tmp_path / "go").touch()
    assert twice(build(SOURCE, DESCRIPTION)) == 8.0
    assert sorted(path.suffix for path in folder.iterdir()) == [".json", ".lock", ".so"]


@pytest.mark.parametrize("limit", [0, 100, 1000, 4096, 10_000])
def test_a_full_disk_is_a_sentence(folder, limit):
    program = f"""
        resource.setrlimit(resource.RLIMIT_FSIZE, ({limit}, resource.RLIM_INFINITY))
        try:
            {BUILD}
        except cache.BuildError as error:
            print(error)
            sys.exit(1)
    """
    code, out, err = finish(python(program))
    assert (code, err) == (1, "")
    assert str(folder) in out or "SIGXFSZ" in out or "exit code" in out
    assert twice(build(SOURCE, DESCRIPTION)) == 8.0


def test_no_processes_left_is_a_sentence(monkeypatch):
    def refuse(*args, **options):
        raise BlockingIOError(11, "Resource temporarily unavailable")

    monkeypatch.setattr(subprocess, "Popen", refuse)
    fails("Resource temporarily unavailable|No C")


# many at once


@pytest.mark.parametrize("count", [2, 8])
def test_processes_that_start_cold_at_once(folder, count):
    processes = [python(BUILD) for _ in range(count)]
    results = [finish(process) for process in processes]
    assert {(code, err) for code, _, err in results} == {(0, "")}
    assert {out.split()[0] for _, out, _ in results} == {str(next(folder.glob("*.so")))}
    assert sum(int(out.split()[1]) for _, out, _ in results) == 1
    assert {out.split()[2] for _, out, _ in results} == {"8.0"}
    assert sorted(path.suffix for path in folder.iterdir()) == [".json", ".lock", ".so"]


def test_threads_that_start_cold_at_once(folder):
    done, paths = len(toolchain.compiled), []
    threads = [threading.Thread(target=lambda: paths.append(build(SOURCE, DESCRIPTION))) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(paths) == 8
    assert len(set(paths)) == 1
    assert len(toolchain.compiled) == done + 1
    assert sorted(path.suffix for path in folder.iterdir()) == [".json", ".lock", ".so"]


def test_threads_without_a_cache_share_one_private_folder(folder):
    folder.write_text("a file")
    program = """
        import threading, warnings
        warnings.simplefilter("always")
        paths = []
        run = lambda: paths.append(toolchain.build(SOURCE, DESCRIPTION))
        threads = [threading.Thread(target=run) for _ in range(8)]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
        print(len(paths), len(set(paths)), len(toolchain.compiled), twice(paths[0]), paths[0].parent)
    """
    code, out, err = finish(python(program))
    assert code == 0
    assert out.split()[:4] == ["8", "1", "1", "8.0"]
    assert err.count("CacheWarning") == 1
    assert not Path(out.split()[4]).exists()


# names of folders

NAMES = ["a space", "a'quote", 'a"quote', "a;touch marker", "$(touch marker)", "`touch marker`", "&& touch marker"]
NAMES += ["| tee marker", "new\nline", "-rf", "--version", "[x]", "{a,b}", "*", "%s%n", "\\", "é", "e\u0301", "筋肉"]
NAMES += ["\x1b[2J", "@file", "a:b", "a,b", "#", "~", "n" * 240]


@pytest.mark.parametrize("name", NAMES)
def test_a_cache_folder_called(tmp_path, monkeypatch, name):
    (tmp_path / "current").mkdir()
    monkeypatch.chdir(tmp_path / "current")
    monkeypatch.setenv("HILLOBS_CACHE", str(tmp_path / "[" / name))
    path = build(SOURCE, DESCRIPTION)
    assert path.parent == tmp_path / "[" / name
    assert twice(path) == 8.0
    assert sorted(os.listdir(tmp_path)) == ["[", "current"]
    assert os.listdir(tmp_path / "current") == []


def test_bytes_that_are_no_text_in_the_name_of_a_folder(tmp_path, monkeypatch):
    folder = os.fsdecode(os.fsencode(tmp_path) + b"/\xff\xfe")
    try:
        os.mkdir(folder, 0o700)
    except OSError:
        pytest.skip("this file system takes text only")
    monkeypatch.setenv("HILLOBS_CACHE", folder)
    assert twice(build(SOURCE, DESCRIPTION)) == 8.0


@pytest.mark.parametrize("umask", [0o000, 0o077, 0o777], ids="{:03o}".format)
def test_the_umask_does_not_matter(folder, umask):
    code, _, err = finish(python(f"os.umask({umask}); {BUILD}"))
    assert code == 0, err
    assert {stat.S_IMODE(path.stat().st_mode) for path in folder.iterdir()} == {0o600}
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700


# loading


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


def test_a_signal_while_a_process_starts_waits_for_it() -> None:
    """Once, at the release, and with the handler that was there."""
    came: list[int] = []
    before = signal.signal(signal.SIGHUP, lambda number, frame: came.append(number))
    try:
        held = HeldSignals()
        os.kill(os.getpid(), signal.SIGHUP)
        assert came == []
        held.release()
        assert came == [signal.SIGHUP]
        held.release()
        os.kill(os.getpid(), signal.SIGHUP)
        assert came == [signal.SIGHUP] * 2
    finally:
        signal.signal(signal.SIGHUP, before)
