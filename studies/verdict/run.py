"""The verdict on a recording and its muscles: what a person can act on."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import xarray as xr

from ...model.skeleton.load import pull
from ..estimate.run import KALMAN, estimate, recorded
from ..files.progress import Progress, shares, unseen
from ..kalman.run import AUTO, innovations
from ..laboratory.mechanisms.mechanism import Mechanism
from ..laboratory.muscles import MusclePair
from ..laboratory.recording import Recording, read_recording
from ..laboratory.subject import Subject, subject_of
from ..scenarios.layers import Value
from .apart import findings as apart
from .checks import UNMEASURED, of_estimates, of_measurements, of_sensors
from .finding import Finding
from .innovations import of_innovations
from .muscles import of_muscles

# of a longer recording the samples in its middle are weighed
_MOST = 4_000
_OURS = f"{KALMAN}."
# shares of the time: estimates, what is likelier
_ESTIMATE, _WEIGH = 1.0, 2.0


@dataclass(frozen=True)
class Verdict:
    """All findings; samples: how many there are; weighed: how many of them the muscles were weighed by, 0 if none.

    between: s from and to of those.
    """

    findings: Sequence[Finding]
    samples: int
    weighed: int
    between: tuple[float, float]

    @property
    def quality(self) -> str:
        """`good`, or `doubtful` if any finding is."""
        return "doubtful" if any(finding.doubtful for finding in self.findings) else "good"

    def as_dict(self) -> dict[str, Any]:
        """The same for a program, in words of JSON."""
        findings = [asdict(finding) for finding in self.findings]
        # JSON has no infinity
        findings = [{**f, "value": f["value"] if math.isfinite(f["value"]) else None} for f in findings]
        weighed = {"samples": self.weighed, "of": self.samples, "between": list(self.between)}
        return {"quality": self.quality, "findings": findings, "weighed": weighed}


def verdict(
    recording: str | Path | Recording,
    muscles: str | Path | MusclePair | Mechanism | Subject,
    mapping: Mapping[str, str] | None = None,
    progress: Progress | None = None,
    changes: Mapping[str, Value] | None = None,
    form: str = AUTO,
) -> Verdict:
    """Whether a recording and the numbers of its muscles can be believed.

    recording, muscles, mapping, and of the Kalman filter whose estimates are judged changes and form: as `estimate`
    takes them. progress: given the part that is done. Every sample is looked at; of more than 4,000 those in the middle
    say how likely other muscles are. RecordingError, ScenarioError for what cannot be a recording of these muscles at
    all.

    >>> judged = hillobs.verdict("run.csv", "pair.toml", mapping={"position": "block x[mm]"})
    >>> judged.quality
    'good'
    >>> [finding.subject for finding in judged.findings if finding.doubtful]
    []
    """
    subject = subject_of(muscles)
    read = recording if isinstance(recording, Recording) else read_recording(recording, mapping, None, subject.columns)
    following, weighing = shares(progress or unseen, [_ESTIMATE, _WEIGH])
    estimates = estimate(read, subject, KALMAN, changes=changes, progress=following, form=form)
    return judged(read, subject, estimates, weighing)


def judged(
    read: Recording, muscles: MusclePair | Mechanism | Subject, estimates: xr.Dataset, progress: Progress
) -> Verdict:
    """The verdict on a recording and on the estimates that `estimate` has made of it, `kalman` among the observers."""
    subject, middle = subject_of(muscles), _middle(read)
    between = float(middle.time[0]), float(middle.time[-1])
    pair = subject.pair
    findings = list(of_all(read, pair, estimates) if pair else apart.of_all(read, subject, estimates))
    weighed = 0 if any(_forbids(finding, between) for finding in findings) else len(middle)
    if weighed:
        fit = json.loads(estimates.attrs["fits"])[KALMAN]
        findings += (
            of_muscles(middle, pair, fit, progress) if pair else apart.of_muscles(middle, subject, fit, progress)
        )
    return Verdict(findings, len(read), weighed, between)


def _forbids(finding: Finding, between: tuple[float, float]) -> bool:
    """Whether muscles cannot be weighed: something needs no comparison of them, or a sensor is wrong just there."""
    if not finding.doubtful or finding.when is None:
        return finding.doubtful and finding.subject in UNMEASURED
    return finding.when[0] < between[1] and finding.when[1] > between[0]


def of_all(read: Recording, pair: MusclePair, estimates: xr.Dataset) -> Iterator[Finding]:
    """Of every sample: sensors, units, and what the filter made of them."""
    by_hand = json.loads(estimates.attrs["settings"])["changes"]
    case, record = recorded(read, pair, {path: value for path, value in by_hand.items() if path.startswith(_OURS)})
    yield from of_measurements(case)
    yield from of_sensors(case)
    if failure := json.loads(estimates.attrs["failures"]).get(KALMAN):
        yield Finding("failure", failure, math.nan, True)
        return
    fit = json.loads(estimates.attrs["fits"])[KALMAN]
    ratios = innovations(record, fit["u"]["numbers"])
    yield from of_innovations(read.time, ratios, min(case.sizes.pair.sigma_F1, case.sizes.pair.sigma_F2))
    of = estimates.sel(observer=KALMAN)
    limited = of.activation_limited.mean("time").values.tolist()
    yield from of_estimates(pull(of.force.values.T), of.disturbance_hat.values, limited)


def _middle(read: Recording) -> Recording:
    """At most so many samples, from the middle."""
    if len(read) <= _MOST:
        return read
    start = (len(read) - _MOST) // 2
    return read.part(slice(start, start + _MOST))
