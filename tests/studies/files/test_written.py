"""The list of what hillobs has written into a folder: what it replaces, and what cannot be slipped into it."""

import os
from pathlib import Path

import pytest

from hillobs.studies.files.errors import ResultError
from hillobs.studies.files.reading import read_whole, remembered_reading
from hillobs.studies.files.writing import refuse_overwriting, remove_ours, write_whole
from hillobs.studies.files.written import list_name


def test_only_what_was_written_is_replaced(tmp_path: Path) -> None:
    write_whole(tmp_path / "x", b"ours")
    write_whole(tmp_path / "x", b"ours again")
    write_whole(tmp_path / "x", b"ours")
    (tmp_path / "y").write_bytes(b"ours")
    with pytest.raises(ResultError, match=r"y is there already, and not as hillobs wrote it"):
        write_whole(tmp_path / "y", b"new")
    assert (tmp_path / "y").read_bytes() == b"ours"


def test_the_same_again_does_not_lengthen_the_list(tmp_path: Path) -> None:
    write_whole(tmp_path / "x", b"ours")
    before = (tmp_path / list_name()).read_bytes()
    write_whole(tmp_path / "x", b"ours")
    assert (tmp_path / list_name()).read_bytes() == before


def test_a_line_that_a_full_disk_has_cut_spoils_no_other(tmp_path: Path) -> None:
    write_whole(tmp_path / "x", b"ours")
    with (tmp_path / list_name()).open("ab") as file:
        file.write(b"\n0123456789abcdef")
    write_whole(tmp_path / "y", b"ours")
    refuse_overwriting([tmp_path / "x", tmp_path / "y"])


def test_a_folder_that_is_moved_takes_its_list_along(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    write_whole(tmp_path / "a" / "x", b"ours")
    (tmp_path / "a").rename(tmp_path / "b")
    write_whole(tmp_path / "b" / "x", b"new")


@pytest.mark.parametrize("name", ["two\nlines", "\x1b[31mred", "é", os.fsdecode(b"b\xff"), "a  b", "x" * 250])
def test_any_name_is_known_again(name: str, tmp_path: Path) -> None:
    write_whole(tmp_path / name, b"ours")
    write_whole(tmp_path / name, b"new")
    (tmp_path / name).write_bytes(b"changed")
    with pytest.raises(ResultError, match="not as hillobs wrote it"):
        refuse_overwriting([tmp_path / name])


@pytest.mark.parametrize("how", ["link", "hard link", "pipe", "folder"])
def test_a_list_that_is_something_else_is_refused_and_not_written_to(how: str, tmp_path: Path) -> None:
    path, victim = tmp_path / list_name(), tmp_path / "victim"
    victim.write_bytes(b"mine")
    if how == "link":
        path.symlink_to(victim)
    elif how == "hard link":
        os.link(victim, path)
    elif how == "pipe":
        os.mkfifo(path)
    else:
        path.mkdir()
    with pytest.raises(ResultError, match=r"x cannot be written|was not made by hillobs"):
        write_whole(tmp_path / "x", b"ours")
    assert victim.read_bytes() == b"mine"
    assert not (tmp_path / "x").exists()


def test_what_is_removed_was_written_and_is_not_read(tmp_path: Path) -> None:
    write_whole(tmp_path / "x", b"ours")
    (tmp_path / "y").write_bytes(b"mine")
    (tmp_path / "z").symlink_to("x")
    with remembered_reading():
        read_whole(tmp_path / "z", 100)
        for name in ("x", "y", "z", "nothing"):
            remove_ours(tmp_path / name)
    assert sorted(os.listdir(tmp_path)) == [list_name(), "x", "y", "z"]
    remove_ours(tmp_path / "x")
    assert sorted(os.listdir(tmp_path)) == [list_name(), "y", "z"]


def test_what_takes_the_place_of_a_folder_under_way_gets_nothing(tmp_path: Path) -> None:
    """The folder is moved, and a link to another lies in its place, while the file is written."""
    (tmp_path / "here").mkdir()
    (tmp_path / "victim").mkdir()

    def swapping():
        yield b"first"
        (tmp_path / "here").rename(tmp_path / "moved")
        (tmp_path / "here").symlink_to("victim")
        yield b"second"

    from hillobs.studies.files.writing import write_pieces

    write_pieces(tmp_path / "here" / "x", swapping())
    assert os.listdir(tmp_path / "victim") == []
    assert (tmp_path / "moved" / "x").read_bytes() == b"firstsecond"
