"""What docs/scaling.md counts with: time, memory and bytes of a run, and what a part costs beside its runs."""

from __future__ import annotations

import resource
import statistics
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

from hillobs.codegen.batch import compile_loop
from hillobs.codegen.toolchain import NATIVE, PORTABLE
from hillobs.studies.sweep.computing import Compute
from hillobs.studies.sweep.plan import PART, Plan, plan
from hillobs.studies.sweep.points import compute_part
from hillobs.studies.sweep.run import engine, sweep, sweep_planned

from .machine import machine

ROUNDS = 5
SIZED = 4_000  # runs whose result is weighed
MANY, FEW = 200_000, 20_000  # runs whose memory is compared
TINY = {"duration": 0.005, "score.start": 0.0, "record": 0.005}
PARTS = 100  # of runs that take no time, to see what a part costs


def main() -> None:
    """Print each figure with its unit; of times, the median of rounds in which all take turns."""
    print("\n".join(machine()))
    for what, size in sizes():
        print(f"{size:8.0f}  {what}")
    large = plan("paper-noisy", {}, PART)
    small = plan("paper-noisy", {}, PARTS * PART, changes=TINY)
    rates: dict[str, list[float]] = {NATIVE: [], PORTABLE: []}
    beside: dict[str, list[float]] = {"threads": [], "a local cluster of one worker": []}
    with ExitStack() as stack:
        engines = [stack.enter_context(engine(1, cluster)) for cluster in (None, "local")]
        for _ in range(ROUNDS + 1):
            for target, measured in rates.items():
                measured.append(rate(large, target))
            for measured, (compute, _) in zip(beside.values(), engines, strict=True):
                measured.append(per_part(small, compute))
    for target, measured in rates.items():
        # the first round compiles, and workers prepare the sweep
        each = statistics.median(measured[1:])
        print(f"{each:8.0f}  runs a second of one core (CPU time), paper-noisy, 20 s, three observers, {target}")
        print(f"{PART / each:8.2f}  s of one core for a part of {PART} runs, {target}")
    for name, measured in beside.items():
        print(f"{1000 * statistics.median(measured[1:]):8.2f}  ms for a part beside its runs, on {name}")


def sizes() -> Iterator[tuple[str, float]]:
    """What is weighed, and bytes."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "x.nc"
        found = sweep("paper-noisy", seeds=SIZED, changes={"duration": 1.0, "score.start": 0.5}, out=out)
        yield "bytes of a run in the result", out.stat().st_size / SIZED
        yield "bytes of a run in the result before compression", found.nbytes / SIZED
        few = _peak(FEW, Path(folder) / "few.nc")
        more = (_peak(MANY, Path(folder) / "many.nc") - few) / (MANY - FEW)
        yield "bytes of memory for a run of one sweep, at the peak", more


def rate(large: Plan, target: str) -> float:
    """Runs per second of CPU time."""
    compiled = compile_loop(large.loop, target)
    before = time.process_time()
    compute_part(large, compiled, 0)
    return PART / (time.process_time() - before)


def per_part(small: Plan, compute: Compute) -> float:
    """Seconds per part that hardly computes anything, but is sent and written."""
    came: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        sweep_planned(
            small, Path(folder) / "x.nc", compute, PORTABLE, lambda done, of: came.append(time.perf_counter())
        )
    return (came[-1] - came[0]) / PARTS


def _peak(runs: int, out: Path) -> float:
    sweep("paper-noisy", seeds=runs, changes=TINY, out=out)
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * (1 if sys.platform == "darwin" else 1024)


if __name__ == "__main__":
    main()
