"""What looks wrong in a recording before any likelihood is asked: units, sensors that are dead, limits."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...model.arrays import Array
from ...model.skeleton import lengths
from ..estimate.case import Case
from .finding import Finding

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
# innovations over their standard deviations: mean square, and correlation from sample to sample
_SIZE, _COLOUR = (0.7, 1.4), 0.25
# a ratio from here on has no decimals
_TEN = 10.0
# noise below this, in F₀, is that of digits
_NO_NOISE = 1e-6


def of_measurements(case: Case) -> Iterator[Finding]:
    """Of positions and forces as they are."""
    sigmas = case.sizes.sigma_1, case.sizes.sigma_F1, case.sizes.sigma_F2
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
    L_m = np.stack(lengths(case.y[:, 0], case.scales.numbers["plant.C"]), axis=1)
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


def of_estimates(case: Case, acc: Array, Delta: Array, limited: Sequence[float]) -> Iterator[Finding]:
    """Of what a filter makes of them: acc, what the forces do to the mass (n); Delta, the rest (n)."""
    explained, rest = float(np.std(acc)), float(np.std(Delta))
    # forces that stand still explain nothing, whatever the mass
    if explained and rest > _UNEXPLAINED * explained:
        ratio = rest / explained
        yield Finding(
            "acceleration",
            f"the mass accelerates {_times(ratio)} as much as the forces explain: it may be smaller, or the forces may "
            "be in kN",
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


def of_innovations(ratios: Array, noise: float) -> Finding:
    """ratios: innovations over their standard deviations (n × 3); noise: that of the forces, in F₀."""
    if noise < _NO_NOISE:
        return Finding("innovations", "there is no noise to speak of, so innovations tell nothing", noise)
    size = np.mean(ratios**2, axis=0)
    colour = np.array([np.corrcoef(r[1:], r[:-1])[0, 1] if r.std() else 1.0 for r in ratios.T])
    wrong = bool((size < _SIZE[0]).any() or (size > _SIZE[1]).any() or (np.abs(colour) > _COLOUR).any())
    sentence = (
        f"innovations over their standard deviations: mean square {', '.join(f'{s:.2f}' for s in size)} (1 is right), "
        f"correlation from sample to sample {', '.join(f'{c:.2f}' for c in colour)} (0 is right)"
    )
    return Finding("innovations", sentence, float(np.max(np.abs(size - 1))), wrong)


def _stands_still(signal: Array, sigma: float) -> bool:
    return float(np.std(signal)) <= _STILL * sigma or not np.ptp(signal)


def _still(name: str, why: str, signal: Array) -> Finding:
    return Finding(name.partition("_")[0], f"{name} stands still within its noise: {why}", float(np.ptp(signal)), True)


def _times(ratio: float) -> str:
    """`3.2 times`, `1,200 times`."""
    return f"{ratio:,.0f} times" if ratio >= _TEN else f"{ratio:.1f} times"
