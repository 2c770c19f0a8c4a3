"""Which numbers are in doubt, and by how much: those of a muscle file, of its pair, and errors of the sensors."""

from __future__ import annotations

import difflib
from collections.abc import Mapping

from ....model.block import Parameter, Parameters
from ....observers.behind.sensitivity import FORCE_BIAS, PENNATION
from ...files.errors import ScenarioError
from ...files.numbers import NUMBER
from ...files.quote import short, shown, table
from ...laboratory.deviations import deviation
from ...laboratory.muscles import PAIR, SIZES, numbers_of
from ...laboratory.subject import Subject

POSITION_BIAS = "position_bias"
# sensors measure in SI
_FORCE, _POSITION, _ANGLE = "N", "m", "rad"

_CHOSEN = "chosen, docs/observers.md#bands"
# relative standard deviations
USUAL: Parameters = {
    name: Parameter(default, f"how far {what} may be off, as a part of it", _CHOSEN, above=0, most=1)
    for name, default, what in (
        ("F_max", 0.05, "the largest isometric force"),
        ("optimal_fibre_length", 0.03, "the optimal fibre length"),
        ("tendon_slack_length", 0.01, "the tendon slack length"),
        ("v_max", 0.1, "the largest shortening velocity"),
        ("tendon_strain", 0.1, "the strain of the tendon"),
        ("passive_strain", 0.05, "the strain of the passive fibre"),
        # what the curves of the paper have instead of strains
        ("k", 0.1, "the stiffness of the tendon"),
        ("k_P", 0.15, "the stiffness of the parallel element, the inverse cube of a strain"),
    )
}

# of curves no number has a unit
_UNITS = {**{key: parameter.unit for key, parameter in {**SIZES, **PAIR}.items()}, FORCE_BIAS: _FORCE}
_UNITS |= {POSITION_BIAS: _POSITION, PENNATION: _ANGLE}


def doubts(subject: Subject, given: Mapping[str, float | str], usual: bool) -> dict[str, float]:
    """Path such as muscle1.F_max → standard deviation in SI.

    given: number of one muscle, or name of that of all → standard deviation, as `deviation` takes it. Where nothing is
    given those of the muscle file count, and where it has none the usual ones; neither if not `usual`. ScenarioError
    names what is unknown or no standard deviation.
    """
    known = _known(subject)
    found: dict[str, float] = {}
    if usual:
        names = {path: path.rpartition(".")[2] for path in known}
        found = {path: USUAL[name].default * abs(known[path][0]) for path, name in names.items() if name in USUAL}
        found |= subject.pair.sds if subject.pair else {}
        found |= {f"{name}.{key}": sd for name, muscle in subject.muscles.items() for key, sd in muscle.sds.items()}
    # those of one muscle come before those of all
    for name, sd in sorted(table("doubt", given).items(), key=lambda item: "." in item[0]):
        paths = [path for path in known if name in (path, path.partition(".")[2])]
        if not paths:
            words = list(dict.fromkeys(path.rpartition(".")[2] for path in known))
            near = difflib.get_close_matches(short(name), [*words, *known], n=3) or words
            raise ScenarioError(f"unknown number {shown(name)} in doubt; the nearest are {', '.join(near)}")
        found |= {path: deviation(path, sd, *known[path]) for path in paths}
    return {path: found[path] for path in known if found.get(path)}


def stated(doubt: Mapping[str, float]) -> dict[str, str]:
    """Number → its standard deviation with its unit; of all muscles together where theirs are the same.

    doubt: as `doubts` returns it.
    """
    found: dict[str, str] = {}
    muscles = dict.fromkeys(path.partition(".")[0] for path in doubt if "." in path)
    for path, sd in doubt.items():
        name = path.rpartition(".")[2]
        alike = [doubt.get(f"{muscle}.{name}") == sd for muscle in muscles if path != name] or [False]
        found[name if all(alike) else path] = f"{sd:.3g} {_UNITS.get(name, '')}".rstrip()
    return found


def parse_doubt(typed: str) -> tuple[str, float | str]:
    """NAME=SD as typed: a number, or a text such as 3% or 0.1mm. ScenarioError if it is not of that form."""
    name, equals, sd = (part.strip() for part in typed.partition("="))
    if not (name and equals and sd):
        raise ScenarioError(f"{shown(typed)} is not NAME=SD, such as optimal_fibre_length=3% or force_bias=5N")
    return name, float(sd) if NUMBER.fullmatch(sd) else sd


def _known(subject: Subject) -> dict[str, tuple[float, str]]:
    """All numbers that may be in doubt: path → value and unit. A bias is 0, else it would be corrected."""
    known: dict[str, tuple[float, str]] = {}
    for name, muscle in subject.muscles.items():
        known |= {f"{name}.{key}": (getattr(muscle, key), parameter.unit) for key, parameter in SIZES.items()}
        for key, parameter in numbers_of(muscle.curves).items():
            known[f"{name}.{key}"] = muscle.numbers[key], parameter.unit
        if muscle.pennation:
            known[f"{name}.{PENNATION}"] = muscle.pennation, _ANGLE
        known[f"{name}.{FORCE_BIAS}"] = 0.0, _FORCE
    if subject.pair is None:
        return known
    known |= {key: (getattr(subject.pair, key), parameter.unit) for key, parameter in PAIR.items()}
    return {**known, POSITION_BIAS: (0.0, _POSITION)}
