"""A sweep that is killed, stopped or left without a disk: one sentence, nothing partial, and the same result later.

Faults strike at counted calls, in forks of one process; `make chaos` strikes at all of them, in the system too.
"""

import os
import re
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from forks import COMMAND, PARTS
from survival import ERRORS, STOPPED, SWEEP, assert_a_signal_ends_both, assert_goes_on, assert_survives, kept, writes

# kill −9


def test_killed_at_each_call_of_a_write_it_goes_on(forks, untouched, tmp_path, record_property) -> None:
    """Each call of a part's write in the first, the middle or the last part, and each of the result's."""
    whole, calls = untouched
    *parts, result = writes(calls)
    assert len(parts) == PARTS
    assert min(map(len, parts)) >= 5  # open, write, wait for the disk, rename, wait for the folder
    places = [part[i] for n, part in enumerate(parts) for i in range(n, len(part), PARTS)] + result
    for at in places:
        assert assert_survives(forks, tmp_path / str(at), whole, fault="SIGKILL", at=at).code == -signal.SIGKILL
    record_property("faults", len(places))


def test_killed_again_and_again_it_ends(forks, untouched, tmp_path) -> None:
    """Every start computes one part, keeps it, and is killed while the next is written."""
    for done in range(PARTS - 1):
        killed = forks.run(tmp_path, *SWEEP, fault="SIGKILL", near=f"{done + 1:08d}.part-")
        assert killed.code == -signal.SIGKILL
        assert kept(tmp_path) == list(range(done + 1))
        assert killed.computed[0] == done
    assert_goes_on(forks, tmp_path, untouched[0])


# signals


@pytest.mark.parametrize("first", range(6), ids="{} of 6".format)
def test_a_signal_ends_it_with_a_sentence(forks, untouched, tmp_path, first: int) -> None:
    """At the start, in the writing of each part and of the result, in the removal of the parts; also twice."""
    whole, calls = untouched
    name, twice = ("SIGINT", "SIGTERM", "SIGHUP")[first % 3], first >= 3
    seen = set()
    for at in range(2 + first * 6, len(calls) + 1, 36):
        done = assert_survives(forks, tmp_path / str(at), whole, fault=name, at=at, twice=twice)
        assert done.code == 128 + getattr(signal, name)
        seen.add(done.err)
    assert "hillobs: stopped; what is done is kept in x.nc.parts, the same command goes on\n" in seen <= STOPPED


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_a_signal_in_the_kernel_ends_it_at_once(forks, untouched, tmp_path, name: str) -> None:
    """Of the parts that wait, one may be begun before the main thread hears of it, no more."""
    done = assert_survives(forks, tmp_path / "here", untouched[0], fault=name, near="kernel")
    assert done.code == 128 + getattr(signal, name)
    assert len(done.computed) < PARTS


def test_a_signal_while_figures_are_drawn_leaves_the_result(forks, untouched, tmp_path) -> None:
    drawing = [word for word in SWEEP if word != "--no-figures"]
    done = forks.run(tmp_path, *drawing, fault="SIGTERM", near="x-curves")
    assert done.code == 128 + signal.SIGTERM
    assert done.err == "hillobs: stopped; the result is in x.nc, the same command draws it\n"
    assert os.listdir(tmp_path) == ["x.nc"]
    assert (tmp_path / "x.nc").read_bytes() == untouched[0]


def test_what_nohup_has_made_deaf_stays_so(forks, untouched, tmp_path) -> None:
    done = forks.run(tmp_path, *SWEEP, fault="SIGHUP", at=30, deaf=["SIGHUP"])
    assert (done.code, done.err) == (0, "")
    assert (tmp_path / "x.nc").read_bytes() == untouched[0]


@pytest.mark.parametrize("name", ["TERM"])
def test_a_signal_while_the_compiler_runs_ends_both(tmp_path: Path, name: str) -> None:
    assert_a_signal_ends_both(tmp_path, name)


# disks


FAULTS = [("ENOSPC", False), ("ENOSPC", True), ("EIO", False), ("EACCES", True)]


@pytest.mark.parametrize(("fault", "ever"), FAULTS)
def test_a_disk_that_fails_at_a_call(forks, untouched, tmp_path, fault: str, ever: bool) -> None:
    whole, calls = untouched
    said = []
    for at in range(1 + 3 * FAULTS.index((fault, ever)), len(calls) + 1, 14):
        done = assert_survives(forks, tmp_path / str(at), whole, fault=fault, at=at, ever=ever)
        assert done.code in (0, 2)
        assert bool(done.err) == (done.code == 2)
        if done.err:
            said.append(done.err)
            assert done.err.startswith("hillobs: ")
            assert ERRORS[fault] in done.err
            assert re.match(r"hillobs: (\.|x\.nc\S*) cannot be (written|read)", done.err)
    assert len(said) >= 2


@pytest.mark.parametrize("size", [0, 10, 50, 400, 2000, 6000])
def test_files_that_may_not_grow(forks, untouched, tmp_path, size: int) -> None:
    done = assert_survives(forks, tmp_path / "here", untouched[0], limits={"RLIMIT_FSIZE": size})
    assert done.code == 2
    assert "File too large" in done.err
    assert "x.nc" in done.err


