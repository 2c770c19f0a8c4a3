"""Where the cache is, and when that place is not used."""

import os
import stat
from pathlib import Path

import pytest

from entries import CONTENT, Maker, names, obtain
from hillobs.codegen import cache
from hillobs.codegen.cache import BuildError, CacheWarning


def test_a_relative_cache_folder_is_refused(monkeypatch):
    monkeypatch.setenv("HILLOBS_CACHE", "build/cache")
    with pytest.raises(BuildError, match=r"HILLOBS_CACHE must be an absolute path, not 'build/cache'\."):
        cache.cache_folder()


def test_a_checkout_keeps_its_cache_in_build(tmp_path, monkeypatch):
    monkeypatch.delenv("HILLOBS_CACHE", raising=False)
    monkeypatch.setattr(cache, "__file__", str(tmp_path / "codegen" / "cache.py"))
    (tmp_path / "build").mkdir()
    (tmp_path / "pyproject.toml").write_text('[project]\nname = "hillobs"\n')
    assert cache.cache_folder() == tmp_path / "build" / "cache"
    assert stat.S_IMODE((tmp_path / "build" / "cache").stat().st_mode) == 0o700


@pytest.mark.parametrize("text", [None, b'name = "theirs"', b"\xff\xfe"], ids=["missing", "theirs", "no text"])
def test_an_installed_copy_uses_the_cache_folder_of_the_user(tmp_path, monkeypatch, text):
    monkeypatch.delenv("HILLOBS_CACHE", raising=False)
    monkeypatch.setattr(cache, "__file__", str(tmp_path / "site" / "codegen" / "cache.py"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / "site" / "build").mkdir(parents=True)
    if text is not None:
        (tmp_path / "site" / "pyproject.toml").write_bytes(text)
    folder = cache.cache_folder()
    assert folder == cache.platformdirs.user_cache_path("hillobs")
    assert folder.is_relative_to(tmp_path)


@pytest.mark.parametrize("given", ["relative/path", "~"])
def test_a_user_cache_that_is_no_absolute_path_is_not_used(tmp_path, monkeypatch, given):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("HILLOBS_CACHE", raising=False)
    monkeypatch.setattr(cache, "_private", {})
    monkeypatch.setattr(cache, "__file__", str(tmp_path / "site" / "codegen" / "cache.py"))
    monkeypatch.setattr(cache.platformdirs, "user_cache_path", lambda name: Path(given))
    with pytest.warns(CacheWarning, match="is not an absolute path"):
        folder = cache.cache_folder()
    assert folder.is_absolute()
    assert names(tmp_path) == []


def spoil(path, how):
    """Make of `path` a cache that must not be used."""
    if how == "file":
        path.write_text("mine")
    elif how == "dangling link":
        path.symlink_to(path.parent / "nowhere")
    elif how == "link":
        (path.parent / "victim").mkdir(mode=0o700)
        path.symlink_to(path.parent / "victim")
    elif how == "below a file":
        path.parent.mkdir()
        path.parent.rmdir()
        path.parent.write_text("mine")
    else:
        path.mkdir()
        path.chmod({"group-writable": 0o770, "world-writable": 0o1777}.get(how, 0o700))
        if how == "foreign":
            os.chown(path, 65534, -1)


SPOILS = ["file", "dangling link", "link", "below a file", "group-writable", "world-writable", "foreign"]


@pytest.mark.parametrize("how", SPOILS)
def test_a_cache_that_cannot_be_trusted_is_not_used(tmp_path, monkeypatch, how):
    if how == "foreign" and os.geteuid() != 0:
        pytest.skip("only root can give a folder away")
    path = tmp_path / "below" / "cache" if how == "below a file" else tmp_path / "cache"
    spoil(path, how)
    monkeypatch.setenv("HILLOBS_CACHE", str(path))
    monkeypatch.setattr(cache, "_private", {})
    before = sorted(tmp_path.rglob("*"))
    maker = Maker()
    with pytest.warns(CacheWarning) as said:
        found = obtain(maker)
    assert len(said) == 1
    assert str(path) in str(said[0].message)
    assert found.read_bytes() == CONTENT
    assert not found.is_relative_to(tmp_path / "cache")
    assert stat.S_IMODE(found.parent.stat().st_mode) == 0o700
    assert obtain(maker) == found  # the same folder, and no second warning
    assert maker.calls == 1
    assert sorted(tmp_path.rglob("*")) == before
    if how != "below a file":
        assert cache.describe_cache()["problem"]
        with pytest.raises(BuildError, match="not cleaned"):
            cache.clean_cache()
