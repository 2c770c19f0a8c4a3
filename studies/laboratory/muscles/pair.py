"""The pair: two muscles and the mass between them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from ....model.block import Parameter
from ....model.curves import Curves
from ....model.fibre import PENNATION
from ....model.symbols import MUSCLES
from ...files.errors import ScenarioError, in_file
from ...files.numbers import within
from ...files.quote import shown, text
from ...files.toml import read_toml
from .keys import numbers, refuse_missing, refuse_unknown, section, with_sds
from .muscle import FILE, Muscle, deviations
from .tables import COMMON, MuscleTables, muscle_table

# no default, and ranges as those of the sizes
PAIR: Mapping[str, Parameter] = {
    "mass": Parameter(math.nan, "mass that the muscles pull", FILE, "kg", least=1e-9, most=1e6),
    "C": Parameter(
        math.nan, "distance between the origins: both muscles' lengths together", FILE, "m", least=1e-5, below=20
    ),
}


@dataclass(frozen=True)
class MusclePair:
    """mass kg and C m of the pair; muscle1 pulls the mass towards position 0, muscle2 towards C.

    sds: as those of a Muscle. description: what results say of the pair.
    ScenarioError for what is no number, beyond the ranges of docs/recordings.md, or leaves fibres no room.
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
            if (alpha := getattr(self, name).pennation) != PENNATION.default:
                raise ScenarioError(f"{name}.pennation must be 0, not {alpha:g}: the fibres of a pair are not pennate")
        text("description", self.description)
        slack = self.muscle1.tendon_slack_length + self.muscle2.tendon_slack_length
        if self.C <= slack:
            raise ScenarioError(
                f"C = {self.C:g} must be above both tendon slack lengths together, {slack:g}: fibres need room"
            )
        values = {key: getattr(self, key) for key in PAIR}
        object.__setattr__(self, "sds", deviations(self.sds, values, PAIR))

    @property
    def curves(self) -> Curves:
        """One set for both, or that of each."""
        first, second = self.muscle1.curves, self.muscle2.curves
        return first if first is second else (first, second)


def read_muscles(path: str | Path) -> MusclePair:
    """The muscles of the TOML file `path`, docs/recordings.md.

    ScenarioError names the file and the key that is wrong, missing or unknown.

    >>> pair = hillobs.read_muscles("pair.toml")
    >>> pair.mass, pair.muscle1.optimal_fibre_length
    (20.0, 0.1)
    """
    if not isinstance(path, str | Path):
        raise ScenarioError(f"muscles are a file's name or a pair that was read, not {shown(path)}")
    content = read_toml(Path(path))
    with in_file(Path(path)):
        return muscle_pair(content, Path(path).parent)


def muscle_pair(content: Mapping[str, object], folder: Path | None = Path()) -> MusclePair:
    """The muscles of a TOML document: mass, C, [muscle1], [muscle2], or [muscle] for both. ScenarioError as above.

    folder: where files of curves are looked for; None if there must be none.
    """
    if "joints" in content:
        raise ScenarioError("it has joints, so it is a mechanism: --mechanism, or read_mechanism")
    common, *each = (section(content, name) for name in (COMMON, *MUSCLES))
    refuse_unknown(content, [*PAIR, "description", COMMON, *MUSCLES], "")
    tables = MuscleTables.read(common, dict(zip(MUSCLES, each, strict=True)), folder)
    refuse_missing([*(key for key in PAIR if key not in content), *tables.missing])
    of_pair, sds = numbers({key: (content[key], key) for key in PAIR}, PAIR)
    muscle1, muscle2 = tables.muscles()
    description = text("description", content.get("description", ""))
    return MusclePair(**of_pair, muscle1=muscle1, muscle2=muscle2, description=description, sds=sds)


def muscle_file(pair: MusclePair) -> dict[str, object]:
    """The pair as a muscle file, from which `muscle_pair` makes it again, number by number."""
    sections: dict[str, object] = {name: muscle_table(getattr(pair, name)) for name in MUSCLES}
    values = {key: getattr(pair, key) for key in PAIR}
    return {"description": pair.description, **with_sds(values, pair.sds), **sections}
