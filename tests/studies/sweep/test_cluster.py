"""Sweeps on a cluster: the same bits as here, whoever dies; what cannot be mended ends with a sentence."""

import ipaddress
import itertools
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from distributed import LocalCluster

from hillobs.codegen.batch import compile_loop
from hillobs.codegen.toolchain import PORTABLE
from hillobs.model.block import Block
from hillobs.studies.files.errors import ClusterError, ScenarioError
from hillobs.studies.sweep import plan as planning
from hillobs.studies.sweep.axes import Range
from hillobs.studies.sweep.cluster import client as clusters
from hillobs.studies.sweep.cluster import worker
from hillobs.studies.sweep.cluster.client import ClusterWarning, on_cluster, warn_of_open_ports
from hillobs.studies.sweep.cluster.local import kept_alive
from hillobs.studies.sweep.cluster.plan_text import plan_of, text_of
from hillobs.studies.sweep.cluster.same_code import difference
from hillobs.studies.sweep.plan import plan
from hillobs.studies.sweep.run import sweep

SHORT = {"duration": 0.2, "score.start": 0.05}
OVER = {"high_gain.eps_h": Range(0.02, 0.5, 5, logarithmic=True)}


def started(workers: int, processes: bool = True) -> LocalCluster:
    scheduler = {"dashboard": False, "dashboard_address": "127.0.0.1:0", "allowed_failures": 1}
    return LocalCluster(
        n_workers=workers,
        processes=processes,
        threads_per_worker=1,
        host="127.0.0.1",
        protocol="tcp://",
        scheduler_kwargs=scheduler,
        silence_logs=60,  # deaths are meant here
    )


@pytest.fixture(scope="module")
def two() -> Iterator[LocalCluster]:
    with started(2) as cluster:
        yield cluster


@pytest.fixture
def inside() -> Iterator[LocalCluster]:
    """A cluster whose worker is a thread of this process: it sees what is patched."""
    with started(1, processes=False) as cluster:
        yield cluster


@pytest.fixture(autouse=True)
def _small_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planning, "PART", 4)


def swept(**more: Any) -> xr.Dataset:
    return sweep("paper-noisy", OVER, seeds=8, changes=SHORT, quantities=["x2"], **more)


@pytest.fixture(scope="module")
def here() -> xr.Dataset:
    return swept(target=PORTABLE)


def test_a_cluster_computes_the_same_bits(two: LocalCluster, here: xr.Dataset) -> None:
    there = swept(cluster=two.scheduler_address)
    assert there.attrs["target"] == PORTABLE
    xr.testing.assert_equal(here, there)
    np.testing.assert_allclose(swept().rmse, there.rmse, rtol=1e-10)


def test_the_parts_of_a_killed_worker_are_done_again(two: LocalCluster, here: xr.Dataset, tmp_path: Path) -> None:
    killed: list[int] = []

    def kill(done: int, runs: int) -> None:
        if done and not killed:
            killed.append(two.workers[0].pid)
            os.kill(killed[0], signal.SIGKILL)

    there = swept(cluster=two.scheduler_address, progress=kill, out=tmp_path / "x.nc")
    assert killed
    xr.testing.assert_equal(here, there)


