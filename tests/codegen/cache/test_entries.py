"""An entry is made once, found again by its key, and for us alone."""

import os
import stat

import pytest

from entries import CONTENT, KEY, OTHER, SOURCE, Maker, names, obtain
from hillobs.codegen import cache
from hillobs.codegen.cache import BuildError


def test_an_entry_is_made_once_and_found_again(folder):
    maker = Maker()
    assert obtain(maker).read_bytes() == CONTENT
    assert maker.calls == 0
    assert len(names(folder)) == 4  # manifest, library, source, lock


def test_each_part_of_the_key_counts():
    parts = {"source": "s", "flags": ["-O2"], "version": "12", "size": 1, "cpu": ["x86_64", "avx2"]}
    keys = {cache.entry_key(parts)} | {cache.entry_key({**parts, name: "other"}) for name in parts}
    assert len(keys) == len(parts) + 1


def test_entries_do_not_disturb_each_other(folder):
    other = obtain(Maker(b"other"), key=OTHER)
    assert other.read_bytes() == b"other"
    assert obtain(Maker()).read_bytes() == CONTENT


def test_a_description_too_large_to_be_read_again_is_refused(folder):
    with pytest.raises(BuildError, match="description"):
        obtain(Maker(), key=OTHER, description={"names": ["x" * cache.MANIFEST_LIMIT]})
    assert not list(folder.glob(f"{OTHER}*.tmp"))


def test_files_are_for_us_alone(folder, library, manifest, source):
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert {stat.S_IMODE(path.stat().st_mode) for path in (library, manifest, source)} == {0o600}


@pytest.mark.parametrize("seconds", [0, 1, 4_102_444_800], ids=["1970", "1970+1", "2100"])
def test_times_of_files_mean_nothing(folder, seconds):
    for path in [*folder.iterdir(), folder]:
        os.utime(path, (seconds, seconds))
    maker = Maker()
    obtain(maker)
    assert maker.calls == 0


def test_the_source_is_kept_for_people_to_read(folder, source):
    assert source.read_bytes() == SOURCE
    obtain(Maker(), key=OTHER, source=b"// another\n")
    assert cache.kept_sources() == {source: "a test", folder / f"{OTHER}.cpp": "another"}
    os.utime(source, (0, 0))
    assert list(cache.kept_sources().values()) == ["another", "a test"]


def test_only_sources_of_ours_are_told_of(folder, source):
    for name in ("x.cpp", f"{KEY}.hpp"):
        (folder / name).write_text("// theirs\n")
    (folder / f"{OTHER}.cpp").symlink_to(source)
    assert list(cache.kept_sources()) == [source]
    source.chmod(0o622)
    assert cache.kept_sources() == {}
    folder.chmod(0o777)
    assert cache.kept_sources() == {}
