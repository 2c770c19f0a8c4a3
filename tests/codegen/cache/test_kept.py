"""What is kept beside libraries is what was written under its key, or nothing."""

import os
import stat

import pytest

from entries import CONTENT, KEY, OTHER, flip, names
from hillobs.codegen import cache
from hillobs.codegen.cache import CacheWarning


@pytest.fixture
def kept(folder):
    cache.remember(KEY, CONTENT)
    return folder / f"{KEY}.kept"


def test_what_is_kept_is_found_again(kept):
    assert cache.recall(KEY) == CONTENT
    assert cache.recall(OTHER) is None
    assert stat.S_IMODE(kept.stat().st_mode) == 0o600


@pytest.mark.parametrize("size", [0, 1, 63, 64, 65, 4096, len(CONTENT)])
def test_cut_short(kept, size):
    os.truncate(kept, size)
    assert cache.recall(KEY) is None


@pytest.mark.parametrize("bit", [0, 8 * 63, 8 * 64 + 1, 8 * 65, 8 * 5000 + 3])
def test_a_flipped_bit(kept, bit):
    flip(kept, bit)
    assert cache.recall(KEY) is None


def test_under_another_key(folder, kept):
    kept.rename(folder / f"{OTHER}.kept")
    assert cache.recall(OTHER) is None


@pytest.mark.parametrize("what", ["link", "dangling", "pipe", "folder", "writable", "foreign", "huge"])
def test_a_file_that_is_not_ours_alone_is_not_read(kept, tmp_path, what):
    if what == "writable":
        kept.chmod(0o620)
    elif what == "foreign":
        if os.geteuid() != 0:
            pytest.skip("only root can give a file away")
        os.chown(kept, 65534, -1)
    elif what == "huge":
        os.truncate(kept, 10**12)
    else:
        kept.rename(tmp_path / "away")
        if what == "pipe":
            os.mkfifo(kept)
        elif what == "folder":
            kept.mkdir()
        else:
            kept.symlink_to(tmp_path / ("away" if what == "link" else "nowhere"))
    assert cache.recall(KEY) is None
    cache.remember(KEY, CONTENT)
    # a folder is in the way until the cache is cleaned
    assert cache.recall(KEY) == (None if what == "folder" else CONTENT)
    assert not kept.is_symlink()
    assert not list(kept.parent.glob("*.tmp"))


def test_what_cannot_be_kept_is_not_missed(folder, holder, monkeypatch):
    cache.remember(OTHER, CONTENT)  # another process does the same
    assert cache.recall(OTHER) is None
    monkeypatch.setattr(cache, "write_new", lambda path, content: os.close(-1))
    cache.remember(KEY, CONTENT)
    assert cache.recall(KEY) is None
    assert not list(folder.glob("*.tmp"))


def test_an_untrusted_folder_keeps_nothing(tmp_path, monkeypatch):
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache").chmod(0o777)
    monkeypatch.setenv("HILLOBS_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(cache, "_private", {})
    with pytest.warns(CacheWarning):
        cache.remember(KEY, CONTENT)
    assert cache.recall(KEY) == CONTENT
    assert names(tmp_path / "cache") == []


def test_cleaning_removes_it(folder, kept):
    assert kept in cache.clean_cache()
    assert names(folder) == []
