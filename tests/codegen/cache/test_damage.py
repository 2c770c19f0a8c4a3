"""Damage is found before loading, said once and repaired."""

import hashlib
import json
import os
import random
import warnings

import pytest

from entries import CONTENT, DESCRIPTION, KEY, OTHER, SOURCE, Maker, assert_rebuilt, flip, names, obtain, order
from hillobs.codegen import cache
from hillobs.codegen.cache import BuildError, CacheWarning

CUTS = [0, 1, 63, 64, 4095, 4096, 4097, 8192, len(CONTENT) - 1]
FLIPS = random.Random(2).sample(range(8 * len(CONTENT)), 64)


@pytest.mark.parametrize("size", CUTS)
def test_a_library_cut_short(folder, library, size):
    os.truncate(library, size)
    assert_rebuilt(folder)


@pytest.mark.parametrize("bit", FLIPS)
def test_a_flipped_bit_in_a_library(folder, library, bit):
    flip(library, bit)
    assert_rebuilt(folder)


@pytest.mark.parametrize(
    "content",
    [bytes(9000), b"\n", b"#!/bin/sh\necho no\n", b"\x7fELF" + bytes(8996), CONTENT + b"\0", CONTENT[::-1]],
    ids=["zeros", "newline", "script", "empty ELF", "one byte more", "reversed"],
)
def test_something_else_under_the_name_of_a_library(folder, library, content):
    library.write_bytes(content)
    assert_rebuilt(folder)


def test_every_cut_of_a_manifest_is_found(folder, manifest):
    text = manifest.read_bytes()
    for size in range(len(text)):
        manifest.write_bytes(text[:size])
        with pytest.raises(cache._DamageError):
            cache.find(folder, order())
    assert_rebuilt(folder)


