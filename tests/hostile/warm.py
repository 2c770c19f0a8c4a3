"""A process that has everything loaded: it draws cases and tries them, in forks of itself or in fresh processes."""

from __future__ import annotations

import functools
import gc
import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from hostile.case import Case

_TESTS = Path(__file__).parents[1]
# no thread may run when a process is forked
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


class Warm:
    """The process seen from outside; a context."""

    def __enter__(self) -> Warm:
        paths = os.pathsep.join(str(path) for path in (_TESTS, _TESTS / "faults"))
        self._process = subprocess.Popen(
            [sys.executable, "-m", "hostile.warm"],
            env={**os.environ, **_ONE_THREAD, "PYTHONPATH": paths},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        return self

    def __exit__(self, *_: object) -> None:
        self._process.stdin.close()
        self._process.wait(timeout=60)
        self._process.stdout.close()

    def ask(self, **question: object) -> None:
        """Begin with the case `number` of a `seed`, or with that of some `layers`; `again` tries it twice."""
        print(json.dumps(question), file=self._process.stdin, flush=True)

    def answer(self) -> Mapping[str, Any]:
        """The layers of the case and the verdict on it."""
        line = self._process.stdout.readline()
        if not line:
            raise RuntimeError("the process that tries cases has died")
        return json.loads(line)

    def fileno(self) -> int:
        """To wait for the next answer."""
        return self._process.stdout.fileno()


def _serve() -> None:
    """Answer questions on standard input until it ends."""
    from dataclasses import asdict

    from hostile.case import merged
    from hostile.draw.case import draw
    from hostile.process import adopt_orphans
    from hostile.results import RESULTS, result
    from hostile.trial import tried

    adopt_orphans()
    _load()
    for name in RESULTS:
        result(name)
    gc.freeze()  # a collection in a fork would copy all memory
    for line in sys.stdin:
        asked = json.loads(line)
        layers = asked["layers"] if "layers" in asked else draw(asked["seed"], asked["number"])
        case = merged(layers)
        _prepare(case)
        verdict = tried(case, asked.get("again", False))
        print(json.dumps({"layers": layers, "verdict": asdict(verdict)}), flush=True)


def _prepare(case: Case) -> None:
    """Compile what only some cases need: it takes too long for each fork, and for those who have no such case."""
    verb = case.words[0] if case.words else ""
    if verb == "simulate" and any("hinge" in text for text in (*case.words, *map(str, case.files.values()))):
        _hinge_run()
    elif verb in ("estimate", "live") and "--mechanism" in case.words:
        _hinge_observers()
    elif verb == "calibrate" or (verb == "estimate" and "kalman" in case.words):
        _kalman()


@functools.cache
def _hinge_run() -> None:
    import hillobs
    from hostile.results import SHORT

    hillobs.simulate("hinge", changes=SHORT)


@functools.cache
def _hinge_observers() -> None:
    import hillobs
    from places import RECORDINGS

    hillobs.follow(RECORDINGS / "hinge_pair.toml", "high_gain")


@functools.cache
def _kalman() -> None:
    import hillobs
    from places import RECORDINGS

    hillobs.estimate(RECORDINGS / "dgf_smooth_noisy.csv.gz", RECORDINGS / "dgf_smooth.toml", "kalman")


def _load() -> None:
    """Import what commands import when they are asked for: no fork imports it again."""
    import importlib

    from hillobs.studies.cli.main import _COMMANDS

    for module, _ in _COMMANDS.values():
        importlib.import_module(f"hillobs.studies.cli.{module}")
    # what commands import when they draw
    drawers = [
        f"hillobs.studies.figures.{name}" for name in ("estimate", "observability", "run", "sweep.figures", "tune")
    ]
    backends = [f"matplotlib.backends.backend_{name}" for name in ("agg", "pdf")]
    for name in ("h5netcdf", "scipy.optimize", "scipy.stats.qmc", *drawers, *backends):
        importlib.import_module(name)


if __name__ == "__main__":
    _serve()
