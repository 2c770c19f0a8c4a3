"""The model of the second pass: the activations are chains of integrators, and Hill's law gives the inputs.

A muscle's activation is smoother than its fibre's velocity, so force and velocity tell more of each other. The law is
linear about the estimates of the first pass; an extended filter, which linearises about its own, diverges.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping

import casadi as ca

from ...model.block import Block, Parameter, Parameters, Symbols, symbols
from ...model.dialect import clamp
from ...model.skeleton.load import MASS
from ...model.symbols import STATES, hat
from ...model.system import PAIR, System
from ..behind.activation import activation_parameters, formulas
from ..behind.spread import SPREADS, sd
from ..ports import ESTIMATES
from .chains import Chain, known_acceleration, last_in_use, start
from .exponential import driven
from .inputs import PARAMETERS as OF_INPUTS
from .inputs import SAMPLE, measurements
from .model import Measurement, Model, Move
from .parameters import CHOSEN, NOISE
from .states import LONGEST

CHAINS = {name: (name, f"d{name}", f"dd{name}") for name in ("Delta", "a1", "a2")}
QUANTITIES = (*STATES, *itertools.chain(*CHAINS.values()))
_INDEX = {name: i for i, name in enumerate(QUANTITIES)}
_N = len(QUANTITIES)
# muscle → what its activation follows from, then the activation itself
_LAW = {1: ("x1", "x3", "a1"), 2: ("x1", "x4", "a2")}
# of each muscle: the velocity about which the law is linear, and its slopes
LINE = tuple(f"{name}_{j}" for j in _LAW for name in ("u", *(f"b_{of}" for of in _LAW[j])))
ABOUT = tuple(hat(name) for name in ("x1", "x3", "x4", "a1", "a2"))

# velocities about which the law is linear, in the largest; slopes ∂a/∂u below this are taken for it
SLOWEST, FASTEST, LEAST_SLOPE = -1.5, 0.9, 0.02

# what the line through Hill's law leaves: nothing, where that holds
OF_LAW = ("s_x3", "s_x4")
DENSITIES = ("s_D", "s_a1", "s_a2", *OF_LAW)
PARAMETERS: Parameters = {
    **NOISE,
    "s_D": OF_INPUTS["s_D"],
    "s_a1": Parameter(0.06, "white noise that drives a₁, √ of its density", CHOSEN, above=0),
    "s_a2": Parameter(0.06, "white noise that drives a₂, √ of its density", CHOSEN, above=0),
    "s_x3": Parameter(
        0.01, "white noise of ẋ₃, √ of its density: what the line through Hill's law leaves", CHOSEN, above=0
    ),
    "s_x4": Parameter(
        0.01, "white noise of ẋ₄, √ of its density: what the line through Hill's law leaves", CHOSEN, above=0
    ),
    "order_D": OF_INPUTS["order_D"],
    "order_a": Parameter(
        2, "which derivative of a₁ and a₂ is the white noise", CHOSEN, least=1, most=LONGEST, whole=True
    ),
    **{name: OF_INPUTS[name] for name in ("start_sigma", "start_x2", "start_D")},
    "start_a": Parameter(0.3, "sd of a₁ and a₂ at the start", CHOSEN, above=0),
    "start_rate": OF_INPUTS["start_rate"],
    "m": MASS,
}


def linear_law(system: System = PAIR) -> Block:
    """Inputs: the estimates of a pair; outputs: LINE, and the activations a1_hat, a2_hat there, not limited."""
    u, parameters = symbols(ESTIMATES), activation_parameters(system)
    p, y, activations = symbols(parameters), Symbols(), Symbols()
    for j, f in enumerate(formulas(system, u, p), start=1):
        drive = clamp(u[f"u{j}_hat"], SLOWEST * f.speed, FASTEST * f.speed)
        states = ca.vertcat(u.x1_hat, u[f"x{j + 2}_hat"])
        slopes = ca.substitute(ca.jacobian(f.a, ca.vertcat(states, f.drive)), f.drive, drive)
        # u − û = b (x − x̂, a − â),  b = (−∂a/∂x, 1)/(∂a/∂u)
        steepness = ca.fmax(slopes[2], LEAST_SLOPE)
        values = (drive, -slopes[0] / steepness, -slopes[1] / steepness, 1 / steepness)
        y |= dict(zip((name for name in LINE if name.endswith(str(j))), values, strict=True))
        activations[f"a{j}_hat"] = ca.substitute(f.a, f.drive, drive)
    return Block("linear_law", u=u, p=p, parameters=parameters, y=Symbols({**y, **activations}))


def _inputs(j: int, was: Symbols, now: Symbols) -> tuple[list[ca.SX], ca.SX, ca.SX]:
    """u_j of the law: its slopes, the same at both ends, and the rest at each."""
    slopes = [(was[f"b_{of}_{j}"] + now[f"b_{of}_{j}"]) / 2 for of in _LAW[j]]

    def rest(at: Symbols) -> ca.SX:
        # û − b (x̂, â)
        return at[f"u_{j}"] - sum(b * at[hat(of)] for b, of in zip(slopes, _LAW[j], strict=True))

    return slopes, rest(was), rest(now)


def _move(was: Symbols, now: Symbols, p: Symbols) -> Move:
    T = now.t - was.t
    pulls = [(was[f"slope{j}"] + now[f"slope{j}"]) / 2 / p.m for j in (1, 2)]
    A, ends = ca.SX(_N, _N), [ca.SX(_N, 1), ca.SX(_N, 1)]
    # ẋ₁ = x₂,  ẋ₂ = acc + (p₂(x₄ − z₂) − p₁(x₃ − z₁))/m + Δ
    A[_INDEX["x1"], _INDEX["x2"]] = A[_INDEX["x2"], _INDEX["Delta"]] = 1
    A[_INDEX["x2"], _INDEX["x3"]], A[_INDEX["x2"], _INDEX["x4"]] = -pulls[0], pulls[1]
    for w, at in zip(ends, (was, now), strict=True):
        w[_INDEX["x2"]] = known_acceleration(at, *pulls)
    # ẋ₃ = x₂ + u₁,  ẋ₄ = −x₂ + u₂
    for j, way in ((1, 1), (2, -1)):
        row = _INDEX[f"x{j + 2}"]
        A[row, _INDEX["x2"]] = way
        slopes, *rests = _inputs(j, was, now)
        for slope, of in zip(slopes, _LAW[j], strict=True):
            A[row, _INDEX[of]] += slope
        for w, rest in zip(ends, rests, strict=True):
            w[row] = rest
    for chain in CHAINS.values():
        for before, after in itertools.pairwise(chain):
            A[_INDEX[before], _INDEX[after]] = 1
    F, b = driven(A, ends[0], ends[1], T)
    return Move([F], b, T, ca.SX(_N, 1))


def _start(now: Symbols, p: Symbols) -> tuple[ca.SX, ca.SX]:
    chains = zip(_orders(p), (p.start_D, p.start_a, p.start_a), strict=True)
    mean, variance = start(_measurements(now, p), chains, p, _INDEX)
    for name in ("a1", "a2"):
        mean[_INDEX[name]] = clamp(now[hat(name)], 0, 1)
    return mean, variance


def _measurements(now: Symbols, p: Symbols) -> list[Measurement]:
    return measurements(now, p, _INDEX)


def _orders(p: Symbols) -> list[Chain]:
    return list(zip(CHAINS.values(), (p.order_D, p.order_a, p.order_a), strict=True))


def _noise(p: Symbols) -> Mapping[str, ca.SX]:
    chains = dict(zip(("s_D", "s_a1", "s_a2"), (last_in_use(chain, _INDEX) for chain in _orders(p)), strict=True))
    alone = {f"s_{name}": ca.SX.eye(_N)[:, _INDEX[name]] for name in ("x3", "x4")}
    return Symbols({**chains, **alone}).only(DENSITIES)


def _told(mean: ca.SX, P: ca.SX, now: Symbols) -> Symbols:
    """The estimates with activations, not limited, and the standard deviations of all."""
    values = Symbols({name: mean[i] for name, i in _INDEX.items()})
    rows = {name: ca.SX.eye(_N)[i, :] for name, i in _INDEX.items()}
    for j in _LAW:
        slopes, _, rest = _inputs(j, now, now)
        # u = b (x, a) + …
        rows[f"u{j}"] = sum((b * rows[of] for b, of in zip(slopes, _LAW[j], strict=True)), ca.SX(1, _N))
        values[f"u{j}"] = rows[f"u{j}"] @ mean + rest
    # L_Cj = ±x₁ − x_{j+2} + …
    rows |= {"L_C1": rows["x1"] - rows["x3"], "L_C2": -rows["x1"] - rows["x4"]}
    spreads = {sd(name): ca.sqrt(ca.fmax(rows[name] @ P @ rows[name].T, 0)) for name in rows if sd(name) in SPREADS}
    estimates = {name: values[name.removesuffix("_hat")] for name in (*ESTIMATES, "a1_hat", "a2_hat")}
    return Symbols({**estimates, **{name: spreads[name] for name in SPREADS}})


ACTIVATIONS_MODEL = Model(QUANTITIES, (*SAMPLE, *ABOUT, *LINE), PARAMETERS, _start, _move, _noise, _measurements, _told)
