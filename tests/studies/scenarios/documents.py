"""The table of paths, a document as a scenario, and the sentence with which something is refused."""

from collections.abc import Callable
from typing import Any

from hillobs.model.block import BlockError
from hillobs.studies.files.errors import ResultError, ScenarioError
from hillobs.studies.scenarios.layers import Layer, layer
from hillobs.studies.scenarios.loops import all_paths
from hillobs.studies.scenarios.scenario import Scenario, choices, scenario

PATHS = all_paths()


def document(content: dict[str, Any], changes: dict[str, Any]) -> Scenario:
    """A document with changes on top."""
    layers = [layer("", content), Layer("", changes)]
    return scenario("s", layers, PATHS, choices(layers))


def refusal(attempt: Callable[[], object]) -> str:
    """The sentence with which something is refused; empty if it is done."""
    try:
        attempt()
    except (ScenarioError, BlockError, ResultError) as error:
        return str(error)
    return ""
