"""The numbers of a sweep's runs as a Dataset: one dimension per swept parameter, then seed, observer, quantity."""

from __future__ import annotations

import json
from collections.abc import Mapping

import xarray as xr

from ...codegen.batch import CompiledLoop, Trace
from ..scenarios.prepare import Prepared
from ..simulate.dataset import about, repeatable
from ..simulate.measures import SENTENCES
from ..simulate.step_error import about_error, error_of, step_error
from .causes import causes, flags
from .conditions import by_point, sentences, swept_conditions
from .plan import Plan
from .row import Rows

# whether it takes all numbers as arguments
_CODE = {True: "of any sweep", False: "of this sweep: its fixed numbers are written in"}


def sweep_dataset(
    plan: Plan, rows: Rows, halved: Rows, truth: Trace, identity: str, compiled: CompiledLoop
) -> xr.Dataset:
    """The fields of all rows with names; everything to repeat the sweep is in the attributes.

    halved: the rows of the plan's sample at half the step; truth: the recorded run of the scenario itself, for the gain
    conditions; identity: hash of all that determines the numbers; compiled: the code that ran.
    """
    shape, dimensions = (*plan.axes.shape, len(plan.seeds)), (*plan.axes.dimensions, "seed")
    data = {
        name: ((*dimensions, *inner), rows[name].reshape(*shape, *rows[name].shape[1:]), attributes)
        for name, (inner, attributes) in _fields(plan).items()
    }
    sample = plan.sample()
    data |= {
        error_of(measure): (
            ("sampled", "observer", "quantity"),
            step_error(rows[measure][sample], halved[measure]),
            about_error(measure),
        )
        for measure in plan.measures
    }
    coordinates: dict[str, object] = {
        "sampled": (
            "sampled",
            sample,
            {"long_name": f"run computed again at h/2, counted over {', '.join(dimensions)}"},
        ),
        "seed": plan.seeds,
        "observer": list(plan.observers),
        "quantity": list(plan.quantities),
    }
    for path, values in zip(plan.axes.paths, plan.axes.values, strict=True):
        dimension = path if plan.axes.kind == "grid" else "point"
        coordinates[path] = (dimension, values, _about_axis(plan.prepared, path))
    violated = swept_conditions(plan, truth)
    attributes = {
        "title": f"hillobs: sweep of {plan.prepared.scenario.name}",
        **repeatable(plan.prepared),
        "kind": plan.axes.kind,
        "axes": json.dumps(list(plan.axes.paths)),
        "identity": identity,
        "violated_conditions": json.dumps(sentences(plan.axes, violated)),
        "library": compiled.path.stem,
        "code": _CODE[plan.loop is plan.prepared.loop],
        "target": compiled.target,
        "part": str(plan.part),
    }
    return xr.Dataset(data, coordinates, attributes).assign(by_point(plan.axes, violated))


def _fields(plan: Plan) -> dict[str, tuple[tuple[str, ...], Mapping[str, object]]]:
    """Each field of a row: its dimensions, and what it is."""
    names = causes(plan.prepared.loop, plan.observers)
    return {
        **{measure: (("observer", "quantity"), about(SENTENCES[measure])) for measure in plan.measures},
        "failed_at": (("observer",), about("when the observer failed; NaN if it did not")),
        "plant_failed_at": ((), about("when the plant failed; NaN if not")),
        "failure": (("observer",), flags(names, "what of the observer was no number first, or left its domain")),
        "plant_failure": ((), flags(names, "what of the plant was no number first, or left its domain")),
    }


def _about_axis(prepared: Prepared, path: str) -> dict[str, object]:
    """What a swept parameter is, and the scenario's own value unless it has several."""
    members = prepared.paths.expand(path)
    values = {prepared.value(member) for member in members}
    single = {"scenario_value": values.pop()} if len(values) == 1 else {}
    return {**about(prepared.paths.parameters[members[0]].sentence), **single}
