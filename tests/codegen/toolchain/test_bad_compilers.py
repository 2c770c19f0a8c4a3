"""Ten-line scripts stand for bad compilers; every failure is one sentence."""

import os
import re
import signal
import subprocess
import sys
import time

import pytest

from compilers import BUILD, DESCRIPTION, SOURCE, fails, finish, python, twice
from hillobs.codegen import toolchain
from hillobs.codegen.cache import BuildError
from hillobs.codegen.toolchain import build, find_compiler


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
        ("mkdir hillobs.so", "what it wrote is no file"),
        ("ln -s /dev/zero hillobs.so", "what it wrote is no file"),
        ("ln -s /dev/null hillobs.so", "what it wrote is no file"),
        ("ln -s hillobs.so hillobs.so", "Too many levels of symbolic links"),
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


def test_a_pipe_where_the_library_should_be_is_not_waited_for(fake):
    fake("mkfifo hillobs.so")
    told = "try: toolchain.build(SOURCE, DESCRIPTION)\nexcept cache.BuildError as error: print(error)"
    code, out, err = finish(python(told))
    assert (code, err) == (0, "")
    assert out.startswith("The compiler reported success but what it wrote is no file: ")


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
    assert sorted(path.suffix for path in folder.iterdir()) == [".cpp", ".json", ".lock", ".so"]


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


def test_a_source_that_cannot_be_written_is_told_with_the_folder_that_stays(folder):
    program = f"""
        resource.setrlimit(resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))
        try:
            {BUILD}
        except cache.BuildError as error:
            print(error)
    """
    assert finish(python(program)) == (0, f"Nothing can be compiled in {folder}: File too large.\n", "")


def test_no_processes_left_is_a_sentence(monkeypatch):
    def refuse(*args, **options):
        raise BlockingIOError(11, "Resource temporarily unavailable")

    monkeypatch.setattr(subprocess, "Popen", refuse)
    fails("Resource temporarily unavailable|No C")


def test_what_a_compiler_says_at_its_very_end_is_heard(tmp_path, monkeypatch):
    """It may write and end between two looks at it; an empty version would make another key."""
    (tmp_path / "slow").write_text("#!/bin/sh\nsleep 0.05\necho at the very end\n")
    (tmp_path / "slow").chmod(0o755)
    monkeypatch.setenv("CXX", str(tmp_path / "slow"))
    poll = subprocess.Popen.poll

    def late(process):
        time.sleep(0.1)
        return poll(process)

    monkeypatch.setattr(subprocess.Popen, "poll", late)
    assert find_compiler().version == "at the very end"
