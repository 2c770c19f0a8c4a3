"""Orders and densities of the Kalman filter for a scenario or a recording, by maximum likelihood."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...observers.kalman.parameters import INPUTS as OF_INPUTS
from ...observers.kalman.parameters import NOISE
from ..files.errors import ScenarioError
from ..files.progress import Progress, shares, unseen
from ..files.quote import shown
from ..kalman.orders import chosen_inputs, manifest
from ..kalman.record import segments, settled
from ..kalman.run import INPUTS
from ..laboratory.mechanisms.mechanism import Mechanism
from ..laboratory.muscles import MusclePair
from ..laboratory.recording import Recording
from ..laboratory.subject import Subject
from ..scenarios.layers import SUFFIX, Value, written
from .of_scenario import sampled
from .run import KALMAN, estimate

# what is found; what is measured alone, the noise, goes with it
_FOUND = (*NOISE, *OF_INPUTS)


@dataclass(frozen=True)
class Fitted:
    """The numbers found, path → value, how they were chosen as a fit has it, and the number of samples.

    scenario: path → value as written of the scenario, with its `base`; none of a recording.
    """

    label: str
    scenario: Mapping[str, object]
    numbers: Mapping[str, float]
    choice: Mapping[str, Any]
    samples: int


def fit(
    source: str | Path | Recording,
    muscles: str | Path | MusclePair | Mechanism | Subject | None = None,
    mapping: Mapping[str, str] | None = None,
    changes: Mapping[str, Value] | None = None,
    progress: Progress | None = None,
) -> dict[str, float]:
    """The numbers of the Kalman filter, path → value, for which what was measured is likeliest.

    source: a scenario as `simulate` takes it, or with `muscles` a recording as `estimate` does, with its `mapping`.
    changes: of the scenario, or gains by hand; numbers of the filter among them stay as they are. The result can be
    given to `simulate` and `sweep` as changes. progress: given the part that is done. ScenarioError, RecordingError for
    what is wrong with the files.

    >>> numbers = hillobs.fit("run.csv", "pair.toml", mapping={"position": "block x[mm]"})
    >>> sorted(numbers)  # doctest: +NORMALIZE_WHITESPACE
    ['kalman.order_D', 'kalman.order_u', 'kalman.s_D', 'kalman.s_u1', 'kalman.s_u2', 'kalman.sigma_1',
     'kalman.sigma_F1', 'kalman.sigma_F2']
    """
    return dict(fitted(source, muscles, mapping, changes or {}, progress or unseen).numbers)


def fitted(
    source: str | Path | Recording,
    muscles: str | Path | MusclePair | Mechanism | Subject | None,
    mapping: Mapping[str, str] | None,
    changes: Mapping[str, Value],
    progress: Progress,
) -> Fitted:
    """The same, and how it was found."""
    if muscles is not None:
        return _of_recording(source, muscles, mapping, changes, progress)
    if isinstance(source, Recording) or Path(source).suffix not in ("", SUFFIX):
        name = "" if isinstance(source, Recording) else f"{shown(str(source))}: "
        raise ScenarioError(
            f"{name}a recording needs its muscles (--muscles) or mechanism (--mechanism) to be followed"
        )
    if mapping:
        raise ScenarioError("a mapping (--map) names columns of a recording, and a scenario has none")
    return _of_scenario(source, changes, progress)


def _of_recording(
    source: str | Path | Recording,
    muscles: str | Path | MusclePair | Mechanism | Subject,
    mapping: Mapping[str, str] | None,
    changes: Mapping[str, Value],
    progress: Progress,
) -> Fitted:
    estimates = estimate(source, muscles, KALMAN, mapping, changes=changes, progress=progress, form=INPUTS)
    about = {name: json.loads(estimates.attrs[name]) for name in ("gains", "fits")}
    return Fitted(
        estimates.attrs["source"],
        {},
        about["gains"][KALMAN],
        about["fits"][KALMAN],
        int(estimates.attrs["samples"]),
    )


def _of_scenario(source: str | Path, changes: Mapping[str, Value], progress: Progress) -> Fitted:
    """Of a run of the scenario."""
    parts = shares(progress, [1, 1])
    of = sampled(source, changes, next(parts))
    by_hand = {name: of.given[path] for path in changes for name in [path.removeprefix(f"{KALMAN}.")] if name != path}
    table = of.record.table()
    fitted_to = [settled(table[part]) for part in segments(len(of.record))]
    choice = chosen_inputs(of.record, fitted_to, by_hand, next(parts))
    found = {f"{KALMAN}.{name}": choice.fit.numbers[name] for name in _FOUND}
    return Fitted(of.label, written(source, changes), found, {INPUTS: manifest(choice)}, len(of.record))
