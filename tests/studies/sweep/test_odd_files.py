"""What lies among the parts and is none: odd names, folders, pipes, links, a terabyte, a lock that cannot be taken."""

import errno
import fcntl
import os
import shutil
from pathlib import Path

import pytest

from hillobs.studies.files.datasets.netcdf import sealed
from hillobs.studies.files.errors import ResultError
from hillobs.studies.sweep import parts
from unfinished_sweeps import Sweep

ODD_NAMES = [
    "0.part",
    "1.part",
    "+1.part",
    "²²²²²²²².part",
    "٠٠٠٠٠٠٠١.part",
    "000000001.part",
    "x.part",
    "notes.txt",
    ".git",
    ".x.nc-history",
    ".x.nc-0123456789abcde",
    ".plan.json-draft",
]


def snapshot(folder: Path) -> dict[str, object]:
    """Path → kind, rights and content of all below a folder."""
    return {
        str(path.relative_to(folder)): (path.lstat().st_mode, path.read_bytes() if path.is_file() else "")
        for path in sorted(folder.rglob("*"))
    }


@pytest.mark.parametrize("name", ODD_NAMES)
def test_a_folder_with_a_name_that_is_not_ours_is_left_alone(unfinished: Sweep, name: str) -> None:
    shutil.copy(unfinished.whole()[1], unfinished.parts / name)
    before = snapshot(unfinished.folder)
    with pytest.raises(ResultError) as refused:
        unfinished.run()
    assert f"x.nc.parts cannot be written to: it holds {name}, which hillobs has not written there" in str(
        refused.value
    )
    assert (unfinished.computed, snapshot(unfinished.folder)) == ([], before)


@pytest.mark.parametrize("name", ["plan.json", "00000000.part"])
@pytest.mark.parametrize("content", [b'{"plan": "mine"}', sealed(b"\x89HDF and so on")], ids=["a plan", "a result"])
def test_a_folder_without_a_part_of_a_sweep_is_left_alone(tmp_path: Path, name: str, content: bytes) -> None:
    """A user's own plan, or a result, by chance under our name."""
    here = Sweep(tmp_path)
    here.parts.mkdir()
    (here.parts / name).write_bytes(content)
    before = snapshot(tmp_path)
    with pytest.raises(ResultError, match="holds no part of a sweep that bears the seal of hillobs; move it away"):
        here.run()
    assert (here.computed, snapshot(tmp_path)) == ([], before)


@pytest.mark.parametrize("name", [".x.nc-history", ".plan.json-draft", ".00000001.part-mine"])
def test_a_file_alone_that_almost_has_a_name_of_ours_is_left_alone(tmp_path: Path, name: str) -> None:
    """No plan, no part, no lock, as after a start that was killed at once: the name is all there is to judge by."""
    here = Sweep(tmp_path)
    here.parts.mkdir()
    (here.parts / name).write_text("mine")
    before = snapshot(tmp_path)
    with pytest.raises(ResultError, match=f"it holds {name}, which hillobs has not written there"):
        here.run()
    assert (here.computed, snapshot(tmp_path)) == ([], before)


def test_a_part_beyond_the_last_is_not_read(unfinished: Sweep, untouched: bytes) -> None:
    shutil.copy(unfinished.whole()[1], unfinished.parts / "99999999.part")
    unfinished.run()
    assert sorted(unfinished.computed) == [3, 4]
    assert unfinished.out.read_bytes() == untouched
    assert os.listdir(unfinished.folder) == ["x.nc"]


@pytest.mark.parametrize("name", ["plan.json", "00000001.part"])
def test_a_file_of_a_terabyte_is_not_read(unfinished: Sweep, name: str) -> None:
    os.truncate(unfinished.parts / name, 10**12)
    with pytest.raises(ResultError, match=rf"{name} cannot be read: it has 1,000,000,000,\d+ bytes, more than"):
        unfinished.run()


