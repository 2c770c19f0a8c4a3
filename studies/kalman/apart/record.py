"""A recording of a mechanism as the filters of its joints and muscles take it."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ....model.arrays import Array
from ....model.symbols import hat
from ....observers.kalman.apart.activations import LAW_MODEL, LINE
from ....observers.kalman.apart.integrators import JOINT_MODEL, MUSCLE_MODEL
from ....observers.kalman.parameters import noise
from ....observers.observer import SystemSizes
from ...laboratory.laws import Laws
from ..muscles import TENDONS, compiled_muscles
from ..passes import row_names, table

# of noise that nothing makes last
_ANY_POLE = 1.0


@dataclass(frozen=True, eq=False)
class Motion:
    """What is known of the joints at each sample: coordinates, velocities, variances of these (n × joints)."""

    laws: Laws
    q: Array
    dq: Array
    variance: Array

    @functools.cached_property
    def rates(self) -> Array:
        """Of the lengths of all muscles (n × muscles)."""
        # L̇_m = −Rᵀq̇
        return self.laws.rates(self.q, self.dq)

    @functools.cached_property
    def moved(self) -> Array:
        """The variances of these."""
        # Rᵀ σ² R
        return np.asarray((self.laws.moment_arms(self.q) ** 2 @ self.variance[:, :, None])[:, :, 0])


@dataclass(frozen=True, eq=False)
class Forces:
    """Tendon forces (n × muscles) and, if their noise lasts, the frequency of the low pass in each joint (joints)."""

    F: Array
    poles: Array | None = None


@dataclass(frozen=True, eq=False)
class RecordApart:
    """Times τ (n), measurements y (n × positions and forces), tendon lengths z and slopes (n × muscles), gaps.

    seen: where something was measured; numbers: values of the filter's parameters by name; T: sampling period; sizes:
    what the first pass found.
    """

    tau: Array
    y: Array
    z: Array
    slopes: Array
    seen: NDArray[np.bool_]
    numbers: Mapping[str, float]
    sizes: SystemSizes
    T: float
    laws: Laws

    def __len__(self) -> int:
        return len(self.tau)

    @property
    def joints(self) -> tuple[str, ...]:
        """Their names."""
        return self.laws.system.joints

    @property
    def muscles(self) -> tuple[str, ...]:
        """Their names."""
        return self.laws.system.muscles

    @property
    def measured(self) -> Motion:
        """What positions tell alone, at rest."""
        q = self.y[:, : len(self.joints)]
        return Motion(self.laws, q, np.zeros_like(q), np.zeros_like(q))

    @property
    def forces(self) -> Forces:
        """As they were measured."""
        return Forces(self.y[:, len(self.joints) :])

    @property
    def sigma_F(self) -> Array:
        """Noise of each force."""
        return np.array([noise(self.sizes.near(of), self.T)["sigma_F1"] for of in self.muscles])

    def about(self, lengths: Array) -> RecordApart:
        """The record with tendons that are linear about these lengths (n × muscles), not about measured forces."""
        system = self.laws.system
        given = dict(zip(map(hat, system.muscle("L_S")), lengths.T, strict=True))
        given |= dict(zip(system.muscle("y"), self.forces.F.T, strict=True))
        lines = compiled_muscles(system).outputs(TENDONS, self.numbers, given)
        z, slopes = (np.stack([lines[name] for name in system.muscle(s)], axis=1) for s in ("z", "slope"))
        return replace(self, z=z, slopes=slopes)

    def of_joints(self, at: Motion, forces: Forces) -> dict[str, Array]:
        """The table of each joint, with accelerations about a motion."""
        acc = self.laws.accelerations(at.q, at.dq, forces.F)
        density = self.T * self.laws.acceleration_variances(at.q, forces.F, self.sigma_F)
        none = np.zeros(len(self))
        seen = self.seen.astype(float)
        tables = {}
        for j, of in enumerate(self.joints):
            white, lasting = (density[:, j], none) if forces.poles is None else (none, density[:, j])
            pole = _ANY_POLE if forces.poles is None else float(forces.poles[j])
            columns = {"t": self.tau, "y": self.y[:, j], "acc": acc[:, j], "white": white, "lasting": lasting}
            columns |= {"pole": none + pole, "seen": seen, "counted": seen}
            tables[of] = table(JOINT_MODEL, columns)
        return tables

    def of_muscles(self, at: Motion) -> dict[str, Array]:
        """The table of each muscle, which goes along with a motion."""
        return self._of_rates(at.rates)

    def of_tendons(self) -> dict[str, Array]:
        """The same of tendons alone, whatever the joints do."""
        return self._of_rates(np.zeros_like(self.z))

    def _of_rates(self, rates: Array) -> dict[str, Array]:
        forces, tables = self.forces.F, {}
        for m, of in enumerate(self.muscles):
            # a slack tendon tells no length: its noise is not that of the force
            counted = self.seen & (forces[:, m] > 0)
            columns = {"t": self.tau, "z": self.z[:, m], "slope": self.slopes[:, m], "rate": rates[:, m]}
            columns |= {"seen": self.seen.astype(float), "counted": counted.astype(float)}
            tables[of] = table(MUSCLE_MODEL, columns)
        return tables

    def of_law(self, muscles: Mapping[str, Array], law: Mapping[str, Array]) -> dict[str, Array]:
        """The tables of the second pass; law: `BRA.u` and so on, about which Hill's law is linear (n)."""
        return {
            of: table(
                LAW_MODEL,
                {
                    **dict(zip(row_names(MUSCLE_MODEL), rows.T, strict=True)),
                    **{name: law[f"{of}.{name}"] for name in LINE},
                },
            )
            for of, rows in muscles.items()
        }
