"""A pair of muscles in SI, from a TOML file, checked key by key, and as such a file again."""

from __future__ import annotations

import difflib
import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from ...model.block import Parameter
from ...model.curves import CURVES, NGUYEN2019_PRINTED, Curves, CurveSet
from ...model.symbols import MUSCLES
from ..files.errors import ScenarioError, TomlError
from ..files.numbers import within
from ..files.quote import short, shown, table, text
from ..files.toml import read_toml
from .curves import SUFFIX, read_curves, tabulated_curves

_FILE = "muscle file"
# No default: a pair is not known without them. The ranges reach decades beyond the smallest muscles of a mouse and the
# largest of an elephant (docs/recordings.md); the upper ones of lengths find millimetres where metres belong.
PAIR: Mapping[str, Parameter] = {
    "mass": Parameter(math.nan, "mass that the muscles pull", _FILE, "kg", least=1e-9, most=1e6),
    "C": Parameter(
        math.nan, "distance between the origins: both muscles' lengths together", _FILE, "m", least=1e-5, below=20
    ),
}
SIZES: Mapping[str, Parameter] = {
    "F_max": Parameter(math.nan, "largest isometric force", _FILE, "N", least=1e-6, most=1e7),
    "optimal_fibre_length": Parameter(math.nan, "fibre length of the largest force", _FILE, "m", least=1e-5, below=10),
    "tendon_slack_length": Parameter(
        math.nan, "length below which the tendon is slack", _FILE, "m", least=1e-6, below=10
    ),
    "v_max": Parameter(
        math.nan,
        "largest shortening velocity, in optimal fibre lengths per second",
        _FILE,
        "1/s",
        least=0.01,
        below=1000,
    ),
}
_BOTH = "muscle"
# what a curve set calls the sizes, in those of muscle 1; they follow from the file
SCALED = ("L_slack", "F_max", "l_opt", "v_max")


@dataclass(frozen=True)
class Muscle:
    """F_max N, lengths m, v_max in own optimal fibre lengths per second; `numbers` are those of the curve set.

    ScenarioError for what is no number, or beyond the ranges of docs/recordings.md.
    """

    curves: CurveSet
    F_max: float
    optimal_fibre_length: float
    tendon_slack_length: float
    v_max: float
    numbers: Mapping[str, float]

    def __post_init__(self) -> None:
        if not isinstance(self.curves, CurveSet):
            raise ScenarioError(f"curves must be those of a muscle file, not {shown(self.curves)}")
        given, known = table("numbers", self.numbers), _numbers_of(self.curves)
        if sorted(given) != sorted(known):
            raise ScenarioError(f"numbers must be {', '.join(known)}, not {', '.join(map(shown, given))}")
        for key, parameter in SIZES.items():
            object.__setattr__(self, key, within(key, getattr(self, key), parameter))
        object.__setattr__(self, "numbers", {key: within(key, given[key], known[key]) for key in known})


@dataclass(frozen=True)
class MusclePair:
    """mass kg and C m of the pair; muscle 1 pulls the mass towards position 0, muscle 2 towards C."""

    mass: float
    C: float
    muscle1: Muscle
    muscle2: Muscle
    description: str = ""

    def __post_init__(self) -> None:
        for key, parameter in PAIR.items():
            object.__setattr__(self, key, within(key, getattr(self, key), parameter))
        for name in MUSCLES:
            if not isinstance(getattr(self, name), Muscle):
                raise ScenarioError(f"{name} must be a Muscle, not {shown(getattr(self, name))}")
        text("description", self.description)
        slack = self.muscle1.tendon_slack_length + self.muscle2.tendon_slack_length
        if self.C <= slack:
            raise ScenarioError(
                f"C = {self.C:g} must be above both tendon slack lengths together, {slack:g}: fibres need room"
            )

    @property
    def curves(self) -> Curves:
        """One set for both, or that of each."""
        first, second = self.muscle1.curves, self.muscle2.curves
        return first if first is second else (first, second)


def read_muscles(path: str | Path) -> MusclePair:
    """The muscles of a TOML file. ScenarioError names the file and the key that is wrong, missing or unknown."""
    try:
        content = read_toml(Path(path))
    except TomlError as error:
        raise ScenarioError(str(error)) from error
    try:
        return muscle_pair(content, Path(path).parent)
    except ScenarioError as error:
        raise ScenarioError(f"{path}: {error}") from error


