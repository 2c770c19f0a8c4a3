"""The equations as printed beside the corrected ones: what each erratum changes (docs/errata.md)."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import casadi as ca
import numpy as np
from numpy.typing import NDArray
from rich.table import Table
from rich.text import Text

from ..codegen.batch import Failure, Grid, Trace
from ..codegen.export import Loop
from ..codegen.library import Array
from ..model.backstepping import PARAMETERS, riccati
from ..model.block import Block, Parameter, Symbols, symbols
from ..model.curves import NGUYEN2019, NGUYEN2019_PRINTED, TENDON, CurveSet, per_muscle
from ..model.dialect import clamp, outside, sg
from ..model.symbols import MUSCLES, hat
from ..observers.adaptive_sliding_mode import adaptive_sliding_mode
from ..observers.ports import output_errors
from .measures import measures
from .report import number
from .scenario import Value, read, scenario
from .simulate import Progress, compile_loop, paper_loop, time_grid
from .table import RUN, table


@dataclass(frozen=True)
class Erratum:
    """One printed term: its label in the paper, what is printed there and what it must be."""

    where: str
    printed: str
    correct: str


CONTROLLER = {
    "C1": Erratum("ζ", "ζ = … − m ṙ", "− m r̈: only then ė = Ae + Bζ"),
    "C2": Erratum("ẇ, [kappa], β", "β = … + m r̈", "+ m r‴, the derivative of m r̈"),
    "C3": Erratum("[kappa], β", "β = … − (Φ′_S1 + Φ′_S2) x₂", "+ (Φ′_S1 + Φ′_S2) x₂: ẋ₃ = x₂ + u₁, ẋ₄ = −x₂ + u₂"),
    "C4": Erratum("β", "β without Δ̇_Φ", "β = … − m Δ̇_Φ"),
}
OBSERVER = {
    "O2": Erratum("[AO1b]", "x̂̇₂ = β_a sign(e₁)", "+ (y₃ − y₂)/m"),
    "O3": Erratum("[AO1c]", "τ_a Δ̂̇ = −Δ̂ − β_a sign(e₁)", "+ β_a sign(e₁)"),
    "O4": Erratum("[AO2a], [AO3a]", "x̂̇₃, x̂̇₄ without x̂₂", "+ x̂₂ in x̂̇₃, − x̂₂ in x̂̇₄"),
    "O5": Erratum("[AO2b], [AO3b]", "τ_a û̇_j = −û_j − (k_j + η_j) sign(·)", "+ (k_j + η_j) sign(·)"),
    "O8": Erratum("[dotla]", "l̇_a = −ρ_a0 sign(δ_a), δ_a = 0.01 > 0 a constant", "sign(δ_a0)"),
}
# "as printed" reads O8's δ_a as δ_a0, which is surely meant; the letter of it is a variant of its own
_READ_AS_MEANT = ("O8",)
_ADAPTIVE = "adaptive_as_printed"

# the six decimals of [PhiSj], highest power first
PRINTED_TOE = ("6760794.14", "-68434261.19", "277072371.99", "-560875494.46", "567666340.97", "-229806913.40")


def _switches(errata: Mapping[str, Erratum]) -> dict[str, Parameter]:
    return {
        name: Parameter(1.0, f"1: {erratum.correct}; 0: {erratum.printed}, as printed", "docs/errata.md")
        for name, erratum in errata.items()
    }


def backstepping_as_printed(curves: CurveSet = NGUYEN2019) -> Block:
    """The controller with the ports of `backstepping()`; C1…C4 are 1 for the corrected term, 0 for the printed."""
    u = symbols("x1 x2 x3 x4 r dr ddr dddr Delta dDelta")
    parameters = {**PARAMETERS, **per_muscle(curves.tendon), **_switches(CONTROLLER)}
    p = symbols(parameters)
    m = p.m
    Phi_S1, Phi_S2 = (curves.Phi_S(x, p.part(name)) for x, name in zip((u.x3, u.x4), MUSCLES, strict=True))
    slope1, slope2 = ca.jacobian(Phi_S1, u.x3), ca.jacobian(Phi_S2, u.x4)
    e = ca.vertcat(u.x1 - u.r, u.x2 - u.dr)
    A, B = ca.SX([[0, 1], [0, 0]]), ca.vertcat(0, 1 / m)
    K, P = riccati(p)

    # ζ = Φ_S2 − Φ_S1 + mΔ_Φ − m ṙ   printed;  − m r̈   C1
    zeta = Phi_S2 - Phi_S1 + m * u.Delta - m * _either(p.C1, u.ddr, u.dr)
    # K₁ = γ + K B,  K₂ = K A + γ K + BᵀP
    K1, K2 = p.gamma + K @ B, K @ A + p.gamma * K + B.T @ P
    # β = −K₁ζ − K₂e − (Φ′_S2 + Φ′_S1) x₂ + m r̈   printed;  + (…) x₂ C3,  − mΔ̇_Φ C4,  + m r‴ C2
    beta = -K1 * zeta - K2 @ e + _either(p.C3, 1, -1) * (slope1 + slope2) * u.x2
    beta += -p.C4 * m * u.dDelta + m * _either(p.C2, u.dddr, u.ddr)

    # u₁ = −Φ′_S1 β/Δ,  u₂ = Φ′_S2 β/Δ   printed;  pretension and limits as in `backstepping()`
    Delta = slope1**2 + slope2**2
    floor = ca.fmax(Delta, p.Delta_min)
    tension = p.k_c * (p.F_c - (Phi_S1 + Phi_S2) / 2) / floor
    u1, u2 = -slope1 * beta / floor + tension * slope2, slope2 * beta / floor + tension * slope1
    return Block(
        "controller",
        u=u,
        p=p,
        parameters=parameters,
        y=Symbols(u1=clamp(u1, -p.u_max, p.u_max), u2=clamp(u2, -p.u_max, p.u_max), zeta=zeta),
        guards=Symbols(
            u1_limit=outside(u1, -p.u_max, p.u_max),
            u2_limit=outside(u2, -p.u_max, p.u_max),
            both_slack=Delta < p.Delta_min,
        ),
    )


def adaptive_as_printed(curves: CurveSet = NGUYEN2019) -> Block:
    """The adaptive observer; O2…O5 and O8 are 1 for the corrected term, 0 for the printed."""
    right = adaptive_sliding_mode(curves)
    x, u = right.x, right.u
    p = Symbols({**right.p, **symbols(OBSERVER)})
    e1, e3, e4 = output_errors(x, u, p, curves)
    L = ca.fmax(p.l0 + x.l_a, p.L_min)
    v1 = p.beta0 * L * sg(e1, p.delta_a)
    v3 = (clamp(x.k_1, 0, p.k_max) + p.eta1) * sg(e3, p.delta_a)
    v4 = (clamp(x.k_2, 0, p.k_max) + p.eta2) * sg(e4, p.delta_a)
    # l̇_a = −ρ_a0 sign(δ_a)   [dotla] printed, δ_a the boundary layer's width;  sign(δ_a0) O8
    fall = -(p.r00 + x.r_a0) * sg(p.delta_a, p.delta_a) * (p.l0 + x.l_a > p.L_min)
    dl_a = _either(p.O8, right.dx.l_a, fall)
    changed = Symbols(
        # x̂̇₁ = x̂₂ + α_a|e₁|^½ sign(e₁) − φ,  φ = −(l̇_a/L_a) e₁   [AO1a] is right, but l̇_a may not be
        x1_hat=right.dx.x1_hat + (dl_a - right.dx.l_a) / L * e1,
        # x̂̇₂ = β_a sign(e₁)   [AO1b] printed;  + (y₃ − y₂)/m O2
        x2_hat=v1 + p.O2 * (u.y3 - u.y2) / p.m,
        # Δ̂̇ = (−Δ̂ − β_a sign(e₁)) / τ_a   [AO1c] printed;  + O3
        Delta_hat=(-x.Delta_hat + _either(p.O3, 1, -1) * v1) / p.tau_a,
        # x̂̇₃ = (k₁ + η₁) sign(e₃)   [AO2a] printed;  + x̂₂ O4
        x3_hat=v3 + p.O4 * x.x2_hat,
        # û̇₁ = (−û₁ − (k₁ + η₁) sign(e₃)) / τ_a   [AO2b] printed;  + O5
        u1_hat=(-x.u1_hat + _either(p.O5, 1, -1) * v3) / p.tau_a,
        # x̂̇₄ = (k₂ + η₂) sign(e₄)   [AO3a] printed;  − x̂₂ O4
        x4_hat=v4 - p.O4 * x.x2_hat,
        # û̇₂ = (−û₂ − (k₂ + η₂) sign(e₄)) / τ_a   [AO3b] printed;  + O5
        u2_hat=(-x.u2_hat + _either(p.O5, 1, -1) * v4) / p.tau_a,
        l_a=dl_a,
    )
    return replace(
        right,
        name=_ADAPTIVE,
        p=p,
        parameters={**right.parameters, **_switches(OBSERVER)},
        dx=Symbols({**right.dx, **changed}),
    )


def _either(switch: ca.SX, corrected: ca.SX | float, printed: ca.SX | float) -> ca.SX:
    return switch * corrected + (1 - switch) * printed


def printed_toe(L: Fraction, order: int = 0) -> Fraction:
    """The printed quintic of [PhiSj], or its derivative of the order given, in exact arithmetic."""
    powers = range(len(PRINTED_TOE) - 1, order - 1, -1)
    terms = zip(PRINTED_TOE, powers, strict=False)
    return sum((Fraction(c) * math.perm(n, order) * L ** (n - order) for c, n in terms), Fraction(0))


@dataclass(frozen=True)
class Variant:
    """Which errata a run leaves as printed, and what these say."""

    name: str
    printed: tuple[str, ...]
    sentence: str


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

_SETTLED, _LONG = 8.0, 100.0
# of sin 0.5τ and sin 0.8τ
_COMMON_PERIOD = 20 * math.pi
_TOE_POINTS = 1001


def errata(progress: Progress = lambda done: None) -> list[Result]:
    """Run every variant of the controller and of the adaptive observer; one compiled library for all."""
    runs: list[tuple[Callable[[Variant, Progress], Result], Variant]] = [
        *((_tracking, variant) for variant in variants(CONTROLLER)),
        *((_estimation, variant) for variant in variants(OBSERVER)),
    ]
    results: list[Result] = []
    for i, (study, variant) in enumerate(runs):
        results.append(study(variant, _share(progress, i, len(runs))))
    return [*results, *joints()]


def _share(progress: Progress, i: int, n: int) -> Progress:
    return lambda done: progress((i + done) / n)


def variants(errata: Mapping[str, Erratum]) -> list[Variant]:
    """Corrected, as printed, one printed term in the corrected form, one correction in the printed form."""
    every = tuple(name for name in errata if name not in _READ_AS_MEANT)
    return [
        Variant("corrected", (), ""),
        Variant("as printed", every, "; ".join(errata[name].printed for name in every)),
        *(Variant(f"{name} printed", (name,), _sentence(erratum)) for name, erratum in errata.items()),
        *(Variant(f"only {name} right", _without(name, every), _sentence(errata[name])) for name in every),
    ]


def _without(name: str, every: Sequence[str]) -> tuple[str, ...]:
    return tuple(other for other in every if other != name)


def _sentence(erratum: Erratum) -> str:
    return f"{erratum.where}: printed {erratum.printed}; must be {erratum.correct}"


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
    run = _run({f"{_ADAPTIVE}.{name}": 0.0 for name in variant.printed}, (_ADAPTIVE,), progress)
    s, grid, trace = run.signals, run.grid, run.traces[_ADAPTIVE]
    points, end = grid.steps - grid.window + 1, grid.steps * grid.h
    error = np.abs(s["x1"] - s["x1_hat"])
    return Estimation(
        variant,
        rmse={name: m.rmse for name, m in measures(trace.score, points, grid.h, end).items()},
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
    loop = paper_loop("virtual", NGUYEN2019, (adaptive_as_printed(),), backstepping_as_printed())
    return replace(loop, observers=loop.observers[-1:])


def _run(changes: Mapping[str, Value], observers: Sequence[str], progress: Progress) -> _Run:
    """The paper's first simulation with the printed forms in the loop."""
    loop = _loop()
    every = table(loop.blocks)
    given = scenario(*read("paper-clean"), changes, every).given
    grid = time_grid(lambda path: every.value(path, given))
    values = {block.name: every.values(block, given) for block in loop.blocks}
    traces = compile_loop(loop).run(grid, 0, values, observers, progress)
    outputs = {block.name: block.y for block in loop.blocks}
    signals = {
        name: column for block, trace in traces.items() for name, column in zip(outputs[block], trace.y.T, strict=True)
    }
    return _Run(grid, every.value("reference.amplitude", given), traces, signals)


