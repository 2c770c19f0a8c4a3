"""The tables of muscles in a TOML file: one for all of them, and one for each, which counts more."""

from __future__ import annotations

import itertools
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path

from ....model.block import Parameter
from ....model.curves import CURVES, NGUYEN2019_PRINTED, CurveSet
from ....model.fibre import PENNATION
from ...files.errors import ScenarioError, in_file
from ...files.quote import shown
from ..curves import SUFFIX, read_curves, tabulated_curves
from .keys import numbers, refuse_unknown, with_sds
from .muscle import SIZES, Muscle, numbers_of

COMMON = "muscle"


@dataclass(frozen=True)
class MuscleTables:
    """What a file says of each muscle, by the place of its table: curves, and key → content and path.

    ScenarioError from `read` names a key that is wrong or unknown, from `muscles` a number.
    """

    given: Mapping[str, Mapping[str, tuple[object, str]]]
    curves: Mapping[str, CurveSet]
    optional: Mapping[str, Parameter]

    @staticmethod
    def read(
        common: Mapping[str, object],
        each: Mapping[str, Mapping[str, object]],
        folder: Path | None,
        optional: Mapping[str, Parameter] | None = None,
        beside: Collection[str] = (),
    ) -> MuscleTables:
        """Of the table [muscle] and those of each place. `optional` sizes; `beside`: keys that others read.

        folder: where files of curves are looked for; None if there must be none.
        """
        optional = optional or {}
        given = {
            place: {
                key: (value, f"{where}.{key}")
                for where, table in ((COMMON, common), (place, own))
                for key, value in table.items()
            }
            for place, own in each.items()
        }
        curves = {place: _curves(place, given[place], folder) for place in each}
        keys = {place: ["curves", *SIZES, *optional, *numbers_of(curves[place])] for place in each}
        for place, own in each.items():
            refuse_unknown(own, [*keys[place], *beside], f"{place}.")
        refuse_unknown(common, list(dict.fromkeys(itertools.chain(*keys.values()))), f"{COMMON}.")
        return MuscleTables(given, curves, optional)

    @property
    def missing(self) -> list[str]:
        """The paths of sizes that a muscle is not known without."""
        return [f"{place}.{key}" for place, given in self.given.items() for key in SIZES if key not in given]

    def muscles(self) -> list[Muscle]:
        """The muscles, of which no size is missing."""
        return [self._muscle(place) for place in self.given]

    def _muscle(self, place: str) -> Muscle:
        curves, given = self.curves[place], self.given[place]
        own = {**SIZES, **self.optional}
        known = {**own, **numbers_of(curves)}
        values, sds = numbers({key: pair for key, pair in given.items() if key in known}, known)
        sizes = {key: values.pop(key) for key in own if key in values}
        return Muscle(curves, **sizes, numbers=values, sds=sds)


def muscle_table(muscle: Muscle) -> dict[str, object]:
    """The muscle as a table of a file; what is not pennate does not say so."""
    curves = muscle.curves
    points = {name: [list(point) for point in points] for name, points in (curves.tables or {}).items()}
    values = {key: value for key, value in muscle.values.items() if key != "pennation" or value != PENNATION.default}
    return {"curves": points or curves.name, **with_sds(values, muscle.sds)}


def _curves(muscle: str, given: Mapping[str, tuple[object, str]], folder: Path | None) -> CurveSet:
    # the printed toe jumps: no muscle has it
    names = [name for name in CURVES if name != NGUYEN2019_PRINTED.name]
    if "curves" not in given:
        raise ScenarioError(f"{muscle}.curves is missing; there are {', '.join(names)}, or a {SUFFIX} file")
    value, path = given["curves"]
    with in_file(path):
        if isinstance(value, dict):
            return tabulated_curves(value)
        if isinstance(value, str) and value.endswith(SUFFIX) and folder is not None:
            return read_curves(folder / value)
    if not isinstance(value, str) or value not in names:
        raise ScenarioError(f"{path} must be one of {', '.join(names)}, or a {SUFFIX} file, not {shown(value)}")
    return CURVES[value]
