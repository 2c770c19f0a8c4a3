"""Locks die with their owner; what is left over is removed, what is not ours stays."""

import fcntl
import os
from pathlib import Path

import pytest

from entries import CONTENT, KEY, OTHER, Maker, failing, names, obtain, order
from hillobs.codegen import cache
from hillobs.codegen.cache import BuildError, CacheWarning
from hillobs.codegen.system import locks


def test_a_lock_that_is_never_released_ends_in_a_private_folder(folder, holder):
    with pytest.warns(CacheWarning, match="does not release") as said:
        path = obtain(Maker(), key=OTHER, patience=0.1)
    assert len(said) == 1
    assert path.read_bytes() == CONTENT
    assert path.parent != folder


def test_a_lock_dies_with_its_owner(folder, holder):
    holder.kill()
    assert obtain(Maker(), key=OTHER).parent == folder


def test_who_waited_for_the_lock_makes_nothing(folder, holder):
    maker = Maker()

    def publish_then_let_go(path, patience=0):
        with cache._scratch(folder, OTHER) as scratch:
            cache._publish(folder, scratch, order(OTHER), CONTENT)
        holder.kill()
        holder.wait()
        return original(path, patience)

    original = locks.wait_for
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(locks, "wait_for", publish_then_let_go)
        obtain(maker, key=OTHER)
    assert maker.calls == 0


def test_a_scratch_folder_without_an_owner_is_swept(folder, holder):
    old, held = folder / f"{KEY}-old.tmp", folder / f"{OTHER}-held.tmp"
    for path in (old, held):
        path.mkdir()
        (path / "half.so").write_bytes(b"half")
        os.utime(path, (0, 0))
    obtain(Maker())
    assert not old.exists()
    assert (held / "half.so").exists()


def test_cleaning_removes_what_is_ours_and_nothing_else(folder, holder):
    for name in ("notes.txt", "x.so", f"{KEY}.txt", "hillobs.toml"):
        (folder / name).write_text("mine")
    (folder / f"{KEY}-left.tmp").mkdir()
    (folder / cache.ZIG_FOLDER).mkdir()
    removed = cache.clean_cache()
    assert len(removed) == 5
    assert not any(path.exists() for path in removed)
    assert names(folder) == sorted([f"{OTHER}.lock", "notes.txt", "x.so", f"{KEY}.txt", "hillobs.toml"])
    assert cache.clean_cache() == []


def test_cleaning_nothing_makes_nothing(tmp_path, monkeypatch):
    monkeypatch.setenv("HILLOBS_CACHE", str(tmp_path / "cache"))
    assert cache.clean_cache() == []
    assert cache.describe_cache() == {"folder": str(tmp_path / "cache"), "problem": "", "libraries": 0, "bytes": 0}
    assert names(tmp_path) == []


def test_a_clean_between_opening_and_locking_is_noticed(folder, monkeypatch):
    flock, lock = fcntl.flock, folder / f"{OTHER}.lock"

    def cleaned(handle, operation):
        flock(handle, operation)
        if cleanings:
            cleanings.pop().unlink()

    cleanings = [lock]
    monkeypatch.setattr(fcntl, "flock", cleaned)
    handle = locks.wait_for(lock, patience=30)
    assert os.path.samestat(os.fstat(handle), lock.stat())
    os.close(handle)


def test_the_cache_is_described(folder):
    assert cache.describe_cache() == {"folder": str(folder), "problem": "", "libraries": 1, "bytes": len(CONTENT)}


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="descriptors are counted in /proc")
def test_no_descriptor_is_left_open(folder, library):
    before = len(os.listdir("/proc/self/fd"))
    for size in (0, 10):
        os.truncate(library, size)
        with pytest.warns(CacheWarning):
            obtain(Maker())
    with pytest.raises(BuildError):
        obtain(failing, key=OTHER)
    cache.clean_cache()
    assert len(os.listdir("/proc/self/fd")) == before
