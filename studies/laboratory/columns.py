"""The columns of a recording: what each is called, what it measures, and which column of a file it is."""

from __future__ import annotations

import difflib
import functools
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from ..files.errors import RecordingError
from ..files.quote import short, shown
from .units import IN_DEGREES, SI, UNITS, Unit, find_unit, unit_of


@dataclass(frozen=True, eq=False)
class Columns:
    """The columns of a recording: those that it must have beside time, and all by name → quantity.

    opensim: name → what OpenSim calls it; theirs: further names of OpenSim's files, as patterns → name.
    """

    required: tuple[str, ...]
    known: Mapping[str, str]
    opensim: Mapping[str, str]
    theirs: Mapping[re.Pattern[str], str] = field(default_factory=dict)

    def name(self, text: str) -> str:
        """The name that a text stands for, in any case, with American spelling; or an empty string."""
        plain = text.strip()
        ours = next((name for pattern, name in self.theirs.items() if pattern.fullmatch(plain)), plain)
        plain = next((name for name, theirs in self.opensim.items() if theirs == plain), ours)
        low = plain.lower().replace(" ", "_").replace("fiber", "fibre")
        return self._cased.get(low, "")

    @functools.cached_property
    def _cased(self) -> Mapping[str, str]:
        return {name.lower(): name for name in self.known}


# positions are those of the mass, forces those of the tendons
_KNOWN: Mapping[str, str] = {
    "time": "time",
    "position": "length",
    "force_1": "force",
    "force_2": "force",
    "velocity": "velocity",
    "acceleration": "acceleration",
    "tendon_length_1": "length",
    "tendon_length_2": "length",
    "fibre_length_1": "length",
    "fibre_length_2": "length",
    "fibre_velocity_1": "velocity",
    "fibre_velocity_2": "velocity",
    "activation_1": "number",
    "activation_2": "number",
    "excitation_1": "number",
    "excitation_2": "number",
    "disturbance": "force",
    # where both are there, these are the inputs and the plain ones the truth
    "position_measured": "length",
    "force_1_measured": "force",
    "force_2_measured": "force",
}

# the names that OpenSim gives the states and outputs of a model with a slider and two muscles
_OPENSIM: Mapping[str, str] = {
    "time": "time",
    "position": "/jointset/slider/position/value",
    "velocity": "/jointset/slider/position/speed",
    "acceleration": "/jointset/slider/position|acceleration",
    **{
        f"{ours}_{j}": f"/forceset/m{j}{theirs}"
        for ours, theirs in (
            ("activation", "/activation"),
            ("fibre_length", "/fiber_length"),
            ("fibre_velocity", "|fiber_velocity"),
            ("tendon_length", "|tendon_length"),
            ("force", "|tendon_force"),
            ("excitation", "|excitation"),
        )
        for j in (1, 2)
    },
    "disturbance": "/forceset/disturbance|actuation",
}
COLUMNS = Columns(("position", "force_1", "force_2"), _KNOWN, _OPENSIM)

_BRACKET = re.compile(r"(?P<name>.*?)\s*[\[(](?P<unit>[^\[\]()]*)[\])]")


@dataclass(frozen=True)
class Column:
    """A known column, where in the file it is, and its unit there."""

    name: str
    label: str
    index: int
    unit: Unit


def name_and_unit(label: str, columns: Columns = COLUMNS) -> tuple[str, str]:
    """Name and unit of a label such as `position [mm]`, `Force_1 (N)`, `time_s`; the unit may be empty."""
    label = label.strip()
    if known := columns.name(label):
        return known, ""
    if match := _BRACKET.fullmatch(label):
        return columns.name(match["name"]) or match["name"], match["unit"].strip() or "1"
    head, _, tail = label.rpartition("_")
    if (known := columns.name(head)) and _suffix(label, columns.known[known]):
        return known, tail
    return label, ""


