"""What trials cannot tell: directions in which a muscle's numbers stay as uncertain as they were.

In the standard deviations of what was known before, the covariance is 1 without a trial and (1 + information)⁻¹ with
some; its eigenvectors are told, or not, one independent of the other.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...model.arrays import Array

# a direction of which more is left is not told; a number with a smaller share in it is no part of it
UNTOLD, _SHARE = 0.5, 0.3
# a number of which more is left stands alone: in directions that are equally open any others would join it
_ALONE = 0.95
# number → the trial that tells it
_CURES: Mapping[str, str] = {
    "F_max": "a maximal contraction at the length of the largest force",
    "optimal_fibre_length": "maximal contractions at lengths on both sides of the largest force",
    "tendon_slack_length": "maximal contractions at several lengths, beside a passive stretch",
    "passive_strain": "a slow passive stretch until the muscle pulls with a tenth of F_max or more",
    "v_max": "a maximal contraction during which the rig lets the muscle shorten, and stretches it",
    "tendon_strain": "a passive stretch beside maximal contractions, so that the tendon carries small and large forces",
    "k": "maximal contractions at several lengths, so that the tendon carries small and large forces",
    "k_P": "a slow passive stretch until the muscle pulls with a tenth of F_max or more",
    "pennation": "maximal contractions at short lengths, where the angle is large",
}


@dataclass(frozen=True)
class Direction:
    """Numbers of a muscle that trials do not tell: by which parts they change together, at one standard deviation.

    sd: what is left of it, as a part of that before. cure: the trial that would tell.
    """

    muscle: str
    parts: Mapping[str, float]
    sd: float
    cure: str


def untold(muscle: str, keys: Sequence[str], parts: Array, left: Array) -> Iterator[Direction]:
    """The directions that trials leave open, numbers of which nothing is told first.

    keys: the numbers, parts: their relative standard deviations before (n), left: their covariance in those (n × n).
    """
    sds = np.sqrt(np.diag(left))
    for i in np.flatnonzero(sds > _ALONE).tolist():
        yield Direction(muscle, {keys[i]: float(sds[i] * parts[i])}, float(sds[i]), _CURES.get(keys[i], ""))
    rest = np.flatnonzero(sds <= _ALONE)
    variances, vectors = np.linalg.eigh(left[np.ix_(rest, rest)])
    for variance, vector in zip(variances[::-1].tolist(), vectors.T[::-1], strict=True):
        if (sd := math.sqrt(variance)) <= UNTOLD:
            return
        # a direction has no sign: its largest part is up
        largest = int(np.argmax(np.abs(vector)))
        shares = zip(rest.tolist(), (vector * np.sign(vector[largest])).tolist(), strict=True)
        together = {keys[i]: float(sd * parts[i] * share) for i, share in shares if abs(share) > _SHARE}
        yield Direction(muscle, together, sd, _CURES.get(keys[rest[largest]], ""))
