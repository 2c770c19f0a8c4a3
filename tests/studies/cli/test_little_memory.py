"""Limits on memory: each ends with a sentence, none with a traceback or never."""

import resource
import subprocess
import sys

import pytest

from hillobs.codegen.system import room
from hillobs.studies.cli.shell import terminal
from hillobs.studies.files.errors import ScenarioError

MB = 1_000_000


@pytest.mark.skipif(sys.platform != "linux", reason="a limit on address space does nothing elsewhere")
@pytest.mark.parametrize("megabytes", [40, 80, 120, 160, 200, 240, 280, 290, 300, 320, 360, 380, 400, 480])
def test_a_process_with_too_little_memory_says_so(megabytes: int) -> None:
    """In this range libraries end the process themselves, seem not to be installed, or wait for ever."""
    command = [sys.executable, "-m", "hillobs", "simulate", "paper-clean", "--no-figures"]
    limit = (megabytes * MB, megabytes * MB)
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=False,
        timeout=60,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, limit),
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "hillobs: there is not enough memory: it takes 500 MB of address space\n"


@pytest.mark.parametrize(
    "error",
    [
        ImportError("No module named 'h5py'"),
        RuntimeError("std::bad_alloc"),
        SystemError("error return without exception set"),
    ],
    ids=lambda error: type(error).__name__,
)
def test_what_fails_for_want_of_memory_is_said_to(
    error: Exception, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(type(error)), terminal.user_errors():
        raise error
    monkeypatch.setattr(terminal, "has_room", lambda size: False)
    with pytest.raises(SystemExit) as end, terminal.user_errors():
        raise error
    assert end.value.code == 2
    assert capsys.readouterr().err == "hillobs: there is not enough memory\n"


def test_a_mistake_is_a_mistake_with_little_memory_too(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(terminal, "has_room", lambda size: False)
    with pytest.raises(SystemExit), terminal.user_errors():
        raise ScenarioError("plant.m must be above 0, not 0")
    assert capsys.readouterr().err == "hillobs: plant.m must be above 0, not 0\n"


def test_there_is_room_for_little_but_not_for_everything() -> None:
    assert room.has_room(1)
    assert room.has_room(MB)
    assert not room.has_room(2**60)
