"""Scenarios: what is simulated, checked leaf by leaf against the table of all numbers."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from ...observers import OBSERVERS, Observer, estimator_of
from ...observers.feedback import RATE
from ..files.errors import ScenarioError
from ..files.numbers import parse_number, within
from ..files.numbers import seed as checked_seed
from ..files.quote import shown, text
from ..laboratory.subject import Subject, subject_again
from .layers import SUFFIX, Layer, Value, changes_of
from .paths import Paths
from .world import (
    CHOICES,
    DELTA,
    DRIVE,
    FEEDBACK,
    GROUPED,
    MECHANISM,
    STATES,
    TRACKS,
    World,
    controlled,
    drives,
    world_of,
)

_WHOLE = re.compile(r"[+-]?\d{1,20}", re.ASCII)

Numbers = Mapping[str, float]

# each path whose value is one of some names, with these names; groups too
VALID_CHOICES: Mapping[str, tuple[str, ...]] = {
    **CHOICES,
    **{group: CHOICES[members[0]] for group, members in GROUPED.items()},
}
# those whose value is any text
_TEXTS_OF_MECHANISMS = (MECHANISM, TRACKS)
TEXTS = ("description", *_TEXTS_OF_MECHANISMS)


@dataclass(frozen=True)
class Scenario:
    """A name, a sentence, the choices, and the numbers that are given, by path; `changes` are those beside its file.

    mechanism: what is in its file, as JSON; nothing for the pair.
    """

    name: str
    description: str = ""
    seed: int = 0
    choices: Mapping[str, str] = field(default_factory=dict)
    given: Numbers = field(default_factory=dict)
    changes: Mapping[str, object] = field(default_factory=dict)
    mechanism: str = ""

    @property
    def world(self) -> World:
        """What it is about."""
        return world_of(self.choices, self.mechanism)

    @property
    def drive(self) -> str:
        """How the plant is driven."""
        return self.world.choices[DRIVE]


def choices(
    layers: Sequence[Layer], mechanism: str = "", own: Mapping[str, Observer] = MappingProxyType({})
) -> dict[str, str]:
    """The choices of the layers, the last one above. ScenarioError names the wrong one, and its layer.

    mechanism: what is in its mechanism's file as JSON, or nothing for the pair; own: a user's observers, any of which
    may close the loop of the pair.
    """
    if not mechanism:
        valid = {**VALID_CHOICES, FEEDBACK: (*VALID_CHOICES[FEEDBACK], *own)}
        chosen = _chosen(layers, (*GROUPED.items(), *((path, (path,)) for path in CHOICES)), valid)
        _check_feedback({path: chosen.get(path, names[0]) for path, names in CHOICES.items()}, own)
        return chosen
    subject = subject_again(json.loads(mechanism))
    chosen = _chosen(layers, [(DRIVE, (DRIVE,))], {DRIVE: drives(subject)})
    for layer in layers:
        with layer.blamed():
            if MECHANISM in layer.leaves:
                chosen[MECHANISM] = text(MECHANISM, layer.leaves[MECHANISM])
            if TRACKS in layer.leaves:
                chosen[TRACKS] = _tracked(text(TRACKS, layer.leaves[TRACKS]), subject)
    return chosen


def _chosen(
    layers: Sequence[Layer], groups: Iterable[tuple[str, tuple[str, ...]]], valid: Mapping[str, tuple[str, ...]]
) -> dict[str, str]:
    chosen: dict[str, str] = {}
    for layer in layers:
        with layer.blamed():
            for group, members in groups:
                if group in layer.leaves:
                    chosen |= dict.fromkeys(members, _choice(group, layer.leaves[group], valid[group]))
    return chosen


def _check_feedback(chosen: Mapping[str, str], own: Mapping[str, Observer]) -> None:
    feedback = chosen[FEEDBACK]
    if feedback != STATES and chosen[DRIVE] == "given":
        raise ScenarioError(f"{FEEDBACK} = {feedback} needs a controller, and {DRIVE} = given has none")
    known, _, with_rate = CHOICES[DELTA]
    if feedback == STATES and chosen[DELTA] != known:
        raise ScenarioError(f"{DELTA} = {chosen[DELTA]} needs an observer that estimates it: name it as {FEEDBACK}")
    if chosen[DELTA] == with_rate and RATE not in estimator_of({**OBSERVERS, **own}[feedback], corrected=False).x:
        raise ScenarioError(f"{DELTA} = {with_rate} needs an observer that estimates it, and {feedback} does not")


def _tracked(typed: str, subject: Subject) -> str:
    """Names of places, with commas between."""
    names, known = typed.replace(",", " ").split(), subject.laws.places(np.zeros(len(subject.joints)))
    if unknown := [name for name in names if name not in known]:
        raise ScenarioError(f"{TRACKS}: {shown(unknown[0])} cannot be led; there are {', '.join(known)}")
    most = len(controlled(subject))
    if not 0 < len(set(names)) == len(names) <= most:
        raise ScenarioError(f"{TRACKS} must be one to {most} places, each once, not {shown(typed)}")
    return ", ".join(names)


def scenario(
    name: str, layers: Sequence[Layer], paths: Paths, chosen: Mapping[str, str], mechanism: str = ""
) -> Scenario:
    """The scenario of the layers, the last one above. ScenarioError names the wrong leaf, and its layer.

    chosen: its choices; mechanism: what is in its mechanism's file as JSON, if it has one.
    """
    no_numbers = {*_TEXTS_OF_MECHANISMS, DRIVE} if mechanism else VALID_CHOICES
    description, seed = "", 0
    given: dict[str, float] = {}
    for layer in layers:
        with layer.blamed():
            numbers: dict[str, float] = {}
            for path, value in layer.leaves.items():
                if path == "description":
                    description = text(path, value)
                elif path == "seed":
                    seed = checked_seed(path, value)
                elif path not in no_numbers and not _is_empty_section(path, value, paths):
                    numbers[path] = checked_number(path, value, paths)
            given |= paths.spread(numbers)
    changes = {path: value for layer in layers if not layer.origin for path, value in layer.leaves.items()}
    return Scenario(name, description, seed, chosen, given, changes, mechanism)


def typed_changes(typed: str) -> dict[str, Value]:
    """`PATH=VALUE` as typed on a command line, or the name of a .toml file with such numbers: path → value."""
    return changes_of(typed) if typed.endswith(SUFFIX) and "=" not in typed else dict([parse_change(typed)])


def parse_change(typed: str) -> tuple[str, Value]:
    """`PATH=VALUE` as typed on a command line."""
    path, equals, value = typed.partition("=")
    if not equals or not path:
        raise ScenarioError(f"{shown(typed)} is not PATH=VALUE, such as plant.m=1.2")
    if path in VALID_CHOICES or path in TEXTS:
        return path, value
    number = parse_number(path, value)
    return path, number if path != "seed" else _whole(value)


def checked_number(path: str, value: object, paths: Paths) -> float:
    """The number at `path`, within the bounds of its parameter. ScenarioError says what it must be."""
    return within(path, value, paths.parameters[paths.expand(path)[0]])


def _is_empty_section(path: str, value: object, paths: Paths) -> bool:
    return isinstance(value, dict) and not value and paths.is_section(path)


def _choice(path: str, value: object, valid: tuple[str, ...]) -> str:
    if not isinstance(value, str) or value not in valid:
        raise ScenarioError(f"{path} must be one of {', '.join(valid)}, not {shown(value)}")
    return value


def _whole(typed: str) -> Value:
    return int(typed) if _WHOLE.fullmatch(typed) else float(typed)
