"""The way to a follower: muscles, an observer, and its gains or a state that was saved."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import xarray as xr

from ...model.block import Block
from ..estimate.start import too_rare
from ..files.errors import ResultError, ScenarioError
from ..files.numbers import number
from ..laboratory.mechanisms.mechanism import Mechanism
from ..laboratory.muscles import MusclePair
from ..laboratory.subject import Subject
from .follower import LEARNING, Follower
from .setup import setup

# s; of more samples gains are no better, and they wait in memory
_LONGEST = 600.0


def follow(
    muscles: str | Path | MusclePair | Mechanism | Subject,
    observer: str | Block,
    period: float | None = None,
    gains: Mapping[str, float] | xr.Dataset | None = None,
    corrected: bool = True,
    learning: float = LEARNING,
    state: bytes | None = None,
) -> Follower:
    """An observer that follows samples one by one, as they come: `follower.step(position, force_1, force_2)`.

    muscles: as for `estimate`. observer: a registered name or a Block of your own. period: s from sample to sample; it
    may be left out where gains are those of estimates, which know it, or where they are learnt from samples with times.
    gains: path → value, as `estimate` tells them, or its Dataset. What is left out is learnt, in the first `learning`
    seconds, in which there are no estimates. corrected: as for `estimate`.
    state: what `Follower.state` gave, to go on from there: it knows its period and gains.
    ScenarioError or ResultError for what is wrong with any of them, BuildError if nothing can be compiled.
    """
    made = setup(muscles, observer, corrected)
    given = made.given(gains)
    seconds = number("learning", learning)
    if not 0 < seconds <= _LONGEST:
        raise ScenarioError(f"learning must be above 0 and at most {_LONGEST:g} s, not {seconds:g} s")
    missing = made.missing(given)
    if missing:
        made.compile_learning()
    return Follower(made, given, _period(period, gains, missing, made.subject), seconds)


def _period(
    period: float | None, gains: Mapping[str, float] | xr.Dataset | None, missing: list[str], subject: Subject
) -> float:
    """In s; 0 if the samples will tell it."""
    if period is None and isinstance(gains, xr.Dataset):
        try:
            period = float(gains.attrs["period"])
        except (KeyError, ValueError) as error:
            raise ResultError("the estimates do not tell their period") from error
    if period is None:
        if missing:
            return 0.0
        raise ScenarioError("period, in s from sample to sample, must be given with the gains")
    seconds = number("period", period)
    if seconds <= 0:
        raise ScenarioError(f"period must be above 0 s, not {seconds:g} s")
    if objection := too_rare(seconds, subject.scales):
        raise ScenarioError(objection)
    return seconds