def test_a_part_that_kills_workers_is_named_and_the_others_kept(
    two: LocalCluster, here: xr.Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out, work = tmp_path / "x.nc", clusters.work

    # a function of the test is sent by value: workers cannot import this file
    def work_or_die(told: str, part: int) -> np.ndarray:
        if part == 2:
            os._exit(1)
        return work(told, part)

    with monkeypatch.context() as patched:
        patched.setattr(clusters, "work", work_or_die)
        patched.setattr(two.scheduler, "allowed_failures", 0)  # each death takes a start
        words = r"part 2 ended every worker that took it: runs 8 to 11, high_gain.eps_h = 0.0447214, seed = 0 … 3$"
        with pytest.raises(ClusterError, match=words):
            swept(cluster=two.scheduler_address, out=out)
    kept = {int(path.stem) for path in (tmp_path / "x.nc.parts").glob("*.part")}
    assert kept == set(range(10)) - {2}
    xr.testing.assert_equal(here, swept(target=PORTABLE, out=out))


def test_workers_that_die_after_they_have_finished_cost_no_part(
    here: xr.Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their rows are lost before anyone has fetched them; in a cluster of its own, in which none has died before."""
    batch, dead = clusters._Crew._batch, []

    def die_first(crew: Any) -> list[Any]:
        futures: list[Any] = batch(crew)
        if not dead:
            dead.extend(crew._client.run(os.getpid).values())
            for pid in dead:
                os.kill(pid, signal.SIGKILL)
            for _ in range(1000):
                if futures[0].status == "lost":
                    break
                time.sleep(0.01)
        return futures

    monkeypatch.setattr(clusters._Crew, "_batch", die_first)
    with started(2) as cluster:
        xr.testing.assert_equal(here, swept(cluster=cluster.scheduler_address))
    assert dead


def test_without_its_scheduler_a_sweep_ends_and_goes_on(here: xr.Dataset, tmp_path: Path) -> None:
    out = tmp_path / "x.nc"
    with started(1, processes=False) as cluster:

        def close(done: int, runs: int) -> None:
            if done:
                cluster.close()

        with pytest.raises(ClusterError, match=r"the scheduler of tcp://127.0.0.1:\d+ is gone"):
            swept(cluster=cluster.scheduler_address, out=out, progress=close)
    assert list((tmp_path / "x.nc.parts").glob("*.part"))
    xr.testing.assert_equal(here, swept(target=PORTABLE, out=out))


def test_a_worker_with_other_code_is_refused(inside: LocalCluster, monkeypatch: pytest.MonkeyPatch) -> None:
    code = worker.code
    asked: list[Path] = []

    def other(library: Path) -> dict[str, str]:
        asked.append(library)
        # the first to ask is the client
        return code(library) | ({} if len(asked) == 1 else {"casadi": "3.7.0", "compiled library": "0123"})

    monkeypatch.setattr(worker, "code", other)
    words = r"^worker tcp://127.0.0.1:\d+ would not compute the same numbers: casadi 3.7.0 there and 3.8.\d here$"
    with pytest.raises(ClusterError, match=words):
        swept(cluster=inside.scheduler_address, observers="high_gain")


def test_what_makes_no_difference_may_differ() -> None:
    here = {"hillobs": "1", "its source": "a", "compiler": "g++", "C library": "glibc", "compiled library": "b"}
    assert not difference(here | {"compiler": "/opt/g++"}, here)
    assert difference(here | {"compiled library": "c"}, here) == "compiled library c there and b here"
    assert "its source unknown there" in difference({}, here)


@pytest.mark.parametrize(
    ("changes", "scored"),
    [
        ({"plant.m": 1.1}, {}),
        ({"muscle2.curves": "millard2012"}, {"quantities": ["Delta", "x2"], "measures": ["peak"]}),
    ],
    ids=["all", "two sets of curves, some scores"],
)
def test_a_plan_survives_its_text(changes: dict[str, Any], scored: dict[str, Any]) -> None:
    over = {"sliding_mode.delta_s": Range(0.02, 0.5, 7, logarithmic=True), "duration": [0.2, 0.4]}
    changes = {"score.start": 0.05, **changes}
    checked = plan("challenge", over, [3, 2**64 - 1], ["baseline", "sliding_mode"], changes, **scored)
    again, runs = plan_of(text_of(checked)), np.arange(28)
    assert again.description("x") == checked.description("x")
    # the very Blocks, so the same library
    assert again.prepared.loop is checked.prepared.loop
    assert [grid for grid, _ in again.on_grids(runs)] == [grid for grid, _ in checked.on_grids(runs)]
    for name, numbers in checked.numbers(runs).items():
        np.testing.assert_array_equal(again.numbers(runs)[name], numbers)


def test_an_observer_of_ones_own_cannot_be_sent(proportional: Block) -> None:
    with pytest.raises(ScenarioError, match="proportional is a Block of this process"):
        text_of(plan("paper-clean", {}, 1, proportional, SHORT))


@pytest.mark.parametrize(
    ("address", "workers", "words"),
    [
        ("nonsense", None, "'nonsense' is no cluster; there are local, tcp://"),
        ("http://localhost:80", None, "is no cluster"),
        ("tcp://localhost:8786", 2, "for --cluster local only"),
        ("tcp://127.0.0.1:1", None, "no scheduler of dask answers at tcp://127.0.0.1:1"),
        ("tls://127.0.0.1:1", None, "for tls://127.0.0.1:1 dask has no certificates"),
    ],
)
def test_what_is_no_cluster_is_said(
    address: str, workers: int | None, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clusters, "_ANSWER", 0.2)
    with pytest.raises(ClusterError, match=words), on_cluster(address, workers):
        pass


def test_without_dask_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ClusterError, match=r"pip install 'hillobs\[cluster\]'"), on_cluster("local"):
        pass


def test_without_a_cluster_dask_is_not_loaded() -> None:
    words = "import sys, hillobs.studies.sweep.run; print('distributed' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_open_ports_are_warned_of() -> None:
    with pytest.warns(ClusterWarning, match="tcp://10.0.0.7:8786 is open: .* use tls://"):
        warn_of_open_ports(["tcp://127.0.0.1:8786", "tcp://10.0.0.7:8786"])
    warn_of_open_ports(["tcp://127.0.0.2:1", "tcp://[::1]:1", "localhost:1", "tls://10.0.0.7:8786"])


def test_a_command_on_a_local_cluster_ends_with_its_workers_and_goes_on(
    command: Callable[..., tuple[int, str, str]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = ["sweep", "paper-noisy", "--no-figures", "--set", "duration=2", "--quantity", "x2"]
    told += ["--over", "high_gain.eps_h=log:0.02:0.5:40", "--seeds", "64", "--out"]
    on = [sys.executable, "-m", "hillobs", *told, "cut.nc", "--cluster", "local", "--workers", "1"]
    mine = {**os.environ, "HILLOBS_TEST": str(tmp_path)}
    process = subprocess.Popen(on, cwd=tmp_path, env=mine, stderr=subprocess.PIPE, text=True)
    folder, pause = tmp_path / "cut.nc.parts", threading.Event()
    while not list(folder.glob("*.part")) and process.poll() is None:
        pause.wait(0.02)
    process.send_signal(signal.SIGTERM)
    _, words = process.communicate()
    assert process.returncode == 128 + signal.SIGTERM
    assert words == "hillobs: stopped; what is done is kept in cut.nc.parts, the same command goes on\n"
    if sys.platform == "linux":
        assert not list(_with_environment(f"HILLOBS_TEST={tmp_path}".encode()))
    monkeypatch.undo()
    monkeypatch.chdir(tmp_path)
    for name in ("cut.nc", "whole.nc"):
        assert command(*told, name, "--target", PORTABLE)[0] == 0
    assert (tmp_path / "cut.nc").read_bytes() == (tmp_path / "whole.nc").read_bytes()


def test_a_worker_that_ends_is_followed_by_another(tmp_path: Path) -> None:
    came, pause = tmp_path / "came", threading.Event()
    came.touch()
    mine = {**os.environ, "HILLOBS_TEST": str(tmp_path)}
    for life, expected in (("0", 3), ("1000", 2)):
        before = len(came.read_bytes())
        with kept_alive(2, ["sh", "-c", 'printf x >> "$0"; exec sleep "$1"', str(came), life], mine):
            while len(came.read_bytes()) < before + expected:
                pause.wait(0.02)
        if sys.platform == "linux":
            assert not list(_with_environment(f"HILLOBS_TEST={tmp_path}".encode()))


@pytest.mark.skipif(sys.platform != "linux", reason="the system is asked for its sockets through /proc")
def test_a_local_cluster_listens_on_loopback_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Scheduler and workers, with all they start: no port is open to other machines."""
    monkeypatch.setenv("HILLOBS_TEST", str(tmp_path))
    with on_cluster("local", 2) as compute:
        checked = plan("paper-noisy", OVER, 8, "high_gain", SHORT, quantities=["x2"])
        computed = compute(checked, compile_loop(checked.prepared.loop, PORTABLE), range(checked.parts))
        for _ in range(3):
            next(computed)
        workers = list(_with_environment(f"HILLOBS_TEST={tmp_path}".encode()))
        ours = list(itertools.chain.from_iterable(_listening(pid) for pid in [str(os.getpid()), *workers]))
        computed.close()
    assert len(workers) == 2
    assert len(ours) >= 3
    assert all(address.is_loopback for address in ours)


def _listening(pid: str) -> Iterator[ipaddress.IPv4Address | ipaddress.IPv6Address]:
    """The addresses on which a process listens."""
    inodes = {os.readlink(link) for link in Path(f"/proc/{pid}/fd").iterdir() if link.is_symlink()}
    for kind in ("tcp", "tcp6"):
        for line in Path(f"/proc/{pid}/net/{kind}").read_text().splitlines()[1:]:
            local, state, inode = itemgetter(1, 3, 9)(line.split())
            if state == "0A" and f"socket:[{inode}]" in inodes:
                # words of 32 bits in the byte order of the machine
                words = bytes.fromhex(local.partition(":")[0])
                yield ipaddress.ip_address(b"".join(words[i : i + 4][::-1] for i in range(0, len(words), 4)))


def _with_environment(entry: bytes) -> Iterator[str]:
    """The processes that were started with it."""
    for path in Path("/proc").glob("[0-9]*/environ"):
        try:
            if entry in path.read_bytes():
                yield path.parent.name
        except OSError:
            continue
