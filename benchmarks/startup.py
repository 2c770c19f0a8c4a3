"""What commands cost as a user starts them, warm: libraries are compiled, byte code is written."""

from __future__ import annotations

import os
import resource
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from functools import partial
from pathlib import Path

from hillobs.studies.scenarios.prepare import prepare
from hillobs.studies.simulate.run import simulate_prepared

from .timing import ROUNDS, clock

_RUN = ("simulate", "paper-clean")
COMMANDS: Mapping[str, tuple[str, ...]] = {
    "hillobs --help": ("--help",),
    "hillobs list": ("list",),
    "hillobs show paper-noisy": ("show", "paper-noisy"),
    "hillobs simulate paper-clean --no-figures": (*_RUN, "--no-figures"),
    "hillobs simulate paper-clean": _RUN,
    "make sim": ("simulate",),
}


def seconds() -> dict[str, float]:
    """Command → CPU seconds, user's and system's: the median of rounds in which all take turns, after a first one.

    The last is no command: what one of them spends on its run and on the one at h/2.
    """
    spent: dict[str, list[float]] = {name: [] for name in COMMANDS}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(ROUNDS + 1):
            for name, words in COMMANDS.items():
                spent[name].append(_cost(words, Path(folder)))
    run = partial(simulate_prepared, prepare("paper-clean", None, {}))
    spent["of paper-clean: its run, and the one at h/2"] = [clock(run) for _ in range(ROUNDS + 1)]
    return {name: statistics.median(rounds[1:]) for name, rounds in spent.items()}


def _cost(words: tuple[str, ...], folder: Path) -> float:
    # byte code has a place of its own: an environment may forbid to write it beside the sources
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": str(folder / "bytecode")}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(
        [sys.executable, "-m", "hillobs", *words], cwd=folder, env=environment, check=True, stdout=subprocess.DEVNULL
    )
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