def test_parts_that_are_removed_under_way(forks, untouched, tmp_path) -> None:
    done = assert_survives(forks, tmp_path / "here", untouched[0], fault="REMOVED", near="00000001.part-")
    assert done.code == 2
    assert "No such file or directory" in done.err
    assert "x.nc.parts" in done.err


# two at once


WAITING = """
import sys
from hillobs.studies.sweep import plan
from hillobs.studies.sweep.run import sweep

def wait(done, runs):
    print(done, flush=True)
    sys.stdin.readline()

plan.PART = 4
sweep("paper-noisy", {"high_gain.eps_h": [0.05, 0.1, 0.2]}, 4, "high_gain", {"duration": 0.05, "score.start": 0.01},
      quantities=["x2"], out="x.nc", workers=1, progress=wait)
"""


def test_the_second_of_two_is_refused_and_takes_over_when_the_first_is_killed(forks, untouched, tmp_path) -> None:
    pipe = subprocess.PIPE
    command = [sys.executable, "-c", WAITING]
    with subprocess.Popen(command, cwd=tmp_path, stdin=pipe, stdout=pipe, text=True) as first:
        assert first.stdout.readline() == "0\n"
        print(file=first.stdin, flush=True)
        assert first.stdout.readline() == "4\n"
        second = forks.run(tmp_path, *SWEEP)
        assert second.code == 2
        owner = f"process {first.pid} on {socket.gethostname()}"
        assert second.err == f"hillobs: x.nc is being computed by {owner}\n"
        assert second.computed == []
        first.kill()
    assert kept(tmp_path) == [0]
    assert_goes_on(forks, tmp_path, untouched[0])


def test_who_comes_while_another_ends_reads_its_result(forks, untouched, tmp_path) -> None:
    """The folder is removed between the opening of its lock and the locking."""
    assert_survives(forks, tmp_path / "here", untouched[0], fault="REMOVED", near="flock")


# memory, descriptors, streams


# of every quantity
ALL = ["sweep", "paper-noisy", "--observer", "high_gain"]


def test_too_little_memory_is_a_sentence_with_the_size(forks, tmp_path) -> None:
    done = forks.run(tmp_path, *ALL, "--seeds", "2000000", limits={"RLIMIT_AS": forks.memory() + 300_000_000})
    assert done.code == 2
    assert done.err.startswith("hillobs: there is not enough memory. Unable to allocate ")
    assert "MiB" in done.err
    assert len(done.err.splitlines()) == 1


def test_a_result_beyond_every_file_is_refused(forks, tmp_path) -> None:
    done = forks.run(tmp_path, *ALL, "--seeds", "20000000")
    assert done.code == 2
    assert done.err == "hillobs: 20,000,000 runs make a result of 6 GB; cut the sweep into several\n"


def test_a_sweep_with_few_descriptors_and_threads(forks, untouched, tmp_path) -> None:
    done = forks.run(tmp_path, *SWEEP, limits={"RLIMIT_NOFILE": 20})
    assert (done.code, done.err) == (0, "")
    assert (tmp_path / "x.nc").read_bytes() == untouched[0]


def test_a_reader_that_leaves_is_no_failure(forks, untouched, tmp_path) -> None:
    done = forks.run(tmp_path, *SWEEP, stdout="broken")
    assert (done.code, done.err) == (141, "")
    assert (tmp_path / "x.nc").read_bytes() == untouched[0]


def test_a_full_standard_output_is_a_sentence(forks, untouched, tmp_path) -> None:
    done = forks.run(tmp_path, *SWEEP, stdout="/dev/full")
    assert (done.code, done.err) == (2, "hillobs: standard output: No space left on device\n")
    assert (tmp_path / "x.nc").read_bytes() == untouched[0]


@pytest.mark.parametrize("stream", ["stdout", "stderr"])
def test_a_closed_stream_does_no_harm(forks, untouched, tmp_path, stream: str) -> None:
    done = forks.run(tmp_path, *SWEEP, **{stream: "closed"})
    assert (done.code, done.err) == (0, "")
    assert (tmp_path / "x.nc").read_bytes() == untouched[0]


def test_a_current_folder_that_is_gone(forks, tmp_path) -> None:
    (tmp_path / "here").mkdir()
    assert forks.run(tmp_path / "here", *COMMAND, gone=True).code == 0
    (tmp_path / "here").mkdir()
    done = forks.run(tmp_path / "here", *SWEEP, gone=True)
    assert done.code == 2
    assert done.err == "hillobs: . cannot be written to: No such file or directory\n"


def test_a_reader_of_the_old_result_keeps_it(forks, untouched, tmp_path) -> None:
    forks.run(tmp_path, *SWEEP)
    with open(tmp_path / "x.nc", "rb") as reader:
        (tmp_path / "x.nc").unlink()
        forks.run(tmp_path, *SWEEP, "--set", "plant.m=1.1")
        assert reader.read() == untouched[0] != (tmp_path / "x.nc").read_bytes()
