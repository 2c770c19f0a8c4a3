"""A Plan as text and back: what a worker needs to know of a sweep, as plain data."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...files.errors import ScenarioError
from ...scenarios.observers import observers_named, own_among
from ...scenarios.prepare import assemble
from ...scenarios.scenario import Scenario
from ..axes import Axes
from ..plan import Plan


def text_of(plan: Plan) -> str:
    """A Plan as JSON, each number to its last bit. ScenarioError if it holds an observer that is not ours."""
    prepared = plan.prepared
    for name in own_among(prepared.chosen):
        raise ScenarioError(f"{name} is a Block of this process, which no text can send; sweep it without a cluster")
    scenario = prepared.scenario
    about = [scenario.name, scenario.description, scenario.seed, dict(scenario.choices), dict(scenario.given)]
    content = {
        "scenario": [*about, {}, scenario.mechanism],
        "prepared": [list(prepared.observers), prepared.corrected],
        # the values themselves: another machine's exp may round a range otherwise
        "axes": [plan.axes.kind, dict(zip(plan.axes.paths, (v.tolist() for v in plan.axes.values), strict=True))],
        "seeds": plan.seeds.tolist(),
        "observers": list(plan.observers),
        "scored": [list(plan.quantities), list(plan.measures)],
        "part": plan.part,
    }
    return json.dumps(content, allow_nan=False)


def plan_of(text: str) -> Plan:
    """The Plan that `text_of` has written."""
    content: Mapping[str, Any] = json.loads(text)
    kind, axes = content["axes"]
    quantities, measures = (tuple(names) for names in content["scored"])
    observers, corrected = content["prepared"]
    return Plan(
        assemble(Scenario(*content["scenario"]), observers_named(observers), quantities, measures, corrected),
        Axes(kind, tuple(axes), tuple(np.array(values, dtype=float) for values in axes.values())),
        np.array(content["seeds"], dtype=np.uint64),
        tuple(content["observers"]),
        content["part"],
    )
