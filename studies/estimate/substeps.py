"""How many RK4 steps an observer needs from sample to sample, by its fastest rate.

The constants and what they were measured on: docs/gains.md.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence

from ...model.block import Parameters
from ...observers import FOLLOWERS
from ..files.errors import ScenarioError
from ..files.quote import shown

# RK4 is stable up to 2.78 on the real axis; 10 % margin
STABLE = 2.5
# step of the high gain observer in ε; near 1, still stable, RK4 alone makes an error that noise-free data show
ACCURATE = 0.75
# more means that the gains belong to other data
_MOST = 1000
# decimal fractions as doubles
_ROUNDING = 1e-9
# largest slope of |e|^½ e/(δ + |e|), times √δ
_SLOPE = 0.55
# L may grow to 2.25 l₀ while it is followed
_GROWN = 1.5

# the number of a name
_Values = Callable[[str], float]


def substeps(observer: str, gains: Mapping[str, float], T: float) -> int:
    """RK4 steps in a sampling period T with these gains (path → value), given by the rule or by hand.

    What is not given has its default. ScenarioError if no reasonable number of steps will do.
    """
    if observer not in _RATES:
        raise ScenarioError(f"there is no substep rule for {shown(observer)}, only for {', '.join(_RATES)}")
    about = _about(observer)

    def value(name: str) -> float:
        shared = gains.get(about[name].shared, about[name].default)
        found = gains.get(f"{observer}.{name}", shared)
        if name.startswith("delta") and found <= 0:
            raise ScenarioError(f"{observer}.{name} = {found:g} has no fastest rate; a recording needs a layer above 0")
        return found

    rates, step = _RATES[observer]
    n = T * max(rates(value)) / step
    if n > _MOST:
        raise ScenarioError(
            f"the gains of {observer} are too fast for samples {T:.3g} apart: they ask for {n:.3g} steps in between, "
            f"{_MOST} at most"
        )
    return max(1, math.ceil(n - _ROUNDING))


@functools.cache
def _about(observer: str) -> Parameters:
    return FOLLOWERS[observer](True).parameters


def _pole(value: _Values, eps: str, gains: Sequence[str]) -> float:
    """1/ε for binomial gains; for others the rate of a multiple pole that has as much of one of their coefficients."""
    k = len(gains)
    # (s + 1)ᵏ has the coefficients C(k, i)
    return max(math.pow(abs(value(h)) / math.comb(k, i), 1 / i) for i, h in enumerate(gains, 1)) / value(eps)


def _high_gain(value: _Values) -> Iterator[float]:
    yield _pole(value, "eps_h", ("h11", "h12", "h13"))
    yield _pole(value, "eps_L", ("h21", "h22"))
    yield _pole(value, "eps_L", ("h31", "h32"))


def _high_gain_3(value: _Values) -> Iterator[float]:
    yield _pole(value, "eps_h", ("h11", "h12", "h13"))
    yield _pole(value, "eps_L", ("h21", "h22", "h23"))
    yield _pole(value, "eps_L", ("h31", "h32", "h33"))


def _sliding_mode(value: _Values) -> Iterator[float]:
    # slopes of v₂, v₃ and v₁₁; bandwidth √(α₁₁/δ_s)
    yield max(value("alpha2"), value("alpha3")) / value("delta_L")
    yield _SLOPE * value("lambda11") / math.sqrt(value("delta_s"))
    yield math.sqrt(value("alpha11") / value("delta_s"))
    yield 1 / value("tau_s")
    yield 1 / value("tau_c")


def _adaptive_sliding_mode(value: _Values) -> Iterator[float]:
    yield (value("k_max") + max(value("eta1"), value("eta2"))) / value("delta_L")
    # α₀√L and β₀L, with L grown
    yield _GROWN * _SLOPE * value("alpha0") * math.sqrt(value("l0") / value("delta_1"))
    yield _GROWN * math.sqrt(value("beta0") * value("l0") / value("delta_1"))
    yield (max(value("r00"), value("r01"), value("r02")) + value("r_max")) / value("delta_a")
    yield 1 / value("tau_a")
    yield 1 / value("tau_c")


# rates of an observer; its step in them
_RATES: Mapping[str, tuple[Callable[[_Values], Iterator[float]], float]] = {
    "high_gain": (_high_gain, ACCURATE),
    "high_gain_3": (_high_gain_3, ACCURATE),
    "sliding_mode": (_sliding_mode, STABLE),
    "adaptive_sliding_mode": (_adaptive_sliding_mode, STABLE),
}
