"""The cache of compiled libraries: damage is found before loading, and whatever stops a build leaves nothing partial.

No test here needs a compiler: the step that makes a library writes a few bytes. Audit hooks inject the faults.
"""

import errno
import fcntl
import hashlib
import json
import os
import random
import stat
import subprocess
import sys
import textwrap
import warnings
from pathlib import Path

import pytest

from hillobs.codegen import cache
from hillobs.codegen.cache import BuildError, CacheWarning

KEY = cache.entry_key({"source": "a test"})
OTHER = cache.entry_key({"source": "another test"})
DESCRIPTION = {"names": ["x1", "x2", "Φ_S"], "sizes": {"x": 2, "u": 1}}
CONTENT = random.Random(1).randbytes(9000)


class Maker:
    """Stands for the compiler; counts its calls."""

    def __init__(self, content=CONTENT):
        self.content, self.calls = content, 0

    def __call__(self, folder):
        self.calls += 1
        (folder / "made.so").write_bytes(self.content)
        return folder / "made.so"


def obtain(maker, key=KEY, description=DESCRIPTION, patience=30.0):
    return cache.obtain(key, description, maker, patience)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty cache in which one entry has been made."""
    monkeypatch.setenv("HILLOBS_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(cache, "_private", {})
    obtain(Maker())
    return tmp_path / "cache"


@pytest.fixture
def manifest(folder):
    return folder / f"{KEY}.json"


@pytest.fixture
def library(folder):
    return next(folder.glob(f"{KEY}-*.so"))


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def assert_whole(folder, pattern="*.json"):
    """Every file under a final name is what its manifest says, found without the code under test."""
    for path in folder.glob(pattern):
        said = json.loads(path.read_bytes())
        content = (folder / said["library"]).read_bytes()
        assert said["key"] == path.stem
        assert hashlib.sha256(content).hexdigest() == said["sha256"]
        assert len(content) == said["size"]


def assert_rebuilt(folder):
    """The damage is seen, said once, repaired, and gone at the next look."""
    maker = Maker()
    with pytest.warns(CacheWarning) as said:
        path = obtain(maker)
    assert len(said) == 1
    assert "built again" in str(said[0].message)
    assert str(folder) in str(said[0].message)
    assert maker.calls == 1
    assert path.read_bytes() == CONTENT
    assert obtain(maker) == path
    assert maker.calls == 1
    assert_whole(folder, f"{KEY}.json")
    assert not list(folder.glob("*.tmp"))


# the entry


def test_an_entry_is_made_once_and_found_again(folder):
    maker = Maker()
    assert obtain(maker).read_bytes() == CONTENT
    assert maker.calls == 0
    assert len(names(folder)) == 3  # manifest, library, lock


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


def test_files_are_for_us_alone(folder, library, manifest):
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert {stat.S_IMODE(path.stat().st_mode) for path in (library, manifest)} == {0o600}


@pytest.mark.parametrize("seconds", [0, 1, 4_102_444_800], ids=["1970", "1970+1", "2100"])
def test_times_of_files_mean_nothing(folder, seconds):
    for path in [*folder.iterdir(), folder]:
        os.utime(path, (seconds, seconds))
    maker = Maker()
    obtain(maker)
    assert maker.calls == 0


# damage


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
            cache.find(folder, KEY, DESCRIPTION)
    assert_rebuilt(folder)


def test_every_flipped_bit_of_a_manifest_is_found(folder, manifest):
    text = bytearray(manifest.read_bytes())
    for bit in range(8 * len(text)):
        text[bit // 8] ^= 1 << bit % 8
        manifest.write_bytes(text)
        with pytest.raises(cache._DamageError):
            cache.find(folder, KEY, DESCRIPTION)
        text[bit // 8] ^= 1 << bit % 8
    manifest.write_bytes(text)
    assert cache.find(folder, KEY, DESCRIPTION)


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


def test_a_manifest_that_is_gone_is_no_damage(folder, manifest):
    manifest.unlink()
    maker = Maker()
    obtain(maker)
    assert maker.calls == 1


@pytest.mark.parametrize("which", ["manifest", "library"])
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


@pytest.mark.parametrize("which", ["manifest", "library"])
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


# where the cache is


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


# one process per case


RUN = """
    import os, sys, warnings
    from pathlib import Path
    from hillobs.codegen import cache
    KEY = {key!r}
    content = bytes(range(256)) * 40

    def make(folder):
        (folder / "made.so").write_bytes(content)
        return folder / "made.so"

    def run(key=KEY):
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            try:
                path = cache.obtain(key, {{"names": ["x"]}}, make, 30)
            except cache.BuildError as error:
                print("sentence:", error)
                return 1
        print("warnings:", len(said), *(warning.message for warning in said))
        print("path:", path)
        return 0 if path.read_bytes() == content else 9
