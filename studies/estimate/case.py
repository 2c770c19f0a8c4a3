"""A recording in the paper's variables, and what an observer made of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...codegen.failure import Failure
from ...model.arrays import Array
from ...observers.conditions import Checked
from ...observers.observer import SystemSizes
from ..files.errors import ScenarioError
from ..kalman.run import AUTO
from ..laboratory.muscles import MusclePair
from ..laboratory.recording import Recording
from ..laboratory.scales import Scales
from ..laboratory.subject import Subject


@dataclass(frozen=True)
class Settings:
    """What was asked for: layers `corrected`, gains by hand (path → value), which estimates are kept.

    form: of the Kalman filter; smooth: with all later samples; lag: s that its estimates may be late.
    """

    corrected: bool
    changes: Mapping[str, float]
    keep_every: int
    form: str = AUTO
    smooth: bool = False
    lag: float = 0.0


@dataclass(frozen=True, eq=False)
class Result:
    """One observer's outputs and guards by name, each (n), dimensionless, and how it was run.

    violated: its gain conditions that do not hold. From a failure on the numbers are NaN. fit: what the likelihood of
    the recording decided, if it was asked, and how late estimates are, `lag` in s.
    """

    y: Mapping[str, Array]
    guards: Mapping[str, Array]
    gains: Mapping[str, float]
    substeps: int
    violated: Sequence[Checked]
    failure: Failure | None
    fit: Mapping[str, Any] | None = None


@dataclass(frozen=True, eq=False)
class Case:
    """A recording in the paper's variables: times τ (n), measurements y, tendon lengths z and slopes (n × muscles).

    doubt: path of a number such as muscle1.F_max → its standard deviation in SI.
    """

    recording: Recording
    subject: Subject
    tau: Array
    y: Array
    z: Array
    slopes: Array
    gaps: NDArray[np.bool_]
    sizes: SystemSizes
    settings: Settings
    doubt: Mapping[str, float]

    @property
    def scales(self) -> Scales:
        """What leads to the paper's variables and back."""
        return self.subject.scales

    @property
    def pair(self) -> MusclePair:
        """The pair. ScenarioError for another mechanism, of which what asks for it knows nothing."""
        if self.subject.pair is None:
            raise ScenarioError("that is for a mass between two muscles, and not for a mechanism")
        return self.subject.pair

    @property
    def kept(self) -> slice:
        """The samples whose estimates are kept: every n-th."""
        return slice(None, None, self.settings.keep_every)

    @property
    def period(self) -> float:
        """The usual time from sample to sample, in τ."""
        return float(np.median(np.diff(self.tau)))
