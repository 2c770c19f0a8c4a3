"""Two users in one sticky folder: neither makes the other's program write, remove or load anything of theirs.

Mallory plants, Bob runs: in forks that give up root, as two users without a name. The system's own protection of links
in such folders is not counted on: here it may be off.
"""

import hashlib
import io
import itertools
import os
import pwd
import shutil
import stat
import tempfile
import traceback
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
import xarray as xr

from entries import CONTENT, Maker, obtain
from forks import Forks, become_user
from hillobs.codegen import cache
from hillobs.studies.files.errors import ResultError
from hillobs.studies.files.writing import writable_folder, write_whole
from hillobs.studies.files.written import remember
from survival import SWEEP

pytestmark = pytest.mark.skipif(os.geteuid() != 0, reason="only root can become two users")

_FIRST_FREE = 60_001


@dataclass(frozen=True)
class Shared:
    """A sticky folder, the two users, and Bob's home, which Mallory cannot enter."""

    folder: Path
    home: Path
    mallory: int
    bob: int

    def plant(self, path: Path, content: bytes | None = None, link: Path | None = None) -> Path:
        """Something of Mallory's in the folder: a file, a link, else a folder that everybody may write to."""
        if link is not None:
            path.symlink_to(link)
        elif content is None:
            path.mkdir()
            path.chmod(0o777)
        else:
            path.write_bytes(content)
            path.chmod(0o666)
        os.lchown(path, self.mallory, self.mallory)
        return path

    def snapshot(self) -> dict[str, object]:
        """Path → owner, rights, content of all that is there."""
        return {
            str(path): (info.st_uid, info.st_mode, path.read_bytes() if stat.S_ISREG(info.st_mode) else "")
            for root in (self.folder, self.home)
            for path in sorted(root.rglob("*"))
            for info in (path.lstat(),)
        }


@pytest.fixture
def shared() -> Iterator[Shared]:
    taken = {entry.pw_uid for entry in pwd.getpwall()}
    free = (uid for uid in itertools.count(_FIRST_FREE) if uid not in taken)
    mallory, bob = next(free), next(free)
    # the folders of pytest are for their user alone
    base = Path(tempfile.mkdtemp())
    base.chmod(0o755)
    here = Shared(base / "shared", base / "home", mallory, bob)
    here.folder.mkdir()
    here.folder.chmod(0o1777)
    here.home.mkdir(mode=0o700)
    for name in (".profile", ".x.nc-history", "lock", "plan.json", "00000000.part", "x.nc"):
        (here.home / name).write_text("Bob's")
        os.chown(here.home / name, bob, bob)
    os.chown(here.home, bob, bob)
    yield here
    shutil.rmtree(base)


@pytest.fixture
def bobs_cache(shared: Shared, untouched: tuple[bytes, list[str]]) -> Path:
    """A cache of Bob's with the library of the sweep: nothing is compiled."""
    with xr.open_dataset(io.BytesIO(untouched[0]), engine="h5netcdf") as result:
        key = result.attrs["library"].partition("-")[0]
    folder = shared.folder.parent / "cache"
    folder.mkdir(mode=0o700)
    os.chown(folder, shared.bob, shared.bob)
    for path in Path(os.environ["HILLOBS_CACHE"]).glob(f"{key}*"):
        os.chown(shutil.copy(path, folder), shared.bob, shared.bob)
    return folder


PLANTS: dict[str, Callable[[Shared, bytes], object]] = {
    "the parts are a link to his home": lambda here, _: here.plant(here.folder / "x.nc.parts", link=here.home),
    "the lock is a link to a file of his": lambda here, _: here.plant(
        here.plant(here.folder / "x.nc.parts") / "lock", link=here.home / ".profile"
    ),
    "the parts are mine": lambda here, whole: here.plant(
        here.plant(here.folder / "x.nc.parts") / "00000000.part", content=whole
    ),
    "the parts are mine and empty": lambda here, _: here.plant(here.folder / "x.nc.parts"),
    "the result is mine": lambda here, whole: here.plant(here.folder / "x.nc", content=whole),
    "the result is a link to a file of his": lambda here, _: here.plant(here.folder / "x.nc", link=here.home / "x.nc"),
    "the result is a link into his home": lambda here, _: here.plant(here.folder / "x.nc", link=here.home / "new.nc"),
}


@pytest.mark.parametrize("plant", PLANTS)
def test_what_another_user_has_planted_is_refused(
    plant: str, shared: Shared, bobs_cache: Path, forks: Forks, untouched: tuple[bytes, list[str]]
) -> None:
    PLANTS[plant](shared, untouched[0])
    before = shared.snapshot()
    done = forks.run(shared.folder, *SWEEP, uid=shared.bob, cache=str(bobs_cache))
    assert (done.code, done.out, done.computed) == (2, "", [])
    assert done.err.startswith("hillobs: x.nc")
    assert done.err.count("\n") == 1
    assert shared.snapshot() == before


