"""The numbers of muscles from trials in which activations were known."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ..files.errors import ScenarioError
from ..files.progress import Progress, shares, unseen
from ..files.quote import shown
from ..laboratory.mechanisms.mechanism import Mechanism
from ..laboratory.muscles import Muscle, MusclePair
from ..laboratory.subject import Subject, subject_of
from .extra import scipy
from .fit import Fit, fitted
from .known import Known, known
from .result import Calibration, calibrated, misfits, numbers
from .told import untold
from .trial import Trial, read_trial, refuse_repeated

# what the lengths of all trials of a muscle must differ by, in optimal fibre lengths
_STRETCH = 0.05


def calibrate(
    trials: Sequence[str | Path | Trial],
    muscles: str | Path | MusclePair | Mechanism | Subject,
    progress: Progress | None = None,
) -> Calibration:
    """The numbers of muscles for which their forces in some trials are likeliest, and how well they are known then.

    trials: files of trials, docs/calibrate.md, or trials that were read. muscles: what is known before, as `estimate`
    takes it; standard deviations of the file count before the usual ones. progress: given the part that is done.
    ScenarioError, RecordingError for what is wrong with a file, for trials that contradict each other or have one
    length only, and if SciPy is missing.

    >>> found = hillobs.calibrate(["stretch.toml", "maximal.toml"], "guess.toml")
    >>> found
    Calibration(6 numbers, 2 trials of a muscle)
    """
    if isinstance(trials, str) or not isinstance(trials, Sequence) or not trials:
        raise ScenarioError(f"trials must be a list of one or more, not {shown(trials)}")
    # what is missing is said before anything is read
    scipy("optimize")
    subject = subject_of(muscles)
    read = [_read(given, subject) for given in trials]
    refuse_repeated(read)
    measured = [
        one
        for trial, part in zip(read, shares(progress or unseen, [1.0] * len(read)), strict=True)
        for one in known(trial, subject, part)
    ]
    by_muscle = {name: [one for one in measured if one.muscle == name] for name in subject.muscles}
    told = {name: trials for name, trials in by_muscle.items() if trials}
    fits = {name: _fit(subject.muscles[name], trials) for name, trials in told.items()}
    return Calibration(
        [number for name, fit in fits.items() for number in numbers(name, fit)],
        [misfit for name, fit in fits.items() for misfit in misfits(fit, told[name])],
        [left for name, fit in fits.items() for left in untold(name, fit.prior.keys, fit.prior.parts, fit.left)],
        calibrated(subject, fits),
    )


def _read(given: object, subject: Subject) -> Trial:
    if isinstance(given, str | Path):
        return read_trial(given, subject)
    if not isinstance(given, Trial):
        raise ScenarioError(f"a trial is a file's name or one that was read, not {shown(given)}")
    if odd := [name for name in given.activation if name not in subject.muscles]:
        raise ScenarioError(f"{shown(odd[0])} is no muscle of these; there are {', '.join(subject.muscles)}")
    return given


def _fit(muscle: Muscle, trials: Sequence[Known]) -> Fit:
    """ScenarioError if all lengths are one, or if trials fit one by one and not together."""
    name, lengths = trials[0].muscle, np.concatenate([trial.length for trial in trials])
    if (stretch := float(np.ptp(lengths))) < _STRETCH * muscle.optimal_fibre_length:
        raise ScenarioError(
            f"the trials of {name} are at one length, {lengths.mean():.4g} m give or take {stretch / 2:.1g} m; "
            f"they tell its numbers if lengths differ by {100 * _STRETCH:g} % of the optimal fibre length or more"
        )
    fit = fitted(muscle, trials)
    together = list(misfits(fit, trials))
    if len(trials) > 1 and not all(misfit.fits for misfit in together):
        alone = [next(misfits(fitted(muscle, [trial]), [trial])) for trial in trials]
        if all(misfit.fits for misfit in alone):
            worst = max(together, key=lambda misfit: misfit.rms)
            raise ScenarioError(
                f"the trials of {name} contradict each other: each fits alone, and together {worst.source} is off by "
                f"{worst.rms:.2g} standard deviations; is an activation, a unit or the curve set another one?"
            )
    return fit
