"""The time grid of a scenario, in whole steps."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from ...codegen.memory import Grid
from ..files.errors import ScenarioError

# a run of 10⁹ steps takes an hour; a million recorded points are 1 GB
_MOST_STEPS = 1_000_000_000
_MOST_POINTS = 1_000_000
# what decimal fractions may be off as doubles
_ROUNDING = 1e-9


def time_grid(value: Callable[[str], float], pulses: Sequence[str] = ()) -> Grid:
    """The grid in whole steps, with the pulses named.

    ScenarioError if a time is not a multiple of the step, or the run too long.
    """
    h, duration = value("step"), value("duration")
    if h > duration:
        raise ScenarioError(f"step = {h:g} must not exceed duration = {duration:g}")
    if duration / h > _MOST_STEPS:
        raise ScenarioError(f"duration = {duration:g} at step = {h:g} is more than {_MOST_STEPS:,} steps")
    if duration / value("record") > _MOST_POINTS:
        raise ScenarioError(f"record = {value('record'):g} keeps more than {_MOST_POINTS:,} points; record fewer")

    def whole(path: str) -> int:
        """The time at `path` in steps."""
        steps = value(path) / h
        if steps > _MOST_STEPS:
            raise ScenarioError(f"{path} = {value(path):g} at step = {h:g} is more than {_MOST_STEPS:,} steps")
        if value(path) > 0 and round(steps) == 0:
            raise ScenarioError(f"{path} = {value(path):g} is below step = {h:g}")
        if abs(steps - round(steps)) > _ROUNDING * max(1.0, steps):
            raise ScenarioError(f"{path} = {value(path):.12g} must be a whole multiple of step = {h:.12g}")
        return round(steps)

    def pulse(name: str) -> tuple[int, int]:
        """First step on, first step off."""
        start, stop = whole(f"{name}.start"), whole(f"{name}.stop")
        if stop < start:
            raise ScenarioError(
                f"{name}.stop = {value(f'{name}.stop'):g} must not be before {name}.start = {value(f'{name}.start'):g}"
            )
        return start, stop

    record, steps = whole("record"), whole("duration")
    if steps % record:
        raise ScenarioError(f"duration = {duration:.12g} must be a whole multiple of record = {value('record'):.12g}")
    return Grid(
        h=h,
        steps=steps,
        record=record,
        hold=whole("noise.period"),
        # beyond the end there is no window, however far
        window=math.ceil(min(value("score.start") / h * (1 - _ROUNDING), steps + 1)),
        pulses=tuple(pulse(name) for name in pulses),
    )
