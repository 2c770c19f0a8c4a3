"""A linear model of the pair as the Kalman filter and its smoother take it: states, motion, noise, measurements."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import casadi as ca

from ...model.block import Parameters, Symbols


@dataclass(frozen=True)
class Move:
    """From sample to sample: x⁻ = F x + b, with F as factors, the last one first applied.

    Q: densities of white noise (n × 1) that are known, beside those that are parameters.
    """

    F: Sequence[ca.SX]
    b: ca.SX
    T: ca.SX
    Q: ca.SX

    def mean(self, x: ca.SX) -> ca.SX:
        """x⁻ of the mean x (n × 1)."""
        for factor in reversed(self.F):
            x = factor @ x
        return x + self.b

    def noise(self, densities: ca.SX) -> ca.SX:
        """What white noise adds meanwhile (n × n), these densities (n × 1) and the known ones."""
        return ca.diag(densities + self.Q) * self.T


@dataclass(frozen=True)
class Measurement:
    """State `i` was measured as `value`, with noise of variance R."""

    i: int
    value: ca.SX
    R: ca.SX


@dataclass(frozen=True, eq=False)  # compared by identity: SX has no usable ==
class Model:
    """All functions take what is known at a sample, `inputs` by name, and the parameters.

    noise: name of a √density → which states (n × 1 of 0 and 1) that white noise drives.
    told: what follows from a mean and a covariance, by name.
    """

    quantities: tuple[str, ...]
    inputs: tuple[str, ...]
    parameters: Parameters
    start: Callable[[Symbols, Symbols], tuple[ca.SX, ca.SX]]  # mean, variances
    move: Callable[[Symbols, Symbols, Symbols], Move]  # from the sample before
    noise: Callable[[Symbols], Mapping[str, ca.SX]]
    measurements: Callable[[Symbols, Symbols], Sequence[Measurement]]
    told: Callable[[ca.SX, ca.SX, Symbols], Symbols]

    def densities(self, p: Symbols) -> ca.SX:
        """The diagonal of Q (n × 1)."""
        return sum((p[s] ** 2 * driven for s, driven in self.noise(p).items()), ca.SX(len(self.quantities), 1))