def joints() -> list[Joint]:
    """Φ_S, Φ′_S and Φ″_S at both ends of the toe."""
    start, toe, F, k = (Fraction(str(TENDON[name].default)) for name in ("L_slack", "toe", "F_toe", "k"))
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


def tables(results: Sequence[Result]) -> Iterator[Table]:
    """What is printed and must be, then a table for each kind of result."""
    yield _legend()
    yield _tracking_table([row for row in results if isinstance(row, Tracking)])
    estimations = [row for row in results if isinstance(row, Estimation)]
    yield _estimation_table(estimations)
    yield _nearest_table(estimations)
    yield _joint_table([row for row in results if isinstance(row, Joint)])


def _legend() -> Table:
    rows = [(name, e.where, e.printed, e.correct) for name, e in (CONTROLLER | OBSERVER).items()]
    return _table("What is printed", ("", "where", "printed", "must be"), rows, left=4)


def _tracking_table(results: Sequence[Tracking]) -> Table:
    head = ("controller", "max, τ ≥ 8", "rms", "max for ever", "rms", "of r's amplitude")
    rows = []
    for r in results:
        errors = [number(value) for value in (r.largest, r.rms, r.periodic, r.periodic_rms)]
        rows.append((r.variant.name, *errors, r.failure or f"{r.periodic / r.amplitude:.2%}"))
    return _table("Tracking error |x₁ − r|", head, rows)


