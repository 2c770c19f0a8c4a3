"""The way to a follower: muscles, an observer, and its gains or a state that was saved."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import xarray as xr

from ...model.block import Block
from ..files.errors import ScenarioError
from ..files.numbers import number
from ..laboratory.mechanisms.mechanism import Mechanism
from ..laboratory.muscles import MusclePair
from ..laboratory.subject import Subject
from ..scenarios.layers import Value
from .follower import LEARNING, Follower
from .gains import period_of_estimates
from .setup import setup


def follow(
    muscles: str | Path | MusclePair | Mechanism | Subject,
    observer: str | Block,
    period: float | None = None,
    gains: Mapping[str, Value] | xr.Dataset | None = None,
    corrected: bool = True,
    learning: float = LEARNING,
    state: bytes | None = None,
) -> Follower:
    """An observer that follows samples one by one, as they come: `follower.step(position, force_1, force_2)`.

    muscles: as for `estimate`. observer: a registered name or a Block of your own. period: s from sample to sample; it
    may be left out where gains are those of estimates, which know it, or where they are learnt from samples with times.
    gains: path → value, as `estimate` tells them, or its Dataset. What is left out is learnt, in the first `learning`
    seconds, in which there are no estimates. corrected: as for `estimate`.
    state: what `state()` of a follower gave, to go on from there: it knows its period and gains.
    ScenarioError or ResultError for what is wrong with any of them, BuildError if nothing can be compiled.

    >>> gains = {"high_gain.eps_h": 0.2, "high_gain.eps_L": 0.05}
    >>> follower = hillobs.follow("pair.toml", "high_gain", period=0.005, gains=gains)
    >>> for _ in range(200):
    ...     estimate = follower.step(0.31, 380.0, 379.0)
    >>> {muscle: round(activation, 3) for muscle, activation in estimate.activation.items()}
    {1: 0.357, 2: 0.356}
    """
    made = setup(muscles, observer, corrected)
    if state is not None:
        if gains is not None or period is not None:
            raise ScenarioError("a state knows its gains and its period; leave them out")
        follower = Follower.resumed(state, made)
    else:
        given = made.given(gains)
        seconds = _period(period, gains, bool(made.missing(given)))
        T = made.subject.scales.rate * seconds
        follower = Follower(made, given, seconds, number("learning", learning), T)
    if follower.learning:
        made.compile_learning()
    return follower


def _period(period: float | None, gains: Mapping[str, Value] | xr.Dataset | None, learning: bool) -> float:
    """In s; 0 if the samples will tell it."""
    if period is not None:
        if (seconds := number("period", period)) <= 0:
            raise ScenarioError(f"period must be above 0 s, not {seconds:g} s")
        return seconds
    if isinstance(gains, xr.Dataset):
        return period_of_estimates(gains)
    if learning:
        return 0.0
    raise ScenarioError("period, in s from sample to sample, must be given with the gains")
