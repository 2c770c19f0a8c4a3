"""The two passes over a recording: the filter forwards, and the smoother of Bryson and Frazier backwards.

Backwards λ and Λ are carried instead of a state: x_s = x⁻ − P⁻λ, P_s = P⁻ − P⁻ΛP⁻. No covariance is inverted, and
the score of the likelihood comes with them: ∂log L/∂(s²) = ½ Σ T(λ_i² − Λ_ii), over the states i that s drives.
Source: A. E. Bryson and M. Frazier, Smoothing for linear and nonlinear dynamic systems, 1963.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from ...model.block import symbols
from .model import Model, Move
from .states import packed, unpacked
from .update import Update, measured, predicted, symmetric

# beside the inputs of a model, a sample has these: 1 where something was measured, 1 where it counts for the likelihood
FLAGS = ("seen", "counted")


@dataclass(frozen=True)
class Sizes:
    """Of the vectors that the passes exchange: states, entries of a covariance, measurements, densities."""

    states: int
    covariance: int
    measurements: int
    densities: int


class Passes:
    """The functions of both passes, for one model."""

    def __init__(self, model: Model) -> None:
        self._model, self._p = model, symbols(model.parameters)
        self._was, self._now = (symbols([*model.inputs, *FLAGS]) for _ in range(2))
        self._move = model.move(self._was, self._now, self._p)
        self._moved, self._given = _unknown(self._move)
        self._driven = list(model.noise(self._p).values())
        n = len(model.quantities)
        measurements = model.measurements(self._now, self._p)
        self.sizes = Sizes(n, n * (n + 1) // 2, len(measurements), len(self._driven))
        # names of what is told
        self.told = tuple(model.told(ca.SX(n, 1), ca.SX(n, n), self._now))

    def start(self) -> ca.Function:
        """(p, sample) → what `forward` carries to the first sample."""
        mean, variances = self._model.start(self._now, self._p)
        carry = ca.densify(ca.vertcat(mean, packed(ca.diag(variances))))
        return ca.Function("start", [self._p.vector(), self._now.vector()], [carry])

    def motion(self) -> ca.Function:
        """(p, nothing, sample before, sample) → nothing, the motion between them: it knows of no density."""
        move = self._move
        entries = ca.vertcat(*(ca.SX(matrix.nz[:]) for matrix in (*move.F, move.b, move.Q)), move.T)
        return self._scan("motion", ca.SX(0, 1), [self._was.vector(), self._now.vector()], ca.SX(0, 1), entries)

    def forward(self) -> ca.Function:
        """(p, carry, motion, sample) → carry, (x⁻, P⁻, ν of each measurement, S of each, what is told of x⁺, P⁺)."""
        n, move = self.sizes.states, self._moved
        carry = ca.SX.sym("carry", n + self.sizes.covariance)
        P = predicted(unpacked(carry[n:], n), move.F, move.noise(self._model.densities(self._p)))
        x = move.mean(carry[:n])
        updates = self._updates(x, P)
        after = updates[-1]
        innovations = [ca.vertcat(*(update.nu for update in updates)), ca.vertcat(*(update.S for update in updates))]
        told = self._model.told(after.x, after.P, self._now).vector()
        result = ca.vertcat(x, packed(P), *innovations, told)
        return self._scan(
            "forward", carry, [self._given, self._now.vector()], ca.vertcat(after.x, packed(after.P)), result
        )

    def backward(self) -> ca.Function:
        """(p, carry, motion, sample, x⁻ and P⁻) → carry, what is told of x_s and P_s.

        The carry is λ, Λ, and for each density ΣTλ_i², ΣTΛ_ii.
        """
        n, size, move = self.sizes.states, self.sizes.covariance, self._moved
        carry = ca.SX.sym("carry", n + size + 2 * self.sizes.densities)
        predictions = ca.SX.sym("predictions", n + size)
        adjoint, Adjoint, sums = carry[:n], unpacked(carry[n : n + size], n), carry[n + size :]
        x, P = predictions[:n], unpacked(predictions[n:], n)
        for update in reversed(self._updates(x, P)):
            # λ_i ← λ_i − Kᵀλ − ν/S,  Λ ← (I − K e_iᵀ)ᵀ Λ (I − K e_iᵀ) + e_i e_iᵀ/S
            i, LK = update.i, Adjoint @ update.K
            adjoint[i] -= update.K.T @ adjoint + self._now.seen * update.nu / update.S
            row = Adjoint[:, i] - LK
            row[i] += update.K.T @ LK - LK[i] + self._now.seen / update.S
            Adjoint[:, i], Adjoint[i, :] = row, row.T
        # x_s = x⁻ − P⁻λ,  P_s = P⁻ − P⁻ΛP⁻
        told = self._model.told(x - P @ adjoint, symmetric(P - P @ Adjoint @ P), self._now).vector()
        # half of QT comes after the motion, half before
        weight = self._now.counted * move.T / 2
        sums += weight * self._score(adjoint, Adjoint)
        for factor in move.F:
            # λ ← Fᵀλ,  Λ ← FᵀΛF
            adjoint, Adjoint = factor.T @ adjoint, symmetric(factor.T @ Adjoint @ factor)
        sums += weight * self._score(adjoint, Adjoint)
        carried = ca.vertcat(adjoint, packed(Adjoint), sums)
        return self._scan("backward", carry, [self._given, self._now.vector(), predictions], carried, told)

    def _score(self, adjoint: ca.SX, Adjoint: ca.SX) -> ca.SX:
        return ca.vertcat(
            *(ca.dot(states, terms) for states in self._driven for terms in (adjoint**2, ca.diag(Adjoint)))
        )

    def _updates(self, x: ca.SX, P: ca.SX) -> list[Update]:
        updates: list[Update] = []
        for measurement in self._model.measurements(self._now, self._p):
            updates.append(measured(x, P, measurement, self._now.seen))
            x, P = updates[-1].x, updates[-1].P
        return updates

    def _scan(self, name: str, carry: ca.SX, rows: Sequence[ca.SX], carried: ca.SX, result: ca.SX) -> ca.Function:
        inputs = [self._p.vector(), carry, *rows]
        return ca.Function(name, inputs, ca.cse([ca.densify(carried), ca.densify(result)]))


def _unknown(move: Move) -> tuple[Move, ca.SX]:
    """A motion of the same structure whose entries are symbols, and these in the order of `motion`."""
    matrices = [ca.SX.sym("F", factor.sparsity()) for factor in move.F]
    b, Q, T = ca.SX.sym("b", move.b.sparsity()), ca.SX.sym("Q", move.Q.sparsity()), ca.SX.sym("T")
    return Move(matrices, b, T, Q), ca.vertcat(*(ca.vertcat(*ca.symvar(matrix)) for matrix in (*matrices, b, Q)), T)