def test_a_folder_of_results_that_is_anothers_link_is_refused(shared: Shared, bobs_cache: Path, forks: Forks) -> None:
    shared.plant(shared.folder / "results", link=shared.home)
    before = shared.snapshot()
    done = forks.run(shared.folder, *SWEEP[:-1], "results/x.nc", uid=shared.bob, cache=str(bobs_cache))
    assert done.err == "hillobs: results cannot be written to: results is a link of another user\n"
    assert (done.code, shared.snapshot()) == (2, before)


def test_both_work_side_by_side(
    shared: Shared, bobs_cache: Path, forks: Forks, untouched: tuple[bytes, list[str]]
) -> None:
    """Under names of their own; what the other has finished is refused, and stays."""
    assert forks.run(shared.folder, *SWEEP, uid=shared.bob, cache=str(bobs_cache)).code == 0
    assert (shared.folder / "x.nc").read_bytes() == untouched[0]
    for path in (bobs_cache, *bobs_cache.iterdir()):
        os.chown(path, shared.mallory, shared.mallory)
    before = shared.snapshot()
    done = forks.run(shared.folder, *SWEEP, uid=shared.mallory, cache=str(bobs_cache))
    assert (done.code, done.err) == (2, "hillobs: x.nc is there already, of another user; name another --out\n")
    assert shared.snapshot() == before
    assert forks.run(shared.folder, *SWEEP[:-1], "y.nc", uid=shared.mallory, cache=str(bobs_cache)).code == 0
    assert (shared.folder / "y.nc").read_bytes() == untouched[0]


def as_user(uid: int, work: Callable[[], str]) -> str:
    """What `work` returns in a fork that is this user."""
    reader, writer = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            become_user(uid)
            said = work()
        except BaseException:
            said = traceback.format_exc()
        os.write(writer, said.encode())
        os._exit(0)
    os.close(writer)
    with open(reader) as file:
        said = file.read()
    os.waitpid(child, 0)
    return said


def refusal(work: Callable[[], object]) -> str:
    try:
        work()
    except ResultError as error:
        return str(error)
    return "done"


def test_a_list_that_another_user_has_planted_gives_nothing_away(shared: Shared) -> None:
    """It says of Bob's notes that hillobs has written them."""
    notes = shared.folder / "x.csv"
    notes.write_text("Bob's notes")
    os.chown(notes, shared.bob, shared.bob)
    handle = os.open(shared.folder, os.O_RDONLY)
    remember(handle, "x.csv", hashlib.sha256(b"Bob's notes").hexdigest())
    os.close(handle)
    planted = (shared.folder / f".hillobs-{os.geteuid()}").rename(shared.folder / f".hillobs-{shared.bob}")
    os.chown(planted, shared.mallory, shared.mallory)
    planted.chmod(0o666)
    before = shared.snapshot()
    said = as_user(shared.bob, lambda: refusal(lambda: write_whole(notes, b"new")))
    assert "was not made by hillobs" in said
    assert shared.snapshot() == before
    # each has a list of their own, where nobody has planted one
    planted.unlink()
    for uid, name in ((shared.mallory, "a"), (shared.bob, "b"), (shared.mallory, "a"), (shared.bob, "b")):
        assert as_user(uid, lambda name=name: refusal(lambda: write_whole(shared.folder / name, b"new"))) == "done"
    assert "not as hillobs wrote it" in as_user(
        shared.bob, lambda: refusal(lambda: write_whole(shared.folder / "a", b"newer"))
    )


@pytest.mark.parametrize("below", ["", "a/b"])
def test_another_users_link_leads_no_folder_of_results_astray(shared: Shared, below: str) -> None:
    shared.plant(shared.folder / "results", link=shared.home)
    before = shared.snapshot()
    said = as_user(shared.bob, lambda: refusal(lambda: writable_folder(shared.folder / "results" / below)))
    assert said.endswith("results is a link of another user")
    assert shared.snapshot() == before


def test_another_users_cache_is_not_loaded(shared: Shared, monkeypatch: pytest.MonkeyPatch) -> None:
    """It has the very entry, whole, under its right name."""
    planted = shared.folder / "cache"
    monkeypatch.setenv("HILLOBS_CACHE", str(planted))
    monkeypatch.setattr(cache, "_private", {})
    obtain(Maker())
    for path in (planted, *planted.iterdir()):
        os.chown(path, shared.mallory, shared.mallory)
        path.chmod(0o777)
    before = shared.snapshot()

    def run() -> str:
        maker = Maker()
        with warnings.catch_warnings(record=True) as said:
            warnings.simplefilter("always")
            library = obtain(maker)
        mine = library.read_bytes() == CONTENT and library.stat().st_uid == os.geteuid()
        shutil.rmtree(library.parent)
        return f"{maker.calls} {mine} {len(said)} {library.is_relative_to(planted)}"

    assert as_user(shared.bob, run) == "1 True 1 False"
    assert shared.snapshot() == before
