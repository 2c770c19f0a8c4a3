"""A pair of muscles in SI, from a TOML file, checked key by key, and as such a file again."""

from __future__ import annotations

import difflib
import itertools
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ...model.block import Parameter
from ...model.curves import CURVES, NGUYEN2019_PRINTED, Curves, CurveSet
from ...model.symbols import MUSCLES
from ..files.errors import ScenarioError, TomlError
from ..files.numbers import within
from ..files.quote import short, shown, table, text
from ..files.toml import read_toml
from .curves import SUFFIX, read_curves, tabulated_curves
from .deviations import deviation

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
SCALED: Mapping[str, str] = {
    "F_max": "F_max",
    "optimal_fibre_length": "l_opt",
    "tendon_slack_length": "L_slack",
    "v_max": "v_max",
}
# a number with its standard deviation, as a file has it
_VALUE, _SD = "value", "sd"


@dataclass(frozen=True)
class Muscle:
    """F_max N, lengths m, v_max in own optimal fibre lengths per second; `numbers` are those of the curve set.

    sds: standard deviations of numbers that are known only so well, in their units.
    ScenarioError for what is no number, or beyond the ranges of docs/recordings.md.
    """

    curves: CurveSet
    F_max: float
    optimal_fibre_length: float
    tendon_slack_length: float
    v_max: float
    numbers: Mapping[str, float]
    sds: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not isinstance(self.curves, CurveSet):
            raise ScenarioError(f"curves must be those of a muscle file, not {shown(self.curves)}")
        given, known = table("numbers", self.numbers), numbers_of(self.curves)
        if sorted(given) != sorted(known):
            raise ScenarioError(f"numbers must be {', '.join(known)}, not {', '.join(map(shown, given))}")
        for key, parameter in SIZES.items():
            object.__setattr__(self, key, within(key, getattr(self, key), parameter))
        object.__setattr__(self, "numbers", {key: within(key, given[key], known[key]) for key in known})
        values = {**{key: getattr(self, key) for key in SIZES}, **self.numbers}
        object.__setattr__(self, "sds", _deviations(self.sds, values, {**SIZES, **known}))

    @property
    def sizes(self) -> dict[str, float]:
        """F_max and so on by the names that curve sets have, in SI."""
        return {name: getattr(self, key) for key, name in SCALED.items()}


@dataclass(frozen=True)
class MusclePair:
    """mass kg and C m of the pair; muscle 1 pulls the mass towards position 0, muscle 2 towards C.

    sds: as those of a Muscle.
    """

    mass: float
    C: float
    muscle1: Muscle
    muscle2: Muscle
    description: str = ""
    sds: Mapping[str, float] = field(default_factory=dict)

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
        values = {key: getattr(self, key) for key in PAIR}
        object.__setattr__(self, "sds", _deviations(self.sds, values, PAIR))

    @property
    def curves(self) -> Curves:
        """One set for both, or that of each."""
        first, second = self.muscle1.curves, self.muscle2.curves
        return first if first is second else (first, second)


def read_muscles(path: str | Path) -> MusclePair:
    """The muscles of a TOML file. ScenarioError names the file and the key that is wrong, missing or unknown."""
    if not isinstance(path, str | Path):
        raise ScenarioError(f"muscles are a file's name or a pair that was read, not {shown(path)}")
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
    keys = {name: ["curves", *SIZES, *numbers_of(curves[name])] for name in MUSCLES}
    for place, known in {**keys, _BOTH: list(dict.fromkeys(itertools.chain(*keys.values())))}.items():
        _refuse_unknown(sections[place], known, f"{place}.")
    missing = [key for key in PAIR if key not in content]
    missing += [f"{name}.{key}" for name in MUSCLES for key in SIZES if key not in given[name]]
    if missing:
        raise ScenarioError(f"{', '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing")
    of_pair, sds = _numbers({key: (content[key], key) for key in PAIR}, PAIR)
    muscle1, muscle2 = (_muscle(curves[name], given[name]) for name in MUSCLES)
    description = text("description", content.get("description", ""))
    return MusclePair(**of_pair, muscle1=muscle1, muscle2=muscle2, description=description, sds=sds)


def muscle_file(pair: MusclePair) -> dict[str, object]:
    """The pair as a muscle file, from which `muscle_pair` makes it again, number by number."""
    sections: dict[str, object] = {name: _content(getattr(pair, name)) for name in MUSCLES}
    values = {key: getattr(pair, key) for key in PAIR}
    return {"description": pair.description, **_with_sds(values, pair.sds), **sections}


def _content(muscle: Muscle) -> dict[str, object]:
    curves = muscle.curves
    tables = {name: [list(point) for point in points] for name, points in (curves.tables or {}).items()}
    values = {**{key: getattr(muscle, key) for key in SIZES}, **muscle.numbers}
    return {"curves": tables or curves.name, **_with_sds(values, muscle.sds)}


def _with_sds(values: Mapping[str, float], sds: Mapping[str, float]) -> dict[str, object]:
    return {key: {_VALUE: value, _SD: sds[key]} if key in sds else value for key, value in values.items()}


def _deviations(given: object, values: Mapping[str, float], known: Mapping[str, Parameter]) -> dict[str, float]:
    """The standard deviations of some `values`, checked."""
    sds = table("sds", given)
    if odd := [key for key in sds if key not in known]:
        raise ScenarioError(f"sds must be of {', '.join(known)}, not of {shown(odd[0])}")
    return {key: deviation(key, sd, values[key], known[key].unit) for key, sd in sds.items()}


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


def numbers_of(curves: CurveSet) -> dict[str, Parameter]:
    """What a curve set has beside the sizes; it may be left out."""
    return {key: parameter for key, parameter in curves.parameters.items() if key not in SCALED.values()}


def _muscle(curves: CurveSet, given: Mapping[str, tuple[object, str]]) -> Muscle:
    known = {**SIZES, **numbers_of(curves)}
    values, sds = _numbers({key: pair for key, pair in given.items() if key in known}, known)
    sizes = {key: values.pop(key) for key in SIZES}
    defaults = {key: parameter.default for key, parameter in numbers_of(curves).items()}
    return Muscle(curves, **sizes, numbers={**defaults, **values}, sds=sds)


def _numbers(
    given: Mapping[str, tuple[object, str]], known: Mapping[str, Parameter]
) -> tuple[dict[str, float], dict[str, float]]:
    """Values, and standard deviations of those that have one, of numbers or tables with both."""
    values: dict[str, float] = {}
    sds: dict[str, float] = {}
    for key, (content, path) in given.items():
        value = content
        if isinstance(content, dict):
            if list(content) == [_VALUE]:
                raise ScenarioError(f"{path} has a value without an sd; a number without one stands alone")
            if sorted(content) != [_SD, _VALUE]:
                raise ScenarioError(f"{path} must be a number, or {{ value = …, sd = … }}, not {shown(content)}")
            value = content[_VALUE]
        values[key] = within(path, value, known[key])
        if isinstance(content, dict):
            sds[key] = deviation(path, content[_SD], values[key], known[key].unit)
    return values, sds
