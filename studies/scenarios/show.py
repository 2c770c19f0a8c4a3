"""A scenario as a complete, commented TOML file to start from, and the table of all parameters."""

from __future__ import annotations

from collections.abc import Iterator

from ...model.block import Parameter
from ..files.toml import toml_value
from .prepare import prepare
from .world import CHOICES, DRIVE, drives


def show(source: str) -> str:
    """The TOML of a scenario with every number, its unit, meaning and source. ScenarioError if there is none."""
    prepared = prepare(source, None, {})
    scenario, paths = prepared.scenario, prepared.paths
    sections: dict[str, list[str]] = {"": [f"description = {toml_value(scenario.description)}"]}
    sections[""].append(f"seed = {scenario.seed}  # of the measurement noise")
    world = scenario.world
    valid_choices = CHOICES if world.subject is None else {DRIVE: drives(world.subject)}
    for path, chosen in world.choices.items():
        section, _, key = path.rpartition(".")
        of = f"  # one of {', '.join(valid_choices[path])}" if path in valid_choices else ""
        sections.setdefault(section, []).append(f"{key} = {toml_value(chosen)}{of}")
    for path, parameter in paths.parameters.items():
        section, _, key = path.rpartition(".")
        line = f"{key} = {prepared.value(path)!r}"
        if parameter.shared and parameter.shared != path and path not in scenario.given:
            line = f"# {line}  # follows {parameter.shared} unless set here"
        else:
            line = f"{line}  # {describe(parameter)}"
        sections.setdefault(section, []).append(line)
    return "\n".join(_lines(sections)) + "\n"


def describe(parameter: Parameter) -> str:
    """Meaning, unit and source in one line."""
    unit = "" if parameter.unit == "1" else f" [{parameter.unit}]"
    return f"{parameter.sentence}{unit} ({parameter.source})"


def _lines(sections: dict[str, list[str]]) -> Iterator[str]:
    for name, lines in sections.items():
        if name:
            yield f"\n[{name}]"
        yield from lines
