"""A sweep on a cluster whose workers are killed all the time, at random and all at once; run by `make chaos`."""

import random
import subprocess
import threading
from pathlib import Path

import distributed  # noqa: F401  its defaults are there before one is changed
import pytest
import xarray as xr
from dask import config

from hillobs.codegen.toolchain import PORTABLE
from hillobs.studies.sweep import plan as planning
from hillobs.studies.sweep.axes import Range
from hillobs.studies.sweep.cluster import local as local_cluster
from hillobs.studies.sweep.run import sweep

pytestmark = pytest.mark.chaos

OVER = {"high_gain.eps_h": Range(0.02, 0.5, 25, logarithmic=True)}
SHORTER = {"duration": 4.0}
DEADLY, STILLBORN = 0.03, 0.3  # shares: of the parts that end with a death, of the workers that die while they start
START = 2.0  # seconds


@pytest.mark.parametrize("at_once", [False, True])
def test_whoever_dies_the_bits_are_the_same(at_once: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planning, "PART", 64)
    whole = sweep("paper-noisy", OVER, seeds=400, changes=SHORTER, target=PORTABLE)
    fate = random.Random(int(at_once))
    started: list[subprocess.Popen[bytes]] = []
    deaths: list[int] = []
    start = local_cluster._start

    def kill(worker: subprocess.Popen[bytes]) -> None:
        if worker.poll() is None:
            worker.kill()
            deaths.append(worker.pid)

    def noted(*what) -> subprocess.Popen[bytes]:
        started.append(start(*what))
        if fate.random() < STILLBORN:
            threading.Timer(START * fate.random(), kill, started[-1:]).start()
        return started[-1]

    def reap(done: int, runs: int) -> None:
        if fate.random() < DEADLY:
            for worker in started if at_once else started[-1:]:
                kill(worker)

    monkeypatch.setattr(local_cluster, "_start", noted)
    # so many may happen to hit one part
    with config.set({"distributed.scheduler.allowed-failures": 100}):
        more = {"cluster": "local", "workers": 2, "out": tmp_path / "x.nc", "progress": reap}
        found = sweep("paper-noisy", OVER, 400, changes=SHORTER, **more)
    assert deaths
    xr.testing.assert_equal(whole, found)