def muscle_pair(content: Mapping[str, object], folder: Path | None = Path()) -> MusclePair:
    """The muscles of a TOML document: mass, C, [muscle1], [muscle2], or [muscle] for both. ScenarioError as above.

    folder: where files of curves are looked for; None if there must be none.
    """
    sections = {name: _section(content, name) for name in (_BOTH, *MUSCLES)}
    _refuse_unknown(content, [*PAIR, "description", *sections], "")
    # key → value and path, those of one muscle before those of both
    given = {
        name: {key: (value, f"{place}.{key}") for place in (_BOTH, name) for key, value in sections[place].items()}
        for name in MUSCLES
    }
    curves = {name: _curves(name, given[name], folder) for name in MUSCLES}
    keys = {name: ["curves", *SIZES, *_numbers_of(curves[name])] for name in MUSCLES}
    for place, known in {**keys, _BOTH: list(dict.fromkeys(itertools.chain(*keys.values())))}.items():
        _refuse_unknown(sections[place], known, f"{place}.")
    missing = [key for key in PAIR if key not in content]
    missing += [f"{name}.{key}" for name in MUSCLES for key in SIZES if key not in given[name]]
    if missing:
        raise ScenarioError(f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing")
    mass, C = (within(key, content[key], parameter) for key, parameter in PAIR.items())
    muscle1, muscle2 = (_muscle(curves[name], given[name]) for name in MUSCLES)
    return MusclePair(mass, C, muscle1, muscle2, text("description", content.get("description", "")))


def muscle_file(pair: MusclePair) -> dict[str, object]:
    """The pair as a muscle file, from which `muscle_pair` makes it again, number by number."""
    sections: dict[str, object] = {name: _content(getattr(pair, name)) for name in MUSCLES}
    return {"description": pair.description, **{key: getattr(pair, key) for key in PAIR}, **sections}


def _content(muscle: Muscle) -> dict[str, object]:
    curves = muscle.curves
    tables = {name: [list(point) for point in points] for name, points in (curves.tables or {}).items()}
    return {"curves": tables or curves.name, **{key: getattr(muscle, key) for key in SIZES}, **muscle.numbers}


def _section(content: Mapping[str, object], name: str) -> dict[str, object]:
    section = content.get(name, {})
    if not isinstance(section, dict):
        raise ScenarioError(f"{name} must be a table, [{name}], not {shown(section)}")
    return section


def _refuse_unknown(given: Iterable[str], known: list[str], prefix: str) -> None:
    for key in given:
        if key not in known:
            near = difflib.get_close_matches(short(key), known, n=3) or known
            raise ScenarioError(
                f"unknown key {shown(prefix + key)}; the nearest are {', '.join(prefix + name for name in near)}"
            )


def _curves(muscle: str, given: Mapping[str, tuple[object, str]], folder: Path | None) -> CurveSet:
    # the printed toe jumps: no muscle has it
    names = [name for name in CURVES if name != NGUYEN2019_PRINTED.name]
    if "curves" not in given:
        raise ScenarioError(f"{muscle}.curves is missing; there are {', '.join(names)}, or a {SUFFIX} file")
    value, path = given["curves"]
    try:
        if isinstance(value, dict):
            return tabulated_curves(value)
        if isinstance(value, str) and value.endswith(SUFFIX) and folder is not None:
            return read_curves(folder / value)
    except ScenarioError as error:
        raise ScenarioError(f"{path}: {error}") from error
    if not isinstance(value, str) or value not in names:
        raise ScenarioError(f"{path} must be one of {', '.join(names)}, or a {SUFFIX} file, not {shown(value)}")
    return CURVES[value]


def _numbers_of(curves: CurveSet) -> dict[str, Parameter]:
    """What a curve set has beside the sizes; it may be left out."""
    return {key: parameter for key, parameter in curves.parameters.items() if key not in SCALED}


def _muscle(curves: CurveSet, given: Mapping[str, tuple[object, str]]) -> Muscle:
    def number(key: str, parameter: Parameter) -> float:
        value, path = given[key]
        return within(path, value, parameter)

    return Muscle(
        curves,
        **{key: number(key, parameter) for key, parameter in SIZES.items()},
        numbers={
            key: number(key, parameter) if key in given else parameter.default
            for key, parameter in _numbers_of(curves).items()
        },
    )
