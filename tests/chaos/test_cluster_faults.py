"""A sweep on a cluster whose workers are killed all the time, at random and all at once; run by `make chaos`."""

import contextlib
import os
import random
import signal
import threading
from pathlib import Path

import pytest
import xarray as xr
from distributed import LocalCluster

from hillobs.codegen.toolchain import PORTABLE
from hillobs.studies import plan as planning
from hillobs.studies.axes import Range
from hillobs.studies.sweep import sweep

pytestmark = pytest.mark.chaos

OVER = {"high_gain.eps_h": Range(0.02, 0.5, 25, logarithmic=True)}
SHORTER = {"duration": 4.0}
LIVES = 5.0  # mean seconds between two deaths; a worker takes some of them to start


@pytest.mark.parametrize("at_once", [False, True])
def test_whoever_dies_the_bits_are_the_same(at_once: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(planning, "PART", 64)
    whole = sweep("paper-noisy", OVER, seeds=400, changes=SHORTER, baseline=PORTABLE)
    out = tmp_path / "x.nc"
    lives, over, deaths = random.Random(int(at_once)), threading.Event(), []  # noqa: S311  no secret
    # so many may happen to hit one part
    scheduler = {"dashboard": False, "dashboard_address": "127.0.0.1:0", "allowed_failures": 100}
    with LocalCluster(
        n_workers=2,
        threads_per_worker=1,
        host="127.0.0.1",
        protocol="tcp://",
        scheduler_kwargs=scheduler,
        silence_logs=60,
    ) as cluster:

        def reap() -> None:
            while not over.wait(lives.expovariate(1 / LIVES)):
                # dask gives up a worker that dies while it starts
                known = set(cluster.scheduler.workers)
                every = [nanny.pid for nanny in cluster.workers.values() if nanny.pid and nanny.worker_address in known]
                for pid in every if at_once else every[:1]:
                    with contextlib.suppress(ProcessLookupError):
                        os.kill(pid, signal.SIGKILL)
                        deaths.append(pid)

        reaper = threading.Thread(target=reap)
        reaper.start()
        try:
            found = sweep("paper-noisy", OVER, seeds=400, changes=SHORTER, cluster=cluster.scheduler_address, out=out)
        finally:
            over.set()
            reaper.join()
    assert deaths
    xr.testing.assert_equal(whole, found)
