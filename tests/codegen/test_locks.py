"""A lock file has one holder at a time; it is never a link, and never a file that is gone."""

import os
import stat
from pathlib import Path

import pytest

from hillobs.codegen.system.locks import locked, take, wait_for


@pytest.fixture
def path(tmp_path):
    return tmp_path / "lock"


def test_a_second_holder_is_refused_until_the_first_lets_go(path):
    first = take(path)
    with pytest.raises(BlockingIOError):
        take(path)
    with pytest.raises(TimeoutError, match="does not release"):
        wait_for(path, patience=0)
    os.close(first)
    with locked(path, patience=0), pytest.raises(BlockingIOError):
        take(path)
    os.close(take(path))


def test_a_lock_file_is_for_us_alone_whatever_the_umask(path):
    before = os.umask(0o777)
    try:
        os.close(take(path))
    finally:
        os.umask(before)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def test_a_link_is_not_followed(path, tmp_path):
    victim = tmp_path / "victim"
    victim.write_text("mine")
    path.symlink_to(victim)
    with pytest.raises(OSError, match="symbolic link"):
        take(path)
    assert victim.read_text() == "mine"


def test_without_a_folder_there_is_no_lock(path):
    with pytest.raises(FileNotFoundError):
        take(path / "lock")


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="descriptors are counted in /proc")
def test_a_refused_lock_leaves_no_descriptor_open(path):
    handle = take(path)
    before = len(os.listdir("/proc/self/fd"))
    with pytest.raises(BlockingIOError):
        take(path)
    assert len(os.listdir("/proc/self/fd")) == before
    os.close(handle)
