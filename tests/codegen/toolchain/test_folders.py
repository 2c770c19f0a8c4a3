"""The cache may have any name, and any umask."""

import os
import stat

import pytest

from compilers import BUILD, DESCRIPTION, SOURCE, finish, python, twice
from hillobs.codegen.toolchain import build

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
