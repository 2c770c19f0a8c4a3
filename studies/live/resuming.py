"""A follower that goes on from a state."""

from __future__ import annotations

from typing import Any

from ...codegen.recordings.filters import State
from ...model.errors import Error
from ..files.errors import ResultError
from .follower import Follower
from .running import Running
from .setup import Setup
from .state import unpacked


def resumed(state: object, setup: Setup) -> Follower:
    """The follower whose state it was. ResultError if it was none, or that of another observer or of other muscles."""
    try:
        return _resumed(unpacked(state, setup), setup)
    except Error as error:
        raise ResultError(f"the state cannot be gone on from: {error}") from error


def _resumed(told: dict[str, Any], setup: Setup) -> Follower:
    gains, running = setup.given(told["gains"]), bool(told["tau"])
    if told["learning"] != bool(setup.missing(gains)) or (running and told["learning"]):
        raise ResultError("its gains are not those of this observer")
    follower = Follower(setup, gains, told["period"], told["seconds"], told["T"])
    follower.clock.base, follower.clock.count = told["clock"]["base"], told["clock"]["count"]
    for owner, name in ((follower.clock, "last"), (follower, "start"), (follower, "followed")):
        if told[name]:
            setattr(owner, name, told[name][0])
    follower.failure = told["failure"]
    for t, *values in told["learnt_from"]:
        follower.remember(t, values)
    if running:
        follower.running = Running(setup, gains, told["first"], told["T"])
        follower.running.go_on_from(State(told["x"], told["tau"][0], told["y"]), told["taut"])
    return follower
