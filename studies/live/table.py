"""Estimates as lines: CSV as `estimates.csv` has them, or an object of JSON on each line."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ..files.tables import csv_text, or_empty
from ..laboratory.quantities import OF_JOINTS, OF_MUSCLES, UNITS_OF_MUSCLES, unit_of_joints
from ..laboratory.subject import Subject
from .estimate import Estimate

# what follows the name of an estimate and of its standard deviation
_HAT, _SD = "_hat", "_sd_state"


class EstimateTable:
    """The columns of the estimates of some observers; sure: those that tell standard deviations."""

    def __init__(self, subject: Subject, observers: Sequence[str], sure: Sequence[str]) -> None:
        several = len(observers) > 1
        self._sure = [name in sure for name in observers]
        columns = [
            (f"{name}." * several + column + suffix, unit)
            for name in observers
            for suffix in (_HAT, _SD)[: 1 + (name in sure)]
            for column, unit in _columns(subject)
        ]
        self._columns = [("time", "s"), *columns]

    def head(self) -> str:
        """The first line of CSV."""
        return csv_text([[name if unit == "1" else f"{name} [{unit}]" for name, unit in self._columns]]).rstrip("\n")

    def numbers(self, time: float, estimates: Sequence[Estimate]) -> list[float]:
        """A row, NaN where there is no estimate; empty if there is none at all."""
        row = [time]
        for estimate, sure in zip(estimates, self._sure, strict=True):
            row += _numbers(estimate._asdict())
            if sure:
                row += _numbers(estimate.sd) if estimate.sd else [math.nan] * len(_numbers(estimate._asdict()))
        return row if any(number == number for number in row[1:]) else []

    def as_csv(self, row: Sequence[float]) -> str:
        """A row as CSV, gaps empty."""
        return ",".join(map(or_empty, row))

    def as_json(self, row: Sequence[float]) -> str:
        """A row as an object of JSON, gaps null."""
        names = (name for name, _ in self._columns)
        return json.dumps({name: v if v == v else None for name, v in zip(names, row, strict=True)})


def _columns(subject: Subject) -> Iterator[tuple[str, str]]:
    """Name and unit of each quantity of each joint, then of each muscle."""
    for quantity in OF_JOINTS:
        for name, slides in zip(subject.names[quantity], subject.scales.sliding, strict=True):
            yield name, unit_of_joints([slides], quantity)
    for quantity in OF_MUSCLES:
        yield from ((name, UNITS_OF_MUSCLES[quantity]) for name in subject.names[quantity])


def _numbers(of: Mapping[str, Any]) -> list[float]:
    """The numbers of all quantities."""
    row: list[float] = []
    for quantity in (*OF_JOINTS, *OF_MUSCLES):
        value = of[quantity]
        row += value.values() if isinstance(value, dict) else [value]
    return row
