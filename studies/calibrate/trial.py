"""A trial: a recording during which the activation of a muscle was known, from a TOML file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...model.arrays import Array
from ...model.block import Parameter, Parameters
from ..files.errors import RecordingError, ScenarioError, in_file
from ..files.numbers import number, samples, within
from ..files.quote import short, shown, table, text
from ..files.toml import read_toml
from ..laboratory.mapping import mapping_of
from ..laboratory.muscles.keys import refuse_missing, refuse_unknown, section
from ..laboratory.recording import Recording, read_recording
from ..laboratory.samples import MOST_NUMBERS
from ..laboratory.subject import Subject

_RECORDING, _ACTIVATION, _COLUMNS, _BETWEEN = "recording", "activation", "columns", "between"
_LEVEL = Parameter(0.0, "activation that a trial has", "trial file", least=0, most=1)
_CHOSEN = "chosen, docs/calibrate.md#what-a-trial-is"
# how far a level may be off in a whole trial
LEVEL_SDS: Parameters = {
    "passive": Parameter(0.003, "standard deviation of an activation that is 0", _CHOSEN, least=0, most=1),
    "active": Parameter(0.02, "standard deviation of any other one that is known", _CHOSEN, least=0, most=1),
}


@dataclass(frozen=True, eq=False)
class Trial:
    """A recording and the activation of one muscle or more, each a number or one for each sample (n), in [0, 1].

    sds: by how much such an activation may be off in the whole trial, by muscle; 0.003 where it is 0, else 0.02.
    between: s from and to, where the activations are known; else they are in all of it.
    ScenarioError for what is no activation, no standard deviation, or no time of the recording.
    """

    recording: Recording
    activation: Mapping[str, float | Array]
    sds: Mapping[str, float] = field(default_factory=dict)
    between: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.recording, Recording):
            raise ScenarioError(f"a trial's recording must be one that was read, not {shown(self.recording)}")
        levels = {name: self._level(name, given) for name, given in table(_ACTIVATION, self.activation).items()}
        if not levels:
            raise ScenarioError(f"{_ACTIVATION} must name a muscle whose activation is known, such as muscle1 = 1.0")
        given = table("sds", self.sds)
        if odd := [name for name in given if name not in levels]:
            raise ScenarioError(f"sds must be of {', '.join(levels)}, not of {shown(odd[0])}")
        usual = {name: LEVEL_SDS["active" if np.any(level) else "passive"] for name, level in levels.items()}
        sds = {name: within(f"the sd of {name}", given.get(name, of.default), of) for name, of in usual.items()}
        object.__setattr__(self, "activation", levels)
        object.__setattr__(self, "sds", sds)
        object.__setattr__(self, "between", self._window())

    def _level(self, name: str, given: object) -> float | Array:
        path = f"{_ACTIVATION}.{name}"
        if not isinstance(given, np.ndarray):
            return within(path, given, _LEVEL)
        level = samples(path, given, MOST_NUMBERS)
        if len(level) != len(self.recording):
            raise ScenarioError(f"{path} has {len(level):,} values, and time {len(self.recording):,}")
        if len(odd := np.flatnonzero(~((level >= _LEVEL.least) & (level <= _LEVEL.most)))):
            row = self.recording.rows[odd[0]]
            raise ScenarioError(f"{path} must be from 0 to 1; it is {level[odd[0]]:g} in row {row:,}")
        return level

    def _window(self) -> tuple[float, float] | None:
        match self.between:
            case None:
                return None
            case [first, last]:
                start, end = number(_BETWEEN, first), number(_BETWEEN, last)
                if start < end:
                    return start, end
        raise ScenarioError(f"{_BETWEEN} must be two times in s, the earlier one first, not {shown(self.between)}")


def read_trial(path: str | Path, subject: Subject) -> Trial:
    """The trial of a TOML file, docs/calibrate.md, with muscles of this subject.

    ScenarioError, RecordingError name the file and say what is wrong.
    """
    content, where = read_toml(Path(path)), Path(path)
    with in_file(where):
        refuse_unknown(content, [_RECORDING, _ACTIVATION, _COLUMNS, _BETWEEN], "")
        refuse_missing([key for key in (_RECORDING, _ACTIVATION) if key not in content])
        given = section(content, _ACTIVATION)
        refuse_unknown(given, list(subject.muscles), f"{_ACTIVATION}.")
        names = dict(zip(subject.muscles, subject.names["activation"], strict=True))
        told = {name: _told(f"{_ACTIVATION}.{name}", value) for name, value in given.items()}
        mapping = mapping_of(section(content, _COLUMNS), f"{where}: {_COLUMNS}.")
        mapping |= {names[name]: level for name, (level, _) in told.items() if isinstance(level, str)}
        source = where.parent / text(_RECORDING, content[_RECORDING])
    recording = read_recording(source, mapping, None, subject.columns)
    with in_file(where):
        levels = {
            name: _in_column(names[name], level, recording) if isinstance(level, str) else level
            for name, (level, _) in told.items()
        }
        sds = {name: number(f"the sd of {_ACTIVATION}.{name}", sd) for name, (_, sd) in told.items() if sd is not None}
        between = content.get(_BETWEEN)
        return Trial(recording, levels, sds, None if between is None else _pair(between))


def _told(path: str, given: object) -> tuple[Any, object]:
    """Level or column, and its sd if that is given."""
    match given:
        case {"value": level, "sd": sd, **rest} if not rest:
            return level, sd
        case {"column": str(column), "sd": sd, **rest} if not rest:
            return column, sd
        case dict():
            raise ScenarioError(
                f'{path} must be a number, a column, or {{ value = …, sd = … }}, {{ column = "…", sd = … }}, '
                f"not {shown(given)}"
            )
    return given, None


def _in_column(column: str, label: str, recording: Recording) -> Array:
    """An activation over time. RecordingError if it is not there at all times."""
    values = recording.true[column]
    if len(gaps := recording.rows[np.isnan(values)]):
        raise RecordingError(f"{recording.source}: {short(label)} has no value in row {gaps[0]:,}")
    return values


def _pair(given: object) -> tuple[float, float]:
    if not isinstance(given, list) or len(given) != 2:
        raise ScenarioError(f"{_BETWEEN} must be two times in s, such as [0.5, 4.5], not {shown(given)}")
    first, last = given
    return first, last


def refuse_repeated(trials: Iterable[Trial]) -> None:
    """ScenarioError if two trials are the same samples of the same muscle, whatever their activations."""
    seen: list[tuple[str, Trial]] = []
    for trial in trials:
        for muscle in trial.activation:
            for other, before in seen:
                if other == muscle and _same(before, trial):
                    raise ScenarioError(
                        f"{trial.recording.source} is given twice for {muscle}; what is measured once counts once"
                    )
            seen.append((muscle, trial))


def _same(one: Trial, other: Trial) -> bool:
    """Whether both have samples in common."""
    a, b = one.recording, other.recording
    if len(a) != len(b) or not all(np.array_equal(a[name], b[name], equal_nan=True) for name in a.measured):
        return False
    everything = -np.inf, np.inf
    (start, end), (first, last) = one.between or everything, other.between or everything
    return start <= last and first <= end