def test_every_flipped_bit_of_a_manifest_is_found(folder, manifest):
    text = bytearray(manifest.read_bytes())
    for bit in range(8 * len(text)):
        text[bit // 8] ^= 1 << bit % 8
        manifest.write_bytes(text)
        with pytest.raises(cache._DamageError):
            cache.find(folder, order())
        text[bit // 8] ^= 1 << bit % 8
    manifest.write_bytes(text)
    assert cache.find(folder, order())


def signed(manifest, **changes):
    """A manifest with other claims whose own hash is right again."""
    body = json.loads(manifest.read_bytes()) | changes
    del body["manifest_sha256"]
    text = json.dumps(body, separators=(",", ":"))
    return json.dumps(body | {"manifest_sha256": hashlib.sha256(text.encode()).hexdigest()}, separators=(",", ":"))


HASH = "0" * 64
TEXTS = {
    "empty": lambda m: b"",
    "zeros": lambda m: bytes(len(m.read_bytes())),
    "no object": lambda m: b"[1, 2]",
    "null": lambda m: b"null",
    "a duplicate key": lambda m: m.read_bytes().replace(b'{"abi":1', b'{"abi":1,"abi":1', 1),
    "a duplicate size": lambda m: m.read_bytes().replace(b'"description"', b'"size":1,"description"', 1),
    "NaN": lambda m: m.read_bytes().replace(b'"size":9000', b'"size":NaN'),
    "Infinity": lambda m: m.read_bytes().replace(b'"size":9000', b'"size":1e999'),
    "a number of 5,000 digits": lambda m: m.read_bytes().replace(b'"size":9000', b'"size":' + b"9" * 5000),
    "a negative size": lambda m: signed(m, size=-1).encode(),
    "a size of another type": lambda m: signed(m, size=9000.0).encode(),
    "a wrong size": lambda m: signed(m, size=8999).encode(),
    "a size beyond all memory": lambda m: signed(m, size=10**12 - 1).encode(),
    "a wrong hash": lambda m: signed(m, sha256=HASH, library=f"{KEY}-{HASH[:16]}.so").encode(),
    "a path as library": lambda m: signed(m, library="../../etc/passwd").encode(),
    "an absolute path as hash": lambda m: signed(m, sha256="/" * 64).encode(),
    "another ABI": lambda m: signed(m, abi=cache.ABI + 1).encode(),
    "another key": lambda m: signed(m, key=OTHER).encode(),
    "other names": lambda m: signed(m, description={**DESCRIPTION, "names": ["x2", "x1", "Φ_S"]}).encode(),
    "fewer names": lambda m: signed(m, description={"names": ["x1"]}).encode(),
    "other sizes": lambda m: signed(m, description={**DESCRIPTION, "sizes": {"u": 1, "x": 2}}).encode(),
    "other spaces": lambda m: json.dumps(json.loads(m.read_bytes())).encode() + b"\n",
    "no hash of itself": lambda m: m.read_bytes()[: m.read_bytes().index(b',"manifest_sha256"')] + b"}\n",
    "a BOM": lambda m: b"\xef\xbb\xbf" + m.read_bytes(),
    "UTF-16": lambda m: m.read_bytes().decode().encode("utf-16"),
    "invalid UTF-8": lambda m: m.read_bytes().replace(b"x1", b"\xff\xfe"),
    "a lone surrogate": lambda m: m.read_bytes().replace(b'"x1"', b'"\\ud800"'),
    "NUL": lambda m: m.read_bytes() + b"\0",
    "CRLF": lambda m: m.read_bytes().replace(b"\n", b"\r\n"),
    "100,000 brackets": lambda m: b"[" * 100_000,
    "100,000 objects": lambda m: b'{"description":' * 60_000,
    "nested in itself": lambda m: m.read_bytes().replace(b'"x1"', b"[" * 3000 + b"]" * 3000),
    "twice": lambda m: m.read_bytes() * 2,
}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
def test_a_manifest_with(folder, manifest, text):
    manifest.write_bytes(text(manifest))
    assert_rebuilt(folder)


def test_a_manifest_of_100_megabytes_is_not_read(folder, manifest):
    os.truncate(manifest, 100_000_000)
    assert_rebuilt(folder)


def test_a_sparse_library_of_a_terabyte_is_not_read(folder, library):
    os.truncate(library, 10**12)
    assert_rebuilt(folder)


def test_manifests_swapped(folder, manifest):
    obtain(Maker(b"other"), key=OTHER)
    mine, theirs = manifest.read_bytes(), (folder / f"{OTHER}.json").read_bytes()
    manifest.write_bytes(theirs)
    (folder / f"{OTHER}.json").write_bytes(mine)
    assert_rebuilt(folder)


def test_libraries_swapped(folder, library):
    other = obtain(Maker(b"other"), key=OTHER)
    library.rename(folder / "swap")
    other.rename(library)
    (folder / "swap").rename(other)
    assert_rebuilt(folder)


def test_a_library_that_is_gone(folder, library):
    library.unlink()
    assert_rebuilt(folder)


@pytest.mark.parametrize("content", [b"", SOURCE[:-1], SOURCE + b" ", SOURCE.upper()], ids=repr)
def test_a_source_that_a_reader_has_changed_is_not_left_beside_the_library(folder, source, content):
    source.write_bytes(content)
    assert_rebuilt(folder)
    assert source.read_bytes() == SOURCE


def test_a_source_that_is_gone(folder, source):
    source.unlink()
    assert_rebuilt(folder)


def test_a_manifest_that_is_gone_is_no_damage(folder, manifest):
    manifest.unlink()
    maker = Maker()
    obtain(maker)
    assert maker.calls == 1


@pytest.mark.parametrize("which", ["manifest", "library", "source"])
@pytest.mark.parametrize("what", ["link", "dangling", "pipe", "writable", "foreign"])
def test_a_file_that_is_not_ours_alone(folder, tmp_path, request, which, what):
    path = request.getfixturevalue(which)
    if what == "writable":
        path.chmod(0o620)
    elif what == "foreign":
        if os.geteuid() != 0:
            pytest.skip("only root can give a file away")
        os.chown(path, 65534, -1)
    else:
        path.rename(tmp_path / "away")
        if what == "pipe":
            os.mkfifo(path)
        else:
            path.symlink_to(tmp_path / ("away" if what == "link" else "nowhere"))
    assert_rebuilt(folder)
    assert not path.is_symlink()


@pytest.mark.parametrize("which", ["manifest", "library", "source"])
def test_a_folder_under_a_final_name_is_a_sentence_and_cleaned(folder, request, which):
    path = request.getfixturevalue(which)
    path.unlink()
    path.mkdir()
    with pytest.raises(BuildError, match=r"^The compiled library cannot be stored in .*: Is a directory\.$"):
        obtain(Maker())
    cache.clean_cache()
    assert obtain(Maker()).read_bytes() == CONTENT


def test_an_entry_of_an_older_version_is_built_again(folder, monkeypatch):
    monkeypatch.setattr(cache, "ABI", cache.ABI + 1)
    assert_rebuilt(folder)


def test_a_warning_made_an_error_comes_after_the_repair(folder, library):
    os.truncate(library, 100)
    maker = Maker()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(CacheWarning):
            obtain(maker)
        assert obtain(maker).read_bytes() == CONTENT
    assert maker.calls == 1


def test_a_disk_that_forgets_is_a_sentence(folder, monkeypatch):
    replace = os.replace

    def forgetful(source, target):
        os.truncate(source, 10)
        replace(source, target)

    monkeypatch.setattr(os, "replace", forgetful)
    with pytest.raises(BuildError, match="does not keep"):
        obtain(Maker(), key=OTHER)


def test_a_failed_build_leaves_the_cache_as_it_was(folder):
    before = names(folder)

    def fails(scratch):
        (scratch / "half").write_bytes(b"half")
        raise BuildError("no")

    with pytest.raises(BuildError, match="no"):
        obtain(fails, key=OTHER)
    assert set(names(folder)) - set(before) == {f"{OTHER}.lock"}
