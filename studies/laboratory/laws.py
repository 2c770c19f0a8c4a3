"""What a system says of numbers: lengths, accelerations and forces of many samples at once."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np
from numpy.typing import ArrayLike

from ...model.arrays import Array
from ...model.block import Symbols
from ...model.skeleton.paths import moment_arms
from ...model.system import System

# samples at which the noise of accelerations is told
_FEW = 100


class Laws:
    """Of a system with these numbers, by the names that it has for them, as in `p`; all dimensionless."""

    def __init__(self, system: System, numbers: Mapping[str, float]) -> None:
        self.system = system
        self.p = p = Symbols({name: ca.SX(numbers[name]) for name in system.parameters})
        q, dq, Delta = ([ca.SX.sym(f"{kind}_{of}") for of in system.joints] for kind in ("q", "dq", "Delta"))
        F = [ca.SX.sym(f"F_{of}") for of in system.muscles]
        columns = [ca.vertcat(*values) for values in (q, dq, F, Delta)]
        acc = ca.vertcat(*system.accelerations(q, dq, F, p))
        lengths = ca.vertcat(*system.lengths(q, p))
        self._lengths = ca.Function("lengths", columns[:1], [lengths])
        self._accelerations = ca.Function("accelerations", columns[:3], [acc])
        self._rates = ca.Function("rates", columns[:2], [ca.vertcat(*system.rates(q, dq, p))])
        self._arms = ca.Function("arms", columns[:1], [ca.vec(ca.densify(moment_arms(lengths, columns[0])))])
        self._gain = ca.Function("gain", columns[:3], [ca.vec(ca.densify(ca.jacobian(acc, columns[2])))])
        forces = ca.vertcat(*system.forces(q, Delta, p))
        self._forces = ca.Function("forces", [columns[0], columns[3]], [forces])

    def lengths(self, q: Array) -> Array:
        """L_m (… × muscles) at coordinates (… × joints)."""
        return mapped(self._lengths, [q])

    def rates(self, q: Array, dq: Array) -> Array:
        """L̇_m (… × muscles) at coordinates and velocities (… × joints)."""
        return mapped(self._rates, [q, dq])

    def moment_arms(self, q: Array) -> Array:
        """R (… × muscles × joints): what each tendon's force does to each joint."""
        return mapped(self._arms, [q]).reshape(*q.shape[:-1], len(self.system.muscles), len(self.system.joints))

    def forces(self, q: Array, Delta: Array) -> Array:
        """Of each joint (… × joints), that make these accelerations."""
        return mapped(self._forces, [q, Delta])

    def places(self, q: Array) -> dict[str, Array]:
        """What can follow a reference (…), by name, at coordinates (… × joints)."""
        return {name: mapped(function, [q])[..., 0] for name, function in self._places.items()}

    # of simulations only
    @functools.cached_property
    def _places(self) -> dict[str, ca.Function]:
        q = [ca.SX.sym(of) for of in self.system.joints]
        return {name: ca.Function("place", [ca.vertcat(*q)], [at]) for name, at in self.system.places(q).items()}

    def accelerations(self, q: Array, dq: Array, F: Array) -> Array:
        """What tendon forces (… × muscles) make of the joints (… × joints)."""
        return mapped(self._accelerations, [q, dq, F])

    def acceleration_noise(self, q: Array, F: Array, sigmas: ArrayLike) -> Array:
        """Variance of each joint's acceleration from noise of the forces, in the mean over samples (n × …).

        That of the pair is left out: its sensors' forces are precise beside its mass.
        """
        if self.system.paper:
            return np.zeros(len(self.system.joints))
        few = slice(None, None, max(1, len(q) // _FEW))
        return np.asarray(self.acceleration_variances(q[few], F[few], sigmas).mean(axis=0))

    def acceleration_variances(self, q: Array, F: Array, sigmas: ArrayLike) -> Array:
        """The same of each sample (n × joints)."""
        # (∂α/∂F)² σ_F²
        return np.asarray(self._gains(q, F) ** 2 @ np.asarray(sigmas) ** 2)

    def acceleration_shares(self, q: Array, F: Array, sigmas: ArrayLike) -> Array:
        """What each force has in it, in the mean over samples (joints × muscles)."""
        few = slice(None, None, max(1, len(q) // _FEW))
        return np.asarray((self._gains(q[few], F[few]) ** 2 * np.asarray(sigmas) ** 2).mean(axis=0))

    def _gains(self, q: Array, F: Array) -> Array:
        """∂α/∂F (n × joints × muscles)."""
        flat = mapped(self._gain, [q, 0 * q, F])
        return flat.reshape(len(q), len(self.system.muscles), len(self.system.joints)).transpose(0, 2, 1)


def mapped(function: ca.Function, columns: Sequence[Array]) -> Array:
    """A function of columns, for the last axis of arrays."""
    shape = columns[0].shape
    flat = [np.ascontiguousarray(values.reshape(-1, values.shape[-1]).T) for values in columns]
    results = np.array(function(*flat), dtype=float).T
    return results.reshape(*shape[:-1], results.shape[-1])
