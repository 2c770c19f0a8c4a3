"""What an observer brings with it beside its equations: conditions, gains for a recording, and how fast it is."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import casadi as ca

from ..model.block import Block, BlockError, Symbols
from ..model.limits import STABLE
from ..model.system import PAIR, System
from .chained import Chains, chained
from .conditions import Condition, Conditions, below


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
    fitted: bool = False  # a recording is passed as a whole, to find its numbers by likelihood and to smooth

    def block(self, corrected: bool = False, system: System = PAIR) -> Block:
        """The observer of a system, its layers, if it has any, `corrected` or not.

        BlockError if it is for the pair alone.
        """
        if self.chains:
            return chained(self.chains(corrected), system)
        if self.whole is None or not system.paper:
            raise BlockError(f"{self.label} is an observer of a mass between two muscles; it is not made of chains")
        return self.whole()

    def conditions(self, p: Symbols, facts: Symbols) -> list[Condition]:
        """What its theorem and the integration step h ask of the gains."""
        rates = self.rates(p) if self.rates else {}
        steps = [
            below(f"h {name} < {self.limit:g} (integration)", facts.h * rate, self.limit)
            for name, rate in rates.items()
        ]
        return [*self.theorem(p, facts), *steps]
