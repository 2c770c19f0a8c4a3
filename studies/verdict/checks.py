"""What looks wrong in a recording before any likelihood is asked: units, sensors that are dead, limits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...model.arrays import Array
from ..estimate.case import Case
from .finding import Finding, plain
from .hanging import hanging

# subjects of what no muscle measures
UNMEASURED = ("force", "position", "fibre")
# forces below this part of F_max are no forces of a muscle that works, or not in newtons
_LEAST_FORCE = 0.005
# optimal fibre lengths that a fibre can have, and the share of samples that may lie beyond
_SHORTEST, _LONGEST, _SHARE = 0.3, 1.9, 0.05
# a signal whose standard deviation is below so many of that of its noise stands still
_STILL = 2.0
# share of samples whose activation may be at a limit
_LIMITED = 0.1
# the rest of the acceleration, over that which the forces explain
_UNEXPLAINED = 3.0


def of_measurements(case: Case) -> Iterator[Finding]:
    """Of positions and forces as they are: what no muscle measures."""
    sizes = case.sizes.pair
    sigmas = sizes.sigma_1, sizes.sigma_F1, sizes.sigma_F2
    if _stands_still(case.y[:, 0], sigmas[0]):
        yield _still("position", "a broken sensor?", case.y[:, 0])
    for j, muscle in enumerate((case.pair.muscle1, case.pair.muscle2), start=1):
        force = case.y[:, j]
        largest = float(np.max(force)) * case.scales.force / muscle.F_max
        if not force.any():
            yield Finding("force", f"force_{j} is 0 throughout: a dead sensor, or a muscle that is slack", 0.0, True)
        elif largest < _LEAST_FORCE:
            yield Finding(
                "force",
                f"force_{j} is never above {largest:.2g} F_max of its muscle: it may be in kN, or F_max is another",
                largest,
                True,
            )
        elif _stands_still(force, sigmas[j]):
            yield _still(f"force_{j}", "a dead sensor or amplifier?", force)
    L_m = case.subject.laws.lengths(case.y[:, :1])
    for j, muscle in enumerate((case.pair.muscle1, case.pair.muscle2), start=1):
        fibre = (L_m[:, j - 1] - case.z[:, j - 1]) * case.scales.length / muscle.optimal_fibre_length
        beyond = float(np.mean((fibre < _SHORTEST) | (fibre > _LONGEST)))
        if beyond > _SHARE:
            yield Finding(
                "fibre",
                f"fibre {j} would be {np.median(fibre):.2g} optimal lengths long (median): position or a length of the "
                "muscle file may be in another unit, such as mm",
                beyond,
                True,
            )


def of_sensors(case: Case) -> Iterator[Finding]:
    """Of sensors that do not measure all the time."""
    for i, name in enumerate(case.recording.measured):
        if when := hanging(case.recording.time, case.y[:, i], case.period):
            start, end = when
            yield Finding(
                "sensor",
                f"{name} is the same number from {start:.4g} to {end:.4g} s, without its noise: a sensor that hangs, "
                "or is at the end of its range",
                end - start,
                True,
                when,
            )


def of_estimates(pull: Array, rest: Array, limited: Sequence[float]) -> Iterator[Finding]:
    """Of what a filter makes of them: both forces together (n), the external force (n), N; which share is limited."""
    explained, unexplained = float(np.std(pull)), float(np.std(rest))
    # forces that stand still explain nothing, whatever the mass
    if explained and unexplained > _UNEXPLAINED * explained:
        ratio = unexplained / explained
        yield Finding(
            "acceleration",
            f"the mass accelerates {plain(ratio)} times as much as the forces explain: it may be smaller, or the "
            "forces may be in kN",
            ratio,
            True,
        )
    for j, share in enumerate(limited, start=1):
        if share > _LIMITED:
            yield Finding(
                "limited",
                f"activation {j} is at a limit in {share:.0%} of the samples: F_max, a length of the muscle or "
                "its curves may be another",
                share,
                True,
            )


def _stands_still(signal: Array, sigma: float) -> bool:
    return float(np.std(signal)) <= _STILL * sigma or not np.ptp(signal)


def _still(name: str, why: str, signal: Array) -> Finding:
    return Finding(name.partition("_")[0], f"{name} stands still within its noise: {why}", float(np.ptp(signal)), True)
