"""What there is: scenarios, observers, curve sets, parameters."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Iterator

from ....model.curves import CURVES
from ....observers import OBSERVERS
from ...scenarios.layers import shipped
from ...scenarios.loops import all_paths
from ...scenarios.show import describe
from ...scenarios.world import CHOICES


def listing(what: str) -> Iterator[str]:
    """The lines of `hillobs list`: all, scenarios, observers, curves or parameters."""
    parts = {"scenarios": _scenarios, "observers": _observers, "curves": _curves, "parameters": _parameters}
    for name, lines in parts.items():
        if what in ("all", name):
            yield f"{name}:"
            yield from (f"  {line}" for line in lines())
            yield ""


def _scenarios() -> Iterator[str]:
    for name, text in shipped().items():
        yield f"{name:12} {tomllib.loads(text)['description']}"


def _observers() -> Iterator[str]:
    for name, observer in OBSERVERS.items():
        yield f"{name:22} {observer.label}: {_first_line((observer.chains or observer.whole).__module__)}"


def _first_line(module: str) -> str:
    return (sys.modules[module].__doc__ or "").strip().splitlines()[0]


def _curves() -> Iterator[str]:
    for name, curves in CURVES.items():
        yield f"{name:20} {curves.sentence} ({curves.source})"
        yield f"{'':20} {', '.join(f'{key} {number.default:g}' for key, number in curves.parameters.items())}"


def _parameters() -> Iterator[str]:
    paths = all_paths()
    yield f"{'path':44} {'default':>10}  meaning [unit, where it is not 1] (source)"
    for path, valid in CHOICES.items():
        yield f"{path:44} {valid[0]:>10}  one of {', '.join(valid)}"
    shown = {path: parameter for path, parameter in paths.parameters.items() if parameter.shared in ("", path)}
    yield from (f"{path:44} {p.default:>10.6g}  {describe(p)}" for path, p in shown.items())
    yield "Other curves have other numbers in the place of the paper's: `hillobs list curves`."
    yield "`muscle.k` sets muscle1.k and muscle2.k; likewise all of muscle, and pulse. In one file or on one command"
    yield "line muscle1.k wins over muscle.k, whatever their order; a command line wins over a file."
    yield "An observer or the controller may have its own m, C, muscle.…, initial.…: high_gain.m, controller.muscle1.k."