"""


def child(program, folder, *arguments, **options):
    """Run a program after RUN in a process of its own."""
    text = textwrap.dedent(RUN.format(key=KEY)) + textwrap.dedent(program)
    environment = os.environ | {"HILLOBS_CACHE": str(folder), "PYTHONDONTWRITEBYTECODE": "1"} | options.pop("env", {})
    command = [sys.executable, *options.pop("switches", []), "-c", text, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, env=environment, **options)


FAULT = """
    import atexit, errno, tempfile, traceback
    counted = ("open", "os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.chmod", "fcntl.flock", "os.listdir",
               "tempfile.mkdtemp", "shutil.rmtree")

    def fault(kind):
        if kind == "KILL":
            os.kill(os.getpid(), 9)
        if kind == "INTERRUPT":
            raise KeyboardInterrupt
        code = getattr(errno, kind)
        raise OSError(code, os.strerror(code))

    def forked(kind="", when=0):
        armed = [kind] * bool(kind)
        if child := os.fork():
            return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        seen = 0

        def hook(event, arguments):
            nonlocal seen
            if armed and event in counted:
                seen += 1
                if seen == when:
                    fault(kind)

        sys.addaudithook(hook)
        try:
            code = run(armed)
        except KeyboardInterrupt:
            code = 130
        except BaseException:
            traceback.print_exc()
            code = 8
        armed.clear()
        reached = seen >= when
        atexit._run_exitfuncs()
        sys.stdout.flush()
        os._exit(code if reached else 77)

    def run(armed):
        with warnings.catch_warnings(record=True):
            warnings.simplefilter("always")
            try:
                path = cache.obtain(KEY, {"names": ["x"]}, make, 30)
            except cache.BuildError as error:
                return 1
        armed.clear()
        with open(path, "rb") as file:
            return 0 if file.read() == content else 9

    kind, start, root = sys.argv[1:]
    for when in range(1, 200):
        folder, temporary = Path(root, str(when), "cache"), Path(root, str(when), "temporary")
        folder.mkdir(mode=0o700, parents=True)
        temporary.mkdir()
        os.environ["HILLOBS_CACHE"], tempfile.tempdir = str(folder), str(temporary)
        if start != "cold":
            forked()
            os.truncate(next(folder.glob("*.so")), 10)
        if start == "abandoned":
            (folder / f"{KEY}-left.tmp").mkdir()
            (folder / f"{KEY}-left.tmp" / "half.so").write_bytes(b"half")
        hit = forked(kind, when)
        print(hit, end=" ", flush=True)
        if hit == 77:
            break
        again = forked()
        if again != 0:
            print("then", again, end=" ")
"""


@pytest.mark.parametrize("start", ["cold", "damaged", "abandoned"])
@pytest.mark.parametrize("kind", ["KILL", "ENOSPC", "EIO", "EACCES", "INTERRUPT"])
def test_a_fault_at_each_call(tmp_path, record_property, kind, start):
    result = child(FAULT, tmp_path, kind, start, tmp_path)
    assert result.stderr == ""
    *codes, untouched = result.stdout.split()
    assert untouched == "77"
    record_property("faults", len(codes))
    assert len(codes) >= 20
    assert set(codes) <= {"KILL": {"-9"}, "INTERRUPT": {"0", "130"}}.get(kind, {"0", "1"})
    for when in range(1, len(codes) + 1):
        folder = tmp_path / str(when) / "cache"
        assert_whole(folder)
        assert {Path(name).suffix for name in names(folder)} == {".json", ".so", ".lock"}
        assert len(names(folder)) == 3
        assert kind == "KILL" or names(tmp_path / str(when) / "temporary") == []


READ_ONLY = """
    def hook(event, arguments):
        path = os.fspath(arguments[0]) if arguments and isinstance(arguments[0], (str, os.PathLike)) else ""
        writes = event == "open" and arguments[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT)
        if path.startswith(os.environ["HILLOBS_CACHE"]) and (writes or event in ("os.mkdir", "os.rename", "os.remove")):
            raise OSError(30, os.strerror(30))

    sys.addaudithook(hook)
    code = run()
    sys.exit(code or run())
