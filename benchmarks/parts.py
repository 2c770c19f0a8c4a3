"""What docs/scaling.md counts with: time, memory and bytes of a run, and what a part costs beside its runs."""

from __future__ import annotations

import resource
import statistics
import sys
import tempfile
import time
from pathlib import Path

from hillobs.studies import plan as planning
from hillobs.studies.plan import PART
from hillobs.studies.sweep import engine, sweep, sweep_planned

ROUNDS = 3
SIZED = 4_000  # runs whose result is weighed
MANY, FEW = 200_000, 20_000  # runs whose memory is compared
TINY = {"duration": 0.005, "score.start": 0.0, "record": 0.005}
PARTS = 400  # of one run, to see what a part costs


def main() -> None:
    """Print each figure with its unit."""
    rate = statistics.median(_rate() for _ in range(ROUNDS))
    print(f"{rate:8.0f}  runs a second of one core (CPU time), paper-noisy, 20 s, three observers")
    print(f"{PART / rate:8.2f}  s of one core for a part of {PART} runs")
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "x.nc"
        sweep("paper-noisy", seeds=SIZED, changes={"duration": 1.0, "score.start": 0.5}, out=out)
        print(f"{out.stat().st_size / SIZED:8.0f}  bytes of a run in the result")
        few = _peak(FEW, Path(folder) / "few.nc")
        more = (_peak(MANY, Path(folder) / "many.nc") - few) / (MANY - FEW)
        print(f"{more:8.0f}  bytes of memory for a run of one sweep, at the peak")
    planning.PART = 1
    for name, cluster in (("threads", None), ("a local cluster", "local")):
        print(f"{1000 * _per_part(cluster):8.2f}  ms for a part beside its runs, on {name}")


def _rate() -> float:
    before = time.process_time()
    sweep("paper-noisy", seeds=PART, workers=1)
    return PART / (time.process_time() - before)


def _peak(runs: int, out: Path) -> float:
    sweep("paper-noisy", seeds=runs, changes=TINY, out=out)
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def _per_part(cluster: str | None) -> float:
    """Seconds per part, once all is compiled and the workers have prepared the sweep."""
    wanted = planning.plan("paper-noisy", {}, PARTS, "high_gain", TINY)
    came: list[float] = []
    with engine(1, cluster) as (compute, baseline):
        for _ in range(2):
            start = time.perf_counter()
            sweep_planned(wanted, None, compute, baseline)
            came.append(time.perf_counter() - start)
    return min(came) / PARTS


if __name__ == "__main__":
    main()
