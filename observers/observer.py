"""What an observer brings with it beside its equations: conditions, gains for a recording, and how fast it is."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import casadi as ca

from ..model.block import Block, BlockError, Symbols
from ..model.limits import STABLE
from ..model.system import PAIR, System
from .chained import Chains, chained, views
from .conditions import Condition, Conditions, below, each_once


@dataclass(frozen=True)
class Sizes:
    """How noisy, how fast and how large a recording is; lengths, forces and times in the paper's units."""

    sigma_1: float  # noise of y₁
    sigma_F1: float  # noise of y₂ and y₃
    sigma_F2: float
    sigma_L1: float  # noise of the tendon lengths that these tell
    sigma_L2: float
    eps_1: float  # ε of the chain of x̂₁
    eps_L: float  # ε of the chains of x̂₃ and x̂₄, of order 2
    eps_L3: float  # the same, of order 3
    D: float  # Δ_Φ, root mean square
    D_max: float
    U: float  # u₁ and u₂, root mean square
    U_max: float

    @property
    def sigma_L(self) -> float:
        """Noise of both tendon lengths."""
        return math.sqrt(self.sigma_L1 * self.sigma_L2)


@dataclass(frozen=True)
class JointSizes:
    """Of a joint: noise of its position, ε of its chain, root mean square and largest of Δ; in the system's units."""

    sigma: float
    eps: float
    D: float
    D_max: float


@dataclass(frozen=True)
class MuscleSizes:
    """Of a muscle: noise of its force and of the length that this tells, ε of chains of order 2 and 3, sizes of u.

    In the system's units.
    """

    sigma_F: float
    sigma_L: float
    eps_2: float
    eps_3: float
    U: float
    U_max: float


@dataclass(frozen=True)
class SystemSizes:
    """The same of all joints and muscles of a system, by name."""

    joints: Mapping[str, JointSizes]
    muscles: Mapping[str, MuscleSizes]

    def of(self, joint: str, *muscles: str) -> Sizes:
        """Those of a joint and of one or two muscles; of two, which share one observer, u is that of both."""
        j, (first, second) = self.joints[joint], (self.muscles[name] for name in (muscles[0], muscles[-1]))
        noise = (j.sigma, first.sigma_F, second.sigma_F, first.sigma_L, second.sigma_L)
        return Sizes(*noise, j.eps, first.eps_2, first.eps_3, j.D, j.D_max, first.U, first.U_max)

    def near(self, of: str) -> Sizes:
        """Those of a joint and the first muscle, or of a muscle and the first joint."""
        joint, muscle = next(iter(self.joints)), next(iter(self.muscles))
        return self.of(of, muscle) if of in self.joints else self.of(joint, of)

    @property
    def pair(self) -> Sizes:
        """Those of a mass between two muscles."""
        (mass,) = self.joints
        return self.of(mass, *self.muscles)


# name → rate, symbolic in the observer's parameters
Rates = Callable[[Symbols], Mapping[str, ca.SX]]
# (sizes, sampling period T in τ) → name → value; what is not named keeps its default
Gains = Callable[[Sizes, float], Mapping[str, float]]


def no_rates(p: Symbols) -> Mapping[str, ca.SX]:
    """The rates of an observer that moves at samples only: it asks for no step in between."""
    return {}


@dataclass(frozen=True)
class Observer:
    """What the registry knows of an observer; a Block alone is one without conditions, gain rule and known rates."""

    label: str  # what tables and figures call it
    chains: Callable[[bool], Chains] | None = None  # what it is made of, with corrected layers or without
    whole: Callable[[], Block] | None = None  # one that is not made of chains, and so is for the pair alone
    theorem: Conditions = lambda p, facts: []
    gains: Gains = lambda sizes, T: {}
    rates: Rates | None = None  # its fastest; None: to be found from ∂ẋ/∂x
    limit: float = STABLE  # largest h · rate of an RK4 step
    period: str = ""  # its number that is the sampling period, if it has one
    fitted: bool = False  # a recording is passed as a whole, to find its numbers by likelihood and to smooth
    apart: Callable[[System], Block] | None = None  # of other systems, what follows from its filters over a recording
    tuned: tuple[str, ...] = ()  # the numbers that `tune` changes; none: all positive ones of its own

    def block(self, corrected: bool = False, system: System = PAIR) -> Block:
        """The observer of a system, its layers, if it has any, `corrected` or not.

        BlockError if it is for the pair alone.
        """
        if self.chains:
            return chained(self.chains(corrected), system)
        if self.whole is None or not system.paper:
            beside = "; of a mechanism it follows recordings, and no runs" if self.apart else ""
            raise BlockError(
                f"{self.label} is an observer of a mass between two muscles; it is not made of chains{beside}"
            )
        return self.whole()

    def gains_of(self, system: System, sizes: SystemSizes, T: float) -> dict[str, float]:
        """The gains for a recording of a system: chain by chain, by the names that the observer has for it."""
        if system.paper or not self.chains:
            return dict(self.gains(sizes.pair, T))
        made_of = self.chains(True)
        chain_of = {**dict.fromkeys(system.joints, made_of.joint), **dict.fromkeys(system.muscles, made_of.muscle)}
        return {
            f"{of}.{name}": value
            for of, chain in chain_of.items()
            for name, value in self.gains(sizes.near(of), T).items()
            if name in chain.p
        }

    def views(self, system: System, p: Symbols) -> dict[str, Symbols]:
        """Joint or muscle → the numbers that a rate or a theorem of the pair takes, of all numbers p of an observer."""
        if system.paper or not self.chains:
            return {"": p}
        of = views(self.chains(True), system)
        return {
            name: Symbols({key: p[number] for key, number in view.items() if number in p}) for name, view in of.items()
        }

    def rates_of(self, system: System, p: Symbols) -> Mapping[str, ca.SX] | None:
        """All rates of the observer of a system, by words; None if they are to be found from ∂ẋ/∂x."""
        if self.rates is None:
            return None
        return {
            f"{of}: {name}" if of else name: rate
            for of, view in self.views(system, p).items()
            for name, rate in self.rates(view).items()
        }

    def theorems(self, system: System, p: Symbols, facts: Symbols) -> dict[str, list[Condition]]:
        """What its theorem asks of the gains, by joint or muscle; of the pair of all together."""
        asked = {}
        for of, view in self.views(system, p).items():
            conditions = self.theorem(view, facts)
            if of:
                # about numbers of this joint or muscle, and not its neighbour's alone
                own = ca.vertcat(*(symbol for name, symbol in p.items() if name.startswith(f"{of}.")))
                conditions = each_once([c for c in conditions if ca.depends_on(ca.vertcat(c.left, c.right), own)])
                conditions = [replace(condition, name=f"{of}: {condition.name}") for condition in conditions]
            asked[of] = conditions
        return asked

    def conditions(self, system: System, p: Symbols, facts: Symbols) -> list[Condition]:
        """What its theorem and the integration step h ask of the gains."""
        steps = [
            below(f"h {name} < {self.limit:g} (integration)", facts.h * rate, self.limit)
            for name, rate in (self.rates_of(system, p) or {}).items()
        ]
        return [*itertools.chain.from_iterable(self.theorems(system, p, facts).values()), *steps]