"""


def test_a_read_only_cache_is_read(tmp_path):
    child("run()", tmp_path / "cache")
    result = child(READ_ONLY, tmp_path / "cache")
    assert result.returncode == 0
    assert "warnings: 0" in result.stdout
    assert f"path: {tmp_path / 'cache'}" in result.stdout


def test_a_read_only_cache_without_the_entry_is_left_alone(tmp_path):
    (tmp_path / "cache").mkdir(mode=0o700)
    (tmp_path / "temporary").mkdir()
    result = child(READ_ONLY, tmp_path / "cache", env={"TMPDIR": str(tmp_path / "temporary")})
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stdout.count("Read-only file system") == 1  # one warning for two runs
    assert f"path: {tmp_path / 'temporary'}" in result.stdout
    assert names(tmp_path / "cache") == names(tmp_path / "temporary") == []


def test_no_temporary_folder_either_is_a_sentence(tmp_path):
    (tmp_path / "cache").write_text("a file")
    program = "import tempfile; tempfile.tempdir = '/nowhere'; sys.exit(run())"
    result = child(program, tmp_path / "cache")
    assert result.returncode == 1
    assert "no temporary folder can be made" in result.stdout


def test_a_private_folder_left_by_a_killed_process_is_swept(tmp_path):
    (tmp_path / "cache").write_text("a file")
    (tmp_path / "temporary").mkdir()
    for kill in (True, True, False):
        program = f"run()\nimport os\nif {kill}: os.kill(os.getpid(), 9)"
        child(program, tmp_path / "cache", env={"TMPDIR": str(tmp_path / "temporary")})
        assert len(names(tmp_path / "temporary")) == kill


def test_a_forked_child_does_not_remove_the_folder_of_its_parent(tmp_path):
    (tmp_path / "cache").write_text("a file")
    program = """
        run()
        if os.fork() == 0:
            sys.exit(0)
        os.wait()
        sys.exit(0 if cache.cache_folder().is_dir() else 5)
    """
    assert child(program, tmp_path / "cache").returncode == 0


@pytest.mark.parametrize("umask", [0o000, 0o077, 0o777], ids="{:03o}".format)
def test_the_umask_does_not_matter(tmp_path, umask):
    folder = tmp_path / "parent" / "cache"
    result = child(f"os.umask({umask}); sys.exit(run() or run())", folder)
    assert result.returncode == 0, result.stdout + result.stderr
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert {stat.S_IMODE(path.stat().st_mode) for path in folder.iterdir()} == {0o600}
    assert child("sys.exit(run())", folder).returncode == 0


@pytest.mark.parametrize("switches", [["-O"], ["-OO"], ["-X", "dev"], ["-W", "error"], ["-I"]], ids=" ".join)
def test_switches_of_python_do_not_matter(tmp_path, switches):
    folder = tmp_path / "cache"
    assert child("sys.exit(run())", folder, switches=switches).returncode == 0
    flip(next(folder.glob("*.so")), 1000)
    result = child("sys.exit(run())", folder, switches=switches)
    assert result.returncode == 0, result.stderr
    assert "warnings: 1" in result.stdout


def test_without_home_and_user_nothing_is_written_to_the_current_folder(tmp_path):
    program = """
        cache.__file__ = "/site/codegen/cache.py"
        for name in ("HOME", "XDG_CACHE_HOME", "HILLOBS_CACHE"):
            os.environ.pop(name, None)
        import pwd
        def unknown(user): raise KeyError(user)
        pwd.getpwuid = unknown
        sys.exit(run())
    """
    result = child(program, "/unused", cwd=tmp_path)
    assert result.returncode == 0, result.stdout + result.stderr
    assert "warnings: 1" in result.stdout
    assert names(tmp_path) == []


# locks, sweeping, cleaning


HOLD = (
    "import fcntl; file = open(sys.argv[1], 'a'); fcntl.flock(file, fcntl.LOCK_EX); print('held', flush=True); input()"
)


@pytest.fixture
def holder(folder):
    """Another process that holds the lock of OTHER."""
    command = [sys.executable, "-c", "import sys; " + HOLD, str(folder / f"{OTHER}.lock")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        process.stdout.readline()
        yield process
        process.kill()


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
            cache._publish(folder, scratch, OTHER, DESCRIPTION, CONTENT)
        holder.kill()
        holder.wait()
        return original(path, patience)

    original = cache._acquire
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cache, "_acquire", publish_then_let_go)
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
    assert len(removed) == 4
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
    handle = cache._acquire(lock, patience=30)
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


def failing(folder):
    raise OSError(errno.EIO, os.strerror(errno.EIO))


def flip(path, bit):
    content = bytearray(path.read_bytes())
    content[bit // 8] ^= 1 << bit % 8
    path.write_bytes(content)
