"""How long a muscle is over the joints that it crosses: a polynomial of their coordinates."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import casadi as ca

from .tree import TreeError

# coefficients below this part of the largest are rounding of a fit: a sum f(q₁) + g(q₂) has no mixed terms
_ROUNDING = 1e-11


@dataclass(frozen=True)
class Path:
    """L = Σ coefficient Π q_jᵉ over the `terms`, which are exponents e → coefficient, one for each of `joints`.

    L is in m, angles in rad.
    """

    joints: tuple[str, ...]
    terms: Mapping[tuple[int, ...], float]

    def length(self, q: Mapping[str, ca.SX]) -> ca.SX:
        """L_m at the coordinates q, by the joint's name."""
        variables = [q[joint] for joint in self.joints]
        return _horner({powers: ca.SX(number) for powers, number in self.terms.items()}, variables)

    def scaled(self, length: float, coordinates: Mapping[str, float]) -> Path:
        """The same with lengths in this unit, and coordinates in those by the joint's name."""
        units = [coordinates[joint] for joint in self.joints]
        terms = {
            powers: number * math.prod(unit**power for unit, power in zip(units, powers, strict=True)) / length
            for powers, number in self.terms.items()
        }
        return Path(self.joints, terms)


def exponents(order: int, count: int) -> Iterator[tuple[int, ...]]:
    """All tuples of `count` exponents with a sum of at most `order`, the last rising fastest."""
    if not count:
        yield ()
        return
    for first in range(order + 1):
        for others in exponents(order - first, count - 1):
            yield (first, *others)


def polynomial(joints: Sequence[str], order: int, coefficients: Sequence[float]) -> Path:
    """A path, in m over rad, from the coefficients of all exponents of the joints with a sum of at most `order`.

    The exponents are sorted, the last joint's rising fastest. TreeError if there are not as many coefficients.

    >>> hillobs.polynomial(["elbow"], 2, [0.3, -0.04, 0.001])
    Path(joints=('elbow',), terms={(0,): 0.3, (1,): -0.04, (2,): 0.001})
    """
    if order < 0:
        raise TreeError(f"the order of a polynomial must be at least 0, not {order}")
    terms = math.comb(order + len(joints), order)
    if len(coefficients) != terms:
        raise TreeError(
            f"a polynomial of order {order} in {', '.join(joints) or 'no joint'} has {terms} coefficients, "
            f"not {len(coefficients)}"
        )
    powers = exponents(order, len(joints))
    least = _ROUNDING * max(map(abs, coefficients), default=0.0)
    return Path(tuple(joints), {e: c for e, c in zip(powers, coefficients, strict=True) if abs(c) > least})


def constant_moment_arms(length: float, moment_arms: Mapping[str, float]) -> Path:
    """L = length − Σ r_j q_j, in m: moment_arms are the r_j in m, by joint; a positive one shortens as the joint turns.

    >>> hillobs.constant_moment_arms(0.3, {"elbow": 0.04})
    Path(joints=('elbow',), terms={(0,): 0.3, (1,): -0.04})
    """
    joints = tuple(moment_arms)
    terms = {tuple(int(other == joint) for other in joints): -arm for joint, arm in moment_arms.items()}
    return Path(joints, {(0,) * len(joints): length, **terms})


def moment_arms(lengths: ca.SX, q: ca.SX) -> ca.SX:
    """R (coordinates × muscles) of muscle lengths at coordinates: what a tendon's force does to each."""
    # R_jm = −∂L_m/∂q_j
    return -ca.jacobian(lengths, q).T


def _horner(terms: Mapping[tuple[int, ...], ca.SX], variables: Sequence[ca.SX]) -> ca.SX:
    """The polynomial, nested in the first variable, its coefficients nested in the others."""
    if not variables:
        return terms.get((), ca.SX(0))
    by_power: dict[int, dict[tuple[int, ...], ca.SX]] = {}
    for (power, *others), number in terms.items():
        by_power.setdefault(power, {})[tuple(others)] = number
    total = ca.SX(0)
    for power in range(max(by_power, default=0), -1, -1):
        total = total * variables[0] + _horner(by_power.get(power, {}), variables[1:])
    return total
