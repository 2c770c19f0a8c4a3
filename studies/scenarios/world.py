"""What a scenario is about: the paper's pair of muscles, or a mechanism."""

from __future__ import annotations

import functools
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ...codegen.loop import Loop
from ...model.curves import CURVES, SIMULATED, Curves
from ...model.loops.mechanism_loop import DRIVES as MECHANISM_DRIVES
from ...model.plant import DRIVES
from ...model.signals.pulses import PULSES
from ...model.symbols import MUSCLES
from ...model.system import System, pair_system
from ...observers import OBSERVERS, Observer
from ..files.errors import ScenarioError
from ..files.pages import recordings
from ..files.quote import shown, text
from ..laboratory.mechanisms.reading import read_mechanism
from ..laboratory.mechanisms.writing import mechanism_file
from ..laboratory.subject import Subject, is_mechanism, subject_again
from .layers import SUFFIX, Layer
from .loops import DELTAS, all_paths, closed_by, loop_of_mechanism, paper_loop, paths_of_mechanism
from .observers import compiled_with
from .paths import Paths

DRIVE, TRACKS, MECHANISM = "plant.drive", "controller.tracks", "mechanism"
FEEDBACK, DELTA = "controller.feedback", "controller.Delta"
STATES = "states"
# the keys of a scenario of the pair that are no numbers, and what they may be; the first is the default
CHOICES: Mapping[str, tuple[str, ...]] = {
    DRIVE: tuple(DRIVES),
    # what the controller takes for the states, and for Δ: the truth, or estimates
    FEEDBACK: (STATES, *OBSERVERS),
    DELTA: tuple(DELTAS),
    **{f"{muscle}.curves": SIMULATED for muscle in MUSCLES},
}
# several at once, before those of one muscle
GROUPED = {"muscle.curves": tuple(f"{muscle}.curves" for muscle in MUSCLES)}


@dataclass(frozen=True)
class PairWorld:
    """The paper's. choices: all keys that are no numbers, with what was chosen."""

    choices: Mapping[str, str]
    subject: None = None
    pulses: tuple[str, ...] = PULSES

    @property
    def curves(self) -> Curves:
        """The curve sets of both muscles."""
        return curves_of(self.choices)

    @property
    def system(self) -> System:
        """The pair with these curves."""
        return pair_system(self.curves)

    def paths(self, own: tuple[Observer, ...], corrected: bool) -> Paths:
        """The table of all paths; `own` are a user's observers."""
        return all_paths(own, self.curves, corrected)

    def loop(
        self, chosen: Mapping[str, Observer], corrected: bool, quantities: tuple[str, ...], measures: tuple[str, ...]
    ) -> Loop:
        """The closed loop with all registered observers, so that one library serves whatever is asked for.

        Closed on an observer it has a library of its own anyway, with those that are asked for.
        """
        closing = {**OBSERVERS, **chosen}.get(self.choices[FEEDBACK])
        observers = compiled_with(chosen) if closing is None else tuple(chosen.values())
        loop = paper_loop(self.choices[DRIVE], self.curves, observers, corrected, None, quantities, measures)
        if closing is None:
            return loop
        return closed_by(loop, self.choices[DRIVE], self.curves, closing, corrected, self.choices[DELTA])


@dataclass(frozen=True)
class MechanismWorld:
    """A mechanism, by what is in its file."""

    choices: Mapping[str, str]
    subject: Subject
    pulses: tuple[str, ...] = ()

    @property
    def system(self) -> System:
        """Its joints and muscles."""
        return self.subject.system

    @property
    def tracked(self) -> tuple[str, ...]:
        """What the controller leads along the reference."""
        return tuple(name for name in self.choices[TRACKS].replace(",", " ").split())

    def paths(self, own: tuple[Observer, ...], corrected: bool) -> Paths:
        """The table of all paths; `own` are a user's observers."""
        return paths_of_mechanism(self.subject, drives(self.subject), self.tracked, own, corrected)

    def loop(
        self, chosen: Mapping[str, Observer], corrected: bool, quantities: tuple[str, ...], measures: tuple[str, ...]
    ) -> Loop:
        """The closed loop with those chosen alone: there is one library for each mechanism anyway."""
        drive, observers = self.choices[DRIVE], tuple(chosen.values())
        return loop_of_mechanism(self.subject, drive, self.tracked, observers, corrected, quantities, measures)


World = PairWorld | MechanismWorld


def curves_of(choices: Mapping[str, str]) -> Curves:
    """The curve sets that the choices of a scenario or of a result name."""
    first, second = (CURVES[choices.get(path, SIMULATED[0])] for path in GROUPED["muscle.curves"])
    return first if first is second else (first, second)


def world_of(choices: Mapping[str, str], mechanism: str = "") -> World:
    """The world of a scenario with these choices; mechanism: what is in its file, as JSON, or nothing for the pair."""
    if not mechanism:
        return PairWorld({key: choices.get(key, valid[0]) for key, valid in CHOICES.items()})
    return _mechanism_world(json.dumps(dict(choices)), mechanism)


@functools.lru_cache(maxsize=8)
def _mechanism_world(choices: str, mechanism: str) -> MechanismWorld:
    subject, given = subject_again(json.loads(mechanism)), json.loads(choices)
    usual = {DRIVE: drives(subject)[0], TRACKS: ", ".join(controlled(subject))}
    return MechanismWorld({**usual, **given}, subject)


def named_mechanism(layers: Sequence[Layer]) -> str:
    """What is in the mechanism's file that the last layer names which names one, as JSON; nothing if none does.

    A file is looked for beside the scenario's; other names are shipped. ScenarioError if it is none.
    """
    for layer in reversed(layers):
        if MECHANISM in layer.leaves:
            with layer.blamed():
                name = text(MECHANISM, layer.leaves[MECHANISM])
                if not name.endswith(SUFFIX) and name not in shipped_mechanisms():
                    raise ScenarioError(
                        f"unknown {MECHANISM} {shown(name)}; there are {', '.join(shipped_mechanisms())}, "
                        f"or name a {SUFFIX} file"
                    )
                path = shipped_mechanisms().get(name) or Path(layer.origin).parent / name
                return json.dumps(mechanism_file(read_mechanism(path)))
    return ""


@functools.cache
def shipped_mechanisms() -> Mapping[str, Path]:
    """The mechanisms that come with hillobs: name → file."""
    files = sorted(recordings().glob(f"*{SUFFIX}"))
    return {file.stem: file for file in files if is_mechanism(file)}


def controlled(subject: Subject) -> tuple[str, ...]:
    """The joints that muscles move, if they are enough to lead all of them."""
    free = subject.mechanism.tree.free
    return free if len(free) <= len(subject.muscles) else ()


def drives(subject: Subject) -> tuple[str, ...]:
    """The drives of a mechanism, the usual one first: its muscles do what they can of what a controller asks."""
    with_controller = ("requested", "virtual") if controlled(subject) else ()
    return (*with_controller, *(name for name in MECHANISM_DRIVES if name not in DRIVES or name == "given"))