def choose(
    labels: Sequence[str],
    units: Sequence[str],
    mapping: Mapping[str, str],
    known: Columns = COLUMNS,
    in_degrees: bool = False,
    timeless: bool = False,
) -> list[Column]:
    """The columns of a file that are known by name or by `mapping` (name → label, or `label[unit]`), time first.

    labels: the names of all columns. units: a unit for each from elsewhere, empty where there is none. in_degrees: what
    turns is in degrees where nothing else is said. timeless: time may be missing.
    RecordingError if time or what is required is missing, a unit is wrong, or a name is there twice.
    """
    for name in mapping:
        if name not in known.known:
            near = difflib.get_close_matches(short(name), known.known, n=3) or ["time", *known.required]
            raise RecordingError(f"{shown(name)} is no column of a recording; the nearest are {', '.join(near)}")
    plain = [name_and_unit(label, known) for label in labels]
    columns: dict[str, Column] = {}
    for name in sorted(known.known, key=lambda name: name not in mapping):
        asked, taken = "", {column.index: column.name for column in columns.values()}
        if name in mapping:
            index, asked = _mapped(name, mapping[name], labels, plain)
            if index in taken:
                raise RecordingError(f"column {shown(labels[index])} is mapped to both {taken[index]} and {name}")
        else:
            places = [i for i, (found, _) in enumerate(plain) if found == name and i not in taken]
            if len(places) > 1:
                raise RecordingError(f"{name} is there twice, in columns {_two(places)}; say which by a mapping")
            if not places:
                continue
            index = places[0]
        quantity = known.known[name]
        given = (asked, _written_unit(labels[index], plain[index], asked, quantity), units[index])
        usual = IN_DEGREES.get(quantity, SI[quantity]) if in_degrees else SI[quantity]
        columns[name] = Column(name, labels[index].strip(), index, _agreed(given, quantity, usual, labels[index]))
    needed = (*(() if timeless else ("time",)), *known.required)
    if missing := [name for name in needed if name not in columns and f"{name}_measured" not in columns]:
        name, *others = missing
        taken_by = [column.name for column in columns.values() if plain[column.index][0] == name]
        why = f"{shown(name)} is mapped to {taken_by[0]}" if taken_by else _there(name, labels)
        too = f"; nor is there {' or '.join(others)}" if others else ""
        cure = f"; a mapping says which it is: --map {name}=COLUMN[UNIT]" if any(map(str.strip, labels)) else ""
        raise RecordingError(f"there is no column {name}; {why}{too}{cure}")
    return [columns[name] for name in known.known if name in columns]


def _mapped(name: str, target: str, labels: Sequence[str], plain: Sequence[tuple[str, str]]) -> tuple[int, str]:
    """The place of a mapped column, and the unit asked for."""
    label, asked = target.strip(), ""
    there = [text.strip() for text in labels]
    if label not in there and (match := _BRACKET.fullmatch(label)):
        label, asked = match["name"], match["unit"].strip() or "1"
    places = [i for i, text in enumerate(there) if text == label]
    places = places or [i for i, (known, _) in enumerate(plain) if known == label]
    if not places:
        raise RecordingError(f"{name} is mapped to {shown(label)}, which is not there; {_there(label, labels)}")
    if len(places) > 1:
        raise RecordingError(f"{name} is mapped to {shown(label)}, which is there twice, in columns {_two(places)}")
    return places[0], asked


def _written_unit(label: str, plain: tuple[str, str], asked: str, quantity: str) -> str:
    """The unit in a label. `Force (left)` has none, if the mapping says which one is meant."""
    unit = plain[1] or _suffix(label.strip(), quantity)
    return "" if asked and not find_unit(unit) else unit


def _suffix(label: str, quantity: str) -> str:
    """`mm` of `block_x_mm`, if that is a unit of the quantity or, to be refused, of an angle."""
    tail = label.rpartition("_")[2]
    return tail if tail in UNITS and UNITS[tail].quantity in (quantity, "angle") and tail.isalpha() else ""


def _agreed(given: Sequence[str], quantity: str, usual: Unit, label: str) -> Unit:
    where = f"column {shown(label.strip())}"
    # a length of unit 1 is one without a unit, as our own dimensionless results have it
    told = [text for text in given if text and (quantity == "number" or find_unit(text) != UNITS["1"])]
    units = [unit_of(text, quantity, where) for text in told]
    for unit in units[1:]:
        if unit != units[0]:
            raise RecordingError(f"{where}: its unit is {units[0].symbol} in one place and {unit.symbol} in another")
    return units[0] if units else usual


def _two(places: Sequence[int]) -> str:
    return f"{places[0] + 1} and {places[1] + 1}"


def _there(missing: str, labels: Sequence[str]) -> str:
    """What is there instead, the nearest names first."""
    names = [label.strip() for label in labels if label.strip()]
    near = difflib.get_close_matches(short(missing), [short(name) for name in names[:200]], n=3, cutoff=0.5)
    if near:
        return f"the nearest are {', '.join(map(shown, near))}"
    more = f" and {len(names) - 8} more" if len(names) > 8 else ""
    return f"there are {', '.join(map(shown, names[:8]))}{more}" if names else "no column has a name"
