"""The modelDescription.xml of an FMU: what a simulation program knows of it before it loads any code."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from xml.etree import ElementTree

from ...model.block import BlockError
from .manifest import Manifest, Member, one_line

# what each version of FMI calls the same
_WORDS: Mapping[str, Mapping[str, str]] = {
    "2.0": {"token": "guid", "state": "FMUstate"},
    "3.0": {"token": "instantiationToken", "state": "FMUState"},
}
TIME = "time"
# of a unit without `/s`: its powers of base units
_BASE: Mapping[str, Mapping[str, int]] = {
    "m": {"m": 1},
    "rad": {"rad": 1},
    "s": {"s": 1},
    "N": {"kg": 1, "m": 1, "s": -2},
}
_PER_TIME = re.compile(r"(?P<base>\w+?)(/s(?P<power>\d?))?")
_NO_UNIT = ("", "1")
# names like `muscle1.k`, which programs show as trees
_STRUCTURED = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", re.ASCII)


@dataclass(frozen=True)
class Variable:
    """A number that programs see: its value reference, name, what it is, its part in FMI, and what it is at first."""

    reference: int
    name: str
    member: Member
    causality: str
    start: float | None = None


def variables(manifest: Manifest) -> list[Variable]:
    """All in the order of their references, from 1 on: parameters, outputs, inputs; 0 is time.

    Guards are called `guards.L_min`, since a parameter may be the limit that they watch. BlockError if two numbers
    have one name.
    """
    told = len(manifest.estimate) - manifest.guards
    found = [
        *((m.name, m, "parameter", value) for m, value in zip(manifest.params, manifest.defaults, strict=True)),
        *((m.name, m, "output", None) for m in manifest.estimate[:told]),
        *((f"guards.{m.name}", m, "output", None) for m in manifest.estimate[told:]),
        *((m.name, m, "input", 0.0) for m in manifest.input),
    ]
    names = Counter([TIME, *(name for name, *_ in found)])
    if double := [name for name, times in names.items() if times > 1]:
        raise BlockError(f"{manifest.name}: two numbers are called {double[0]!r}, which an FMU cannot tell apart")
    return [Variable(i, *entry) for i, entry in enumerate(found, start=1)]


def model_description(manifest: Manifest, version: str, token: str) -> bytes:
    """The text, for a version of FMI; token: what the library knows it by."""
    known, words = variables(manifest), _WORDS[version]
    names = [variable.name for variable in known]
    root = ElementTree.Element(
        "fmiModelDescription",
        {
            "fmiVersion": version,
            "modelName": manifest.name,
            words["token"]: token,
            "description": one_line(f"{manifest.label}: {manifest.sentence}. {manifest.units}"),
            "generationTool": f"hillobs {manifest.version}",
            "variableNamingConvention": "structured" if all(map(_STRUCTURED.fullmatch, names)) else "flat",
        },
    )
    abilities = (
        "canHandleVariableCommunicationStepSize",
        f"canGetAndSet{words['state']}",
        f"canSerialize{words['state']}",
    )
    about = {"modelIdentifier": manifest.prefix, **dict.fromkeys(abilities, "true")}
    ElementTree.SubElement(root, "CoSimulation", about)
    _units(root, sorted({variable.member.unit for variable in known}.difference(_NO_UNIT)))
    ElementTree.SubElement(ElementTree.SubElement(root, "LogCategories"), "Category", {"name": "logStatusError"})
    ElementTree.SubElement(root, "DefaultExperiment", {"startTime": "0", "stepSize": repr(manifest.period)})
    listed, structure = (ElementTree.SubElement(root, name) for name in ("ModelVariables", "ModelStructure"))
    {"2.0": _second, "3.0": _third}[version](listed, structure, known)
    ElementTree.indent(root)
    text: bytes = ElementTree.tostring(root, encoding="UTF-8", xml_declaration=True)
    return text + b"\n"


def _units(root: ElementTree.Element, units: Sequence[str]) -> None:
    defined = ElementTree.SubElement(root, "UnitDefinitions") if units else root
    for unit in units:
        element = ElementTree.SubElement(defined, "Unit", {"name": one_line(unit)})
        if powers := _powers(unit):
            ElementTree.SubElement(element, "BaseUnit", {name: str(power) for name, power in powers.items()})


def _powers(unit: str) -> dict[str, int]:
    """Of base units, such as {"m": 1, "s": -2}; none of a unit that is not SI."""
    match = _PER_TIME.fullmatch(unit)
    if match is None or match["base"] not in _BASE:
        return {}
    powers = dict(_BASE[match["base"]])
    if unit != match["base"]:
        powers["s"] = powers.get("s", 0) - int(match["power"] or 1)
    return powers


def _second(listed: ElementTree.Element, structure: ElementTree.Element, known: Sequence[Variable]) -> None:
    """Variables and structure of FMI 2.0, which counts variables from 1 on."""
    for variable in known:
        scalar = ElementTree.SubElement(
            listed, "ScalarVariable", {**_about(variable), "valueReference": str(variable.reference)}
        )
        ElementTree.SubElement(scalar, "Real", dict(_numbers(variable)))
    for name in ("Outputs", "InitialUnknowns"):
        unknowns = ElementTree.SubElement(structure, name)
        for index, variable in enumerate(known, start=1):
            if variable.causality == "output":
                ElementTree.SubElement(unknowns, "Unknown", {"index": str(index)})


def _third(listed: ElementTree.Element, structure: ElementTree.Element, known: Sequence[Variable]) -> None:
    """The same of FMI 3.0, where time is a variable."""
    time = {"name": TIME, "valueReference": "0", "causality": "independent", "variability": "continuous"}
    ElementTree.SubElement(listed, "Float64", time)
    for variable in known:
        attributes = {**_about(variable), "valueReference": str(variable.reference), **dict(_numbers(variable))}
        ElementTree.SubElement(listed, "Float64", attributes)
    for name in ("Output", "InitialUnknown"):
        for variable in known:
            if variable.causality == "output":
                ElementTree.SubElement(structure, name, {"valueReference": str(variable.reference)})


def _about(variable: Variable) -> dict[str, str]:
    member, causality = variable.member, variable.causality
    further = {
        "parameter": {"variability": "tunable"},
        "output": {"variability": "discrete", "initial": "calculated"},
        "input": {"variability": "continuous"},
    }
    sentence = one_line(f"{member.sentence}; {member.bounds}" if member.bounds else member.sentence)
    return {"name": variable.name, "description": sentence, "causality": causality, **further[causality]}


def _numbers(variable: Variable) -> Iterator[tuple[str, str]]:
    member = variable.member
    if member.unit not in _NO_UNIT:
        yield "unit", one_line(member.unit)
    for name, value in (("min", member.least), ("max", member.most)):
        if math.isfinite(value):
            yield name, repr(float(value))
    if variable.start is not None:
        yield "start", repr(float(variable.start))