@pytest.mark.parametrize("name", ["plan.json", "00000001.part", "lock"])
@pytest.mark.parametrize("what", ["folder", "pipe", "dangling link", "link"])
def test_something_else_under_the_name_of_a_file(unfinished: Sweep, name: str, what: str) -> None:
    """A link is not followed, even to what would be a whole part: its target stays as it is."""
    path, victim = unfinished.parts / name, unfinished.folder / "victim"
    path.rename(victim)
    if what == "folder":
        path.mkdir()
    elif what == "pipe":
        os.mkfifo(path)
    else:
        path.symlink_to(victim if what == "link" else path.parent / "nowhere" / "at all")
    before = snapshot(unfinished.folder)
    with pytest.raises(ResultError, match=rf"x\.nc\.parts cannot be written to: it holds {name}, which is no file"):
        unfinished.run()
    assert snapshot(unfinished.folder) == before


@pytest.mark.parametrize("what", ["file", "link", "dangling link", "loop", "pipe", "group", "world"])
def test_something_else_under_the_name_of_the_parts(tmp_path: Path, what: str) -> None:
    """Above all a link to a home: its dot files look like what a killed process leaves."""
    here, victim = Sweep(tmp_path), tmp_path / "victim"
    victim.mkdir()
    for name in (".profile", ".x.nc-history", "lock", "00000000.part"):
        (victim / name).write_text("mine")
    if what == "file":
        here.parts.write_text("mine")
    elif what == "pipe":
        os.mkfifo(here.parts)
    elif what in ("group", "world"):
        here.parts.mkdir()
        here.parts.chmod(0o770 if what == "group" else 0o777)
    else:
        here.parts.symlink_to({"link": "victim", "dangling link": "nowhere", "loop": here.parts.name}[what])
    before = snapshot(tmp_path)
    with pytest.raises(ResultError, match=r"x\.nc\.parts cannot be written to: it (is|can) .*; move it away, or name"):
        here.run()
    assert (here.computed, snapshot(tmp_path)) == ([], before)


@pytest.mark.parametrize("when", ["locked", "part", "finished", "removed"])
def test_what_takes_the_place_of_the_parts_under_way_is_not_touched(
    tmp_path: Path, untouched: bytes, monkeypatch: pytest.MonkeyPatch, when: str
) -> None:
    """The folder is moved away, and a link to another lies in its place: between each check and each use."""
    here, victim = Sweep(tmp_path), tmp_path / "victim"
    victim.mkdir()
    for name in (".profile", ".x.nc-history", "lock", "plan.json", "00000000.part"):
        (victim / name).write_text("mine")
    before = snapshot(victim)
    place, name = {
        "locked": (parts, "take"),
        "part": (parts.Parts, "write"),
        "finished": (parts.Parts, "finish"),
        "removed": (parts.Parts, "remove"),
    }[when]
    whole = getattr(place, name)

    def swapped(*given: object) -> object:
        if not here.parts.is_symlink():
            here.parts.rename(tmp_path / "moved")
            here.parts.symlink_to("victim")
        return whole(*given)

    monkeypatch.setattr(place, name, swapped)
    here.run()
    assert snapshot(victim) == before
    assert here.out.read_bytes() == untouched
    assert os.listdir(tmp_path / "moved") == []


def test_what_is_put_among_the_parts_under_way_stays(unfinished: Sweep, untouched: bytes) -> None:
    def leave(*given: object) -> object:
        (unfinished.parts / "notes.txt").write_text("mine")
        return finish(*given)

    finish = parts.Parts.finish
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parts.Parts, "finish", leave)
        unfinished.run()
    assert unfinished.out.read_bytes() == untouched
    assert {path.name: path.read_text() for path in unfinished.parts.iterdir()} == {"notes.txt": "mine"}
    unfinished.run()
    assert os.listdir(unfinished.parts) == ["notes.txt"]


def test_a_result_that_comes_under_way_is_not_written_over(unfinished: Sweep, untouched: bytes) -> None:
    def leave(*given: object) -> object:
        unfinished.out.write_text("mine")
        return finish(*given)

    finish = parts.Parts.finish
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(parts.Parts, "finish", leave)
        with pytest.raises(ResultError, match=r"x\.nc has come to be under way; move it away, or name another --out"):
            unfinished.run()
    assert unfinished.out.read_text() == "mine"
    unfinished.out.unlink()
    unfinished.run()
    assert unfinished.computed == []
    assert unfinished.out.read_bytes() == untouched


def test_a_lock_that_cannot_be_taken_is_no_other_process(unfinished: Sweep, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_locks(*_: object) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(fcntl, "flock", no_locks)
    with pytest.raises(ResultError, match=r"x\.nc\.parts cannot be written to: No locks available"):
        unfinished.run()
