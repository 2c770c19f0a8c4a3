"""What is known of a muscle's numbers before a trial."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...model.arrays import Array
from ...model.block import Parameter, Parameters
from ...observers.behind.sensitivity import muscle_numbers
from ..laboratory.muscles import SCALED, SIZES, Muscle, numbers_of

_CHOSEN = "chosen, docs/calibrate.md#what-is-known-before"
# relative standard deviations of numbers that were taken from a table or scaled from another body
PRIORS: Parameters = {
    name: Parameter(default, f"how far {what} may be off before trials, as a part of it", _CHOSEN, above=0, most=1)
    for name, default, what in (
        ("F_max", 0.2, "the largest isometric force"),
        ("optimal_fibre_length", 0.1, "the optimal fibre length"),
        ("tendon_slack_length", 0.03, "the tendon slack length"),
        ("v_max", 0.2, "the largest shortening velocity"),
        ("tendon_strain", 0.2, "the strain of the tendon"),
        ("passive_strain", 0.15, "the strain of the passive fibre"),
        # what the curves of the paper have instead of strains
        ("k", 0.2, "the stiffness of the tendon"),
        ("k_P", 0.45, "the stiffness of the parallel element, the inverse cube of a strain"),
    )
}


@dataclass(frozen=True, eq=False)
class Prior:
    """The numbers of a muscle that trials may change, by the keys of a file.

    theta: all its `muscle_numbers` in SI; places: of these numbers among them; parts: relative standard deviations.
    """

    keys: tuple[str, ...]
    units: tuple[str, ...]
    theta: Array
    places: tuple[int, ...]
    parts: Array

    @property
    def values(self) -> Array:
        """The numbers in SI, all above 0."""
        return np.asarray(self.theta[list(self.places)])

    def moved(self, xi: Array) -> Array:
        """All `muscle_numbers` when those of `keys` are ξ of their standard deviations away."""
        theta = self.theta.copy()
        # θ = θ₀ exp(r ξ): a size has a sign
        theta[list(self.places)] *= np.exp(self.parts * xi)
        return theta


def prior(muscle: Muscle) -> Prior:
    """Standard deviations of the muscle's file count; where it has none those of PRIORS, if there is one."""
    units = {key: parameter.unit for key, parameter in {**SIZES, **numbers_of(muscle.curves)}.items()}
    parts = {key: _part(muscle, key) for key in muscle.values}
    keys = tuple(key for key, part in parts.items() if part)
    names = muscle_numbers(muscle.curves, bool(muscle.pennation))
    own: Mapping[str, float] = {**muscle.values, **muscle.sizes}
    return Prior(
        keys,
        tuple(units.get(key, "rad") for key in keys),
        np.array([own[name] for name in names]),
        tuple(names.index(SCALED.get(key, key)) for key in keys),
        np.array([parts[key] for key in keys]),
    )


def _part(muscle: Muscle, key: str) -> float:
    """r of a number; 0 of one that is 0, such as a damping that is not, or that nobody doubts."""
    value = abs(muscle.values[key])
    if not value:
        return 0.0
    return muscle.sds[key] / value if key in muscle.sds else PRIORS[key].default if key in PRIORS else 0.0
