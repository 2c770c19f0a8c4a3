"""Recordings and muscles as they might be instead: what a likelihood is asked about."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from ...model.curves import DEGROOTE_FREGLY2016, MILLARD2012, THELEN2003, CurveSet
from ..laboratory.muscles import Muscle, MusclePair, numbers_of
from ..laboratory.recording import Recording


@dataclass(frozen=True, eq=False)
class Variant:
    """`sentence` ends "the recording is likelier with …"; mechanical: muscles and their curves have no part in it."""

    name: str
    sentence: str
    recording: Recording
    pair: MusclePair
    mechanical: bool = False
    caution: float = 1.0  # times what another one must gain
    factor: float | None = None  # of the number `name`


# number of a muscle → the factors that are tried, and what it is called
FACTORS = {
    "optimal_fibre_length": ((0.95, 1.05), "optimal fibre lengths"),
    "tendon_slack_length": ((0.98, 1.02), "tendon slack lengths"),
    "F_max": ((0.5, 0.9, 1.1, 2.0), "F_max"),
    "v_max": ((0.2, 0.5, 2.0, 5.0), "v_max"),
}
_MASSES = (0.1, 0.5, 2.0, 10.0)
# those with sizes of their own
_KINDS = (DEGROOTE_FREGLY2016, MILLARD2012, THELEN2003)
_OTHERS = {
    "curves": "curves",
    "mass": "mass",
    "swapped": "which muscle is which",
    "mirrored": "from which wall position is measured",
}
# from here on a factor is no percentage; a muscle so far from the file's must gain more to be named
_TIMES, _CAUTION = 1.5, 2.0


def variants(recording: Recording, pair: MusclePair) -> Iterator[Variant]:
    """All that is tried, both muscles alike."""
    for name, (factors, called) in FACTORS.items():
        for factor in factors:
            first, second = (_scaled(muscle, name, factor) for muscle in (pair.muscle1, pair.muscle2))
            other, caution = replace(pair, muscle1=first, muscle2=second), 1.0 if is_close(factor) else _CAUTION
            yield Variant(name, f"{called} {by(factor)}", recording, other, False, caution, factor)
    for curves in _KINDS:
        if {pair.muscle1.curves.name, pair.muscle2.curves.name} != {curves.name}:
            first, second = (_with_curves(muscle, curves) for muscle in (pair.muscle1, pair.muscle2))
            other = replace(pair, muscle1=first, muscle2=second)
            yield Variant("curves", f"the curves of {curves.name}", recording, other)
    for factor in _MASSES:
        heavier = replace(pair, mass=pair.mass * factor)
        yield Variant("mass", f"a mass {by(factor)}", recording, heavier, mechanical=True, factor=factor)
    swapped = recording.remeasured(force_1=recording["force_2"], force_2=recording["force_1"])
    yield Variant("swapped", "the muscles swapped", swapped, pair, mechanical=True)
    # of muscles that are alike that is the same
    mirrored = recording.remeasured(position=pair.C - recording["position"])
    yield Variant(
        "mirrored", "the position measured from the other wall, C − position", mirrored, pair, mechanical=True
    )


def called(name: str) -> str:
    """What is tried, as a sentence calls it."""
    return FACTORS[name][1] if name in FACTORS else _OTHERS[name]


def _scaled(muscle: Muscle, name: str, factor: float) -> Muscle:
    return replace(muscle, **{name: getattr(muscle, name) * factor})


def _with_curves(muscle: Muscle, curves: CurveSet) -> Muscle:
    """The same muscle with other curves: what both sets know keeps its number, all else has the default."""
    numbers = {name: value for name, value in muscle.numbers.items() if name in numbers_of(curves)}
    return replace(muscle, curves=curves, numbers=numbers, sds={})


def by(factor: float) -> str:
    """`5 % larger`, or `2 times as large`."""
    if not is_close(factor):
        return f"{factor:g} times as large"
    return f"{abs(factor - 1):.0%} {'larger' if factor > 1 else 'smaller'}"


def is_close(factor: float) -> bool:
    """Whether it is a percentage rather than so many times."""
    return 1 / _TIMES < factor < _TIMES
