"""The numbers of a sweep's runs as a Dataset: one dimension per swept parameter, then seed, observer, quantity."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from ...codegen.batch import CompiledLoop
from ...model.arrays import Array
from ..scenarios.prepare import Prepared
from ..simulate.dataset import about, repeatable
from ..simulate.measures import KINDS
from .causes import causes, flags
from .conditions import Violated, by_point, sentences, swept_conditions
from .plan import Plan


def width(wanted: Plan) -> int:
    """Numbers per run: measures, time and cause of a failure of each observer; time and cause of the plant's."""
    return len(wanted.observers) * (len(wanted.measures) * len(wanted.quantities) + 2) + 2


def sweep_dataset(wanted: Plan, numbers: Array, identity: str, compiled: CompiledLoop, baseline: str) -> xr.Dataset:
    """(runs × width) numbers with names; everything to repeat the sweep is in the attributes.

    identity: hash of all that determines them; compiled, baseline: the code that ran.
    """
    shape = (*wanted.axes.shape, len(wanted.seeds))
    dimensions = (*wanted.axes.dimensions, "seed")
    each = numbers[:, :-2].reshape(*shape, len(wanted.observers), -1)
    by_measure = each[..., :-2].reshape(*shape, len(wanted.observers), len(wanted.measures), len(wanted.quantities))
    names = causes(wanted.prepared.loop, wanted.observers)
    plant_failed_at, plant_failure = numbers[:, -2:].T.reshape(2, *shape)
    data: dict[str, tuple[tuple[str, ...], np.ndarray[Any, Any], Mapping[str, object]]] = {
        name: ((*dimensions, "observer", "quantity"), by_measure[..., i, :], about(KINDS[name]))
        for i, name in enumerate(wanted.measures)
    }
    data["failed_at"] = ((*dimensions, "observer"), each[..., -2], about("when the observer failed; NaN if it did not"))
    data["plant_failed_at"] = (dimensions, plant_failed_at, about("when the plant failed; NaN if not"))
    data["failure"] = (
        (*dimensions, "observer"),
        each[..., -1].astype(np.int16),
        flags(names, "what of the observer was no number first, or left its domain"),
    )
    data["plant_failure"] = (
        dimensions,
        plant_failure.astype(np.int16),
        flags(names, "what of the plant was no number first, or left its domain"),
    )
    coordinates: dict[str, object] = {
        "seed": wanted.seeds,
        "observer": list(wanted.observers),
        "quantity": list(wanted.quantities),
    }
    for path, values in zip(wanted.axes.paths, wanted.axes.values, strict=True):
        where = path if wanted.axes.kind == "grid" else "point"
        coordinates[path] = (where, values, _about_axis(wanted.prepared, path))
    violated = _violated(wanted, compiled)
    attributes = {
        "title": f"hillobs: sweep of {wanted.prepared.scenario.name}",
        **repeatable(wanted.prepared),
        "kind": wanted.axes.kind,
        "axes": json.dumps(list(wanted.axes.paths)),
        "identity": identity,
        "violated_conditions": json.dumps(sentences(wanted.axes, violated)),
        "library": compiled.path.stem,
        "baseline": baseline,
        "part": str(wanted.part),
    }
    return xr.Dataset(data, coordinates, attributes).assign(by_point(wanted.axes, violated))


def _about_axis(prepared: Prepared, path: str) -> dict[str, object]:
    """What a swept parameter is, and the scenario's own value unless it has several."""
    members = prepared.table.expand(path)
    values = {prepared.value(member) for member in members}
    own = {"scenario_value": values.pop()} if len(values) == 1 else {}
    return {**about(prepared.table.paths[members[0]].sentence), **own}


def _violated(wanted: Plan, compiled: CompiledLoop) -> Violated:
    """The gain conditions that do not hold somewhere, with suprema from a run of the scenario itself."""
    prepared = wanted.prepared
    values = {block.name: prepared.table.values(block, prepared.scenario.given) for block in compiled.loop.blocks}
    truth = compiled.run(prepared.grid, prepared.scenario.seed, values, ())[compiled.loop.truth.name]
    return swept_conditions(wanted, truth)
