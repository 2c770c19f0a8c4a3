"""What each erratum changes: the printed forms run beside the corrected ones (docs/errata.md)."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ...codegen.batch import Trace, compile_loop
from ...codegen.failure import Failure
from ...codegen.loop import Loop
from ...codegen.memory import Grid
from ...model.arrays import Array
from ...model.block import Symbols
from ...model.curves import NGUYEN2019, NGUYEN2019_PRINTED
from ...model.signals.pulses import PULSES
from ...model.symbols import QUANTITIES, hat
from ..files.progress import Progress, shares, unseen
from ..scenarios.grid import time_grid
from ..scenarios.layers import Value, layers
from ..scenarios.loops import paper_loop
from ..scenarios.observers import own_observer
from ..scenarios.paths import RUN, paths_of
from ..scenarios.scenario import scenario
from ..simulate.measures import measures
from .printed import ADAPTIVE, CONTROLLER, OBSERVER, Erratum, adaptive_as_printed, backstepping_as_printed, printed_toe


@dataclass(frozen=True)
class Variant:
    """Which errata a run leaves as printed."""

    name: str
    printed: tuple[str, ...]


@dataclass(frozen=True)
class Tracking:
    """How well the controller follows the reference; NaN after a failure."""

    variant: Variant
    largest: float  # max |x₁ − r| from τ = 8 to the end of the paper's run
    rms: float  # the same window
    periodic: float  # max |x₁ − r| over the last common period of r and Δ_Φ, long after
    periodic_rms: float
    amplitude: float  # of r
    failure: str


@dataclass(frozen=True)
class Nearest:
    """The true signal that an estimate is closest to, and the root mean square of what is between them."""

    signal: str
    distance: float


@dataclass(frozen=True)
class Estimation:
    """How well the adaptive observer estimates, and what; NaN after a failure."""

    variant: Variant
    rmse: Mapping[str, float]
    x1_largest: float  # max |x₁ − x̂₁| from score.start on
    nearest: Mapping[str, Nearest]  # by estimate, over the second half of the run
    guards: Mapping[str, float]  # how long limits were active
    failure: str


@dataclass(frozen=True)
class Joint:
    """Φ_S or a derivative at an end of the toe: as printed, as meant, and what double precision adds."""

    where: str
    printed: Fraction
    meant: Fraction
    rounding: float  # largest error of Horner's rule within the toe


Result = Tracking | Estimation | Joint

# "as printed" reads O8's δ_a as δ_a0, which is surely meant; the letter of it is a variant of its own
_READ_AS_MEANT = ("O8",)

_SETTLED, _LONG = 8.0, 100.0
# of sin 0.5τ and sin 0.8τ
_COMMON_PERIOD = 20 * math.pi
_TOE_POINTS = 1001


def errata(progress: Progress = unseen) -> list[Result]:
    """Run every variant of the controller and of the adaptive observer; one compiled library for all."""
    runs: list[tuple[Callable[[Variant, Progress], Result], Variant]] = [
        *((_tracking, variant) for variant in variants(CONTROLLER)),
        *((_estimation, variant) for variant in variants(OBSERVER)),
    ]
    parts = shares(progress, [1] * len(runs))
    results = [study(variant, part) for (study, variant), part in zip(runs, parts, strict=True)]
    return [*results, *joints()]


def variants(errata: Mapping[str, Erratum]) -> list[Variant]:
    """Corrected, as printed, one printed term in the corrected form, one correction in the printed form."""
    names = tuple(name for name in errata if name not in _READ_AS_MEANT)
    return [
        Variant("corrected", ()),
        Variant("as printed", names),
        *(Variant(f"{name} printed", (name,)) for name in errata),
        *(Variant(f"only {name} right", _without(name, names)) for name in names),
    ]


def _without(name: str, names: Sequence[str]) -> tuple[str, ...]:
    return tuple(other for other in names if other != name)


def _tracking(variant: Variant, progress: Progress) -> Tracking:
    changes = {f"controller.{name}": 0.0 for name in variant.printed} | {"duration": _LONG}
    run = _run(changes, (), progress)
    error = np.abs(run.signals["x1"] - run.signals["r"])
    early = error[(run.t >= _SETTLED) & (run.t <= RUN["duration"].default)]
    late = error[run.t >= _LONG - _COMMON_PERIOD]
    return Tracking(
        variant,
        largest=float(early.max()),
        rms=_rms(early),
        periodic=float(late.max()),
        periodic_rms=_rms(late),
        amplitude=run.amplitude,
        failure=_words(run.traces["truth"].failure),
    )


def _estimation(variant: Variant, progress: Progress) -> Estimation:
    run = _run({f"{ADAPTIVE}.{name}": 0.0 for name in variant.printed}, (ADAPTIVE,), progress)
    s, grid, trace = run.signals, run.grid, run.traces[ADAPTIVE]
    end = grid.steps * grid.h
    error = np.abs(s["x1"] - s["x1_hat"])
    return Estimation(
        variant,
        rmse={q: float(e) for q, e in measures(trace.score, grid, QUANTITIES, ["rmse"])["rmse"].items()},
        x1_largest=float(error[run.t >= grid.window * grid.h].max()),
        nearest={hat(name): _nearest(s[hat(name)], signals, run.t >= end / 2) for name, signals in _true(s).items()},
        guards={name: time for name, time in trace.guards.items() if time > 0},
        failure=_words(trace.failure),
    )


def _true(s: Mapping[str, Array]) -> dict[str, dict[str, Array]]:
    """What each estimate of an unknown input may be an estimate of, up to its sign."""
    # ẋ₂ = (y₃ − y₂)/m + Δ_Φ with m = 1,  ẋ₃ = x₂ + u₁,  ẋ₄ = −x₂ + u₂
    return {
        "Delta": _both_signs({"Δ": s["Delta"], "ẋ₂": s["y3"] - s["y2"] + s["Delta"]}),
        "u1": _both_signs({"u₁": s["u1"], "(x₂ + u₁)": s["x2"] + s["u1"]}),
        "u2": _both_signs({"u₂": s["u2"], "(u₂ − x₂)": s["u2"] - s["x2"]}),
    }


def _both_signs(signals: Mapping[str, Array]) -> dict[str, Array]:
    return {**signals, **{f"−{name}": -value for name, value in signals.items()}}


def _nearest(estimate: Array, signals: Mapping[str, Array], window: NDArray[np.bool_]) -> Nearest:
    distances = {name: _rms((estimate - value)[window]) for name, value in signals.items()}
    if any(map(math.isnan, distances.values())):
        return Nearest("nothing", math.nan)
    signal = min(distances, key=lambda name: distances[name])
    return Nearest(signal, distances[signal])


def _rms(error: Array) -> float:
    return math.sqrt(float(np.mean(error**2)))


def _words(failure: Failure | None) -> str:
    return f"diverges at τ = {failure.time:g}" if failure else ""


@dataclass(frozen=True)
class _Run:
    grid: Grid
    amplitude: float
    traces: Mapping[str, Trace]
    signals: Mapping[str, Array]  # all recorded outputs by name

    @property
    def t(self) -> Array:
        """The recorded times."""
        return np.arange(len(next(iter(self.signals.values()))), dtype=np.float64) * (self.grid.record * self.grid.h)


@functools.cache
def _loop() -> Loop:
    loop = paper_loop("virtual", NGUYEN2019, (own_observer(adaptive_as_printed()),), False, backstepping_as_printed())
    return replace(loop, bank=replace(loop.bank, observers=loop.observers[-1:]))


def _run(changes: Mapping[str, Value], observers: Sequence[str], progress: Progress) -> _Run:
    """The paper's first simulation with the printed forms in the loop."""
    loop = _loop()
    paths = paths_of(loop.blocks)
    given = scenario(*layers("paper-clean", changes), paths, {}).given
    grid = time_grid(lambda path: paths.value(path, given), PULSES)
    values = {block.name: paths.values(block, given) for block in loop.blocks}
    traces = compile_loop(loop).run(grid, 0, values, observers, progress)
    outputs = {block.name: block.y for block in loop.blocks}
    signals = {
        name: column for block, trace in traces.items() for name, column in zip(outputs[block], trace.y.T, strict=True)
    }
    return _Run(grid, paths.value("reference.amplitude", given), traces, signals)