def _estimation_table(results: Sequence[Estimation]) -> Table:
    quantities = ("x2", "Delta", "u1", "u2", "a1")
    head = ("observer", "max |e₁|", *(f"rmse {name}" for name in quantities), "limits active")
    rows = [
        (
            r.variant.name,
            number(r.x1_largest),
            *(number(r.rmse[name]) for name in quantities),
            r.failure or _limits(r.guards),
        )
        for r in results
    ]
    return _table("Errors of the adaptive sliding mode observer (as printed: O8 read as meant)", head, rows)


def _limits(guards: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {number(time)}" for name, time in guards.items())


def _nearest_table(results: Sequence[Estimation]) -> Table:
    head = ("observer", "Δ̂ is", "û₁ is", "û₂ is")
    rows = [(r.variant.name, *(f"{n.signal} ± {number(n.distance)}" for n in r.nearest.values())) for r in results]
    return _table("What its estimates are (± root mean square of the difference)", head, rows, left=4)


def _joint_table(results: Sequence[Joint]) -> Table:
    head = ("toe of Φ_S", "printed, exact", "meant", "rounding in double precision")
    rows = [(r.where, f"{float(r.printed):.12g}", f"{float(r.meant):g}", number(r.rounding)) for r in results]
    return _table("The printed decimals of Φ_S", head, rows)


def _table(title: str, head: Sequence[str], rows: Iterable[Sequence[str]], left: int = 1) -> Table:
    """A plain table; the first `left` columns are words. Text, because labels like [dotla] are no markup."""
    result = Table(title=title, title_justify="left", box=None, padding=(0, 1, 0, 0))
    for i, name in enumerate(head):
        result.add_column(Text(name), justify="left" if i < left else "right", no_wrap=i == 0)
    for row in rows:
        result.add_row(*map(Text, row))
    return result
