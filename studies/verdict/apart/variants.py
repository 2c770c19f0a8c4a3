"""Recordings and mechanisms as they might be instead: what a likelihood is asked about."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import combinations

from ...files.errors import RecordingError, ScenarioError
from ...laboratory.mechanisms.mechanism import Mechanism
from ...laboratory.recording import Recording
from ...laboratory.subject import Subject, subject_of
from ..doubts import Weighed
from ..muscles import ROUGH, WHERE_ROUGH
from ..variants import FACTORS, by, is_close
from .weighing import Weighing

_CALLED = {"optimal_fibre_length": "the optimal fibre length", "tendon_slack_length": "the tendon slack length"}
# an angle in degrees that is taken for radians, and the other way round
_DEGREES = 180 / math.pi
# what a number of one muscle must gain, in what most must: half, since a pair has two, and more if it is far off
_CLOSE, _FAR = 0.5, 3.0
# of masses that the file has too large; too small ones are told by links that no muscle moves
_LIGHTER, _IMMOVABLE = (0.1, 0.5), 1e3


@dataclass(frozen=True)
class Variant:
    """What is tried, without its gain, and what that is to be asked of."""

    what: Weighed
    gain: Callable[[], float]

    def weighed(self) -> Weighed:
        """The same with its gain; None where the likelihood does not know of it, or it can be nothing at all."""
        if not self.what.telling:
            return self.what
        try:
            gain = self.gain()
        except (RecordingError, ScenarioError):
            return self.what
        return replace(self.what, gain=gain if math.isfinite(gain) else None)


def variants(weighing: Weighing, read: Recording, subject: Subject, needed: float, rough: bool) -> Iterator[Variant]:
    """All that is tried: each muscle's numbers, forces of two exchanged, angles, masses.

    needed: log L that most must gain; rough: whether activations jump.
    """
    yield from _of_muscles(weighing, subject, needed, rough)
    yield from _of_recordings(weighing, read, subject, needed)
    if subject.mechanism.tree.free:
        yield from _of_masses(weighing, subject.mechanism, needed)


def _of_muscles(weighing: Weighing, subject: Subject, needed: float, rough: bool) -> Iterator[Variant]:
    for of, muscle in subject.muscles.items():
        helps = weighing.activations[of].fit.log_likelihood > weighing.inputs[of].fit.log_likelihood
        for number, (factors, _) in FACTORS.items():
            telling, name = helps and (not rough or number == WHERE_ROUGH), _CALLED.get(number, number)
            for factor in factors:
                other = replace(muscle, **{number: getattr(muscle, number) * factor})
                least = needed * (_CLOSE if is_close(factor) else _FAR) * (ROUGH if rough else 1.0)
                sentence = f"{name} of {of} {by(factor)}"
                what = Weighed(f"{of}.{number}", name, factor, sentence, None, telling, least, alone=False)
                yield Variant(what, functools.partial(weighing.other_muscle, of, other))


def _of_recordings(weighing: Weighing, read: Recording, subject: Subject, needed: float) -> Iterator[Variant]:
    def variant(name: str, sentence: str, scale: float, **measured: str) -> Variant:
        """Columns, and which others they are, all times `scale`."""
        columns = {column: scale * read[other] for column, other in measured.items()}
        what = Weighed(name, name, None, sentence, None, True, needed, alone=True)
        return Variant(what, functools.partial(weighing.other_recording, read.remeasured(**columns), abs(scale)))

    forces = zip(subject.names["force"], subject.muscles, strict=True)
    for (one, a), (other, b) in combinations(forces, 2):
        name, sentence = f"which force is that of {a} and of {b}", f"the forces of {a} and {b} exchanged"
        yield variant(name, sentence, 1.0, **{one: other, other: one})
    for name, bound in subject.positions.items():
        yield variant(f"the sign of {name}", f"{name} inverted", -1.0, **{name: name})
        # without noise the resolution of arithmetic would decide how likely an angle of another size is
        if bound.unit == "rad" and weighing.noisy:
            for unit, scale in (("degrees", 1 / _DEGREES), ("radians", _DEGREES)):
                yield variant(f"the unit of {name}", f"{name} in {unit}", scale, **{name: name})


def _of_masses(weighing: Weighing, mechanism: Mechanism, needed: float) -> Iterator[Variant]:
    def gain(factor: float) -> float:
        links = {
            name: replace(link, mass=link.mass * factor, inertia=tuple(factor * value for value in link.inertia))
            for name, link in mechanism.tree.links.items()
        }
        other = replace(mechanism, tree=replace(mechanism.tree, links=links))
        return weighing.other_masses(subject_of(other).laws)

    sentences = {factor: f"masses {by(factor)}" for factor in _LIGHTER}
    sentences[_IMMOVABLE] = (
        "joints that no muscle moves: masses may be larger, forces exchanged or in another unit, or an angle inverted"
    )
    for factor, sentence in sentences.items():
        name = "masses" if factor in _LIGHTER else "whether muscles move the joints"
        what = Weighed(name, name, factor, sentence, None, weighing.forceful, needed, alone=True)
        yield Variant(what, functools.partial(gain, factor))
