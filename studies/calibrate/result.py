"""What a calibration tells: numbers before and after, what trials leave unexplained, the muscles with these numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..files.toml import toml_document
from ..laboratory.mechanisms.mechanism import Mechanism
from ..laboratory.mechanisms.writing import mechanism_text
from ..laboratory.muscles import Muscle, MusclePair, muscle_file
from ..laboratory.subject import Subject
from .extra import scipy
from .fit import OUTLIER, Fit
from .known import Known
from .told import Direction

# how often residuals of a right muscle are larger than what is called a misfit
_CHANCE = 0.001


@dataclass(frozen=True)
class Number:
    """A number of a muscle before and after its trials, each with its standard deviation, in `unit`."""

    muscle: str
    name: str
    unit: str
    before: float
    before_sd: float
    value: float
    sd: float

    @property
    def left(self) -> float:
        """The part of its relative standard deviation that trials have left."""
        return (self.sd / self.value) / (self.before_sd / self.before)

    @property
    def moved(self) -> float:
        """How far it is from what was known before, in the standard deviation of that."""
        # ξ = log(θ/θ₀)/r
        return math.log(self.value / self.before) / (self.before_sd / self.before)


@dataclass(frozen=True)
class Misfit:
    """What a trial leaves unexplained of a muscle's force.

    samples: those that counted, `spacing` s apart. rms: of residuals over their standard deviations, outliers cut.
    limit: what it exceeds once in a thousand trials of a right muscle. outliers: s when a residual is larger than five
    standard deviations. level: by how many of its own the activation seems off.
    """

    source: str
    muscle: str
    samples: int
    spacing: float
    rms: float
    limit: float
    outliers: Sequence[float]
    level: float

    @property
    def fits(self) -> bool:
        """Whether the numbers explain the trial."""
        return self.rms <= self.limit


@dataclass(frozen=True, eq=False)
class Calibration:
    """The `numbers` found, `misfits`: what trials leave unexplained, `untold`: what they cannot tell.

    muscles: the pair or the mechanism with these numbers.
    """

    numbers: Sequence[Number]
    misfits: Sequence[Misfit]
    untold: Sequence[Direction]
    muscles: MusclePair | Mechanism

    def __repr__(self) -> str:
        """Of how many numbers and trials."""
        return f"Calibration({len(self.numbers)} numbers, {len(self.misfits)} trials of a muscle)"

    @property
    def toml(self) -> str:
        """The muscles as the file that `estimate` takes, with standard deviations."""
        described = self.muscles
        return toml_document(muscle_file(described)) if isinstance(described, MusclePair) else mechanism_text(described)


def numbers(muscle: str, fit: Fit) -> Iterator[Number]:
    """Those of a muscle."""
    prior, found = fit.prior, fit.numbers
    sds = np.sqrt(np.diag(fit.left)) * prior.parts * found
    before_sds = prior.parts * prior.values
    columns = (values.tolist() for values in (prior.values, before_sds, found, sds))
    yield from (Number(muscle, *row) for row in zip(prior.keys, prior.units, *columns, strict=True))


def misfits(fit: Fit, trials: Sequence[Known]) -> Iterator[Misfit]:
    """Those of the trials of a muscle."""
    # numbers that were found take their share of the noise
    free = 1 - (len(fit.xi) - np.trace(fit.left)) / sum(map(len, fit.ratios))
    for trial, rows, ratios, level in zip(trials, fit.kept, fit.ratios, fit.levels.tolist(), strict=True):
        time, n = trial.time[rows], len(rows)
        rms = float(np.sqrt(np.mean(np.minimum(np.abs(ratios), OUTLIER) ** 2)))
        spacing, outliers = float(np.median(np.diff(time))), time[np.abs(ratios) > OUTLIER].tolist()
        yield Misfit(trial.source, trial.muscle, n, spacing, rms, _limit(max(n * free, 1)), outliers, level)


def _limit(degrees: float) -> float:
    """√(χ²/n) that so many residuals exceed by chance once in a thousand."""
    return float(np.sqrt(scipy("stats").chi2.isf(_CHANCE, degrees) / degrees))


def calibrated(subject: Subject, fits: Mapping[str, Fit]) -> MusclePair | Mechanism:
    """What the subject describes, with the numbers of these muscles and their standard deviations."""
    muscles: dict[str, Any] = {name: _muscle(fit) for name, fit in fits.items()}
    described = subject.described
    if isinstance(described, MusclePair):
        return replace(described, **muscles)
    return replace(described, muscles={**described.muscles, **muscles})


def _muscle(fit: Fit) -> Muscle:
    muscle, found = fit.muscle, list(numbers("", fit))
    values: dict[str, Any] = {number.name: number.value for number in found}
    of_curves = {key: values.pop(key, value) for key, value in muscle.numbers.items()}
    sds = {**muscle.sds, **{number.name: number.sd for number in found}}
    return replace(muscle, **values, numbers=of_curves, sds=sds)