def joints() -> list[Joint]:
    """Φ_S, Φ′_S and Φ″_S at both ends of the toe."""
    start, toe, F, k = (Fraction(str(NGUYEN2019.tendon[name].default)) for name in ("L_slack", "toe", "F_toe", "k"))
    flat = Fraction(0)
    meant = {start: (flat, flat, flat), start + toe: (F, k, flat)}
    rounding = [_rounding(order, float(start), float(start + toe)) for order in range(3)]
    return [
        Joint(f"Φ{prime}_S({float(L):g})", printed_toe(L, order), values[order], rounding[order])
        for L, values in meant.items()
        for order, prime in enumerate(("", "′", "″"))
    ]


def _rounding(order: int, start: float, end: float) -> float:
    """Largest error of the printed quintic in double precision, at points that are exact as fractions."""
    L = ca.SX.sym("L")
    p = Symbols({name: ca.SX(parameter.default) for name, parameter in NGUYEN2019_PRINTED.tendon.items()})
    curve = NGUYEN2019_PRINTED.Phi_S(L, p)
    for _ in range(order):
        curve = ca.jacobian(curve, L)
    points = np.linspace(start, end, _TOE_POINTS)[1:-1]
    values = np.array(ca.Function("curve", [L], [curve])(ca.DM(points).T), dtype=float).ravel()
    exact = [printed_toe(Fraction(x), order) for x in points.tolist()]
    return max(abs(float(Fraction(y) - z)) for y, z in zip(values.tolist(), exact, strict=True))
