"""What lies among the parts and is none: odd names, folders, pipes, links, a terabyte, a lock that cannot be taken."""

import errno
import fcntl
import os
import shutil
from pathlib import Path

import pytest

from hillobs.studies.files.errors import ResultError
from unfinished_sweeps import Sweep


@pytest.mark.parametrize(
    "name",
    ["0.part", "1.part", "+1.part", "²²²²²²²².part", "٠٠٠٠٠٠٠١.part", "000000001.part", "99999999.part", "x.part"],
)
def test_files_with_odd_names_are_no_parts(unfinished: Sweep, untouched: bytes, name: str) -> None:
    shutil.copy(unfinished.whole()[1], unfinished.parts / name)
    unfinished.run()
    assert sorted(unfinished.computed) == [3, 4]
    assert unfinished.out.read_bytes() == untouched
    assert os.listdir(unfinished.folder) == ["x.nc"]


@pytest.mark.parametrize("name", ["plan.json", "00000001.part"])
def test_a_file_of_a_terabyte_is_not_read(unfinished: Sweep, name: str) -> None:
    os.truncate(unfinished.parts / name, 10**12)
    with pytest.raises(ResultError, match=rf"{name} cannot be read: it is larger than 1,000,000,000 bytes"):
        unfinished.run()


@pytest.mark.parametrize("name", ["plan.json", "00000001.part", "lock"])
@pytest.mark.parametrize("what", ["folder", "pipe", "dangling link"])
def test_something_else_under_the_name_of_a_file(unfinished: Sweep, untouched: bytes, name: str, what: str) -> None:
    path = unfinished.parts / name
    path.unlink()
    if what == "folder":
        path.mkdir()
    elif what == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to(path.parent / "nowhere" / "at all")
    if what == "dangling link" and name != "lock":  # there is no such file
        unfinished.run()
        assert unfinished.out.read_bytes() == untouched
        assert os.listdir(unfinished.folder) == ["x.nc"]
    else:
        with pytest.raises(ResultError, match=r"x\.nc\.parts\S* cannot be (read|written to): "):
            unfinished.run()
        assert not unfinished.out.exists()


@pytest.mark.parametrize("what", ["file", "link", "dangling link"])
def test_something_else_under_the_name_of_the_parts(tmp_path: Path, untouched: bytes, what: str) -> None:
    here = Sweep(tmp_path)
    if what == "file":
        here.parts.write_text("mine")
    else:
        here.parts.symlink_to("elsewhere")
        if what == "link":
            (tmp_path / "elsewhere").mkdir()
    if what == "link":
        here.run()
        assert here.out.read_bytes() == untouched
    else:
        with pytest.raises(ResultError, match=r"x\.nc\.parts cannot be written to: "):
            here.run()
        assert not here.out.exists()


def test_a_lock_that_cannot_be_taken_is_no_other_process(unfinished: Sweep, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_locks(*_: object) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", no_locks)
    with pytest.raises(ResultError, match=r"x\.nc\.parts cannot be written to: No locks available"):
        unfinished.run()
