"""What the kernel recorded as a Dataset, with everything a run can be repeated from."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from ...codegen.batch import Trace
from ...codegen.failure import Failure
from ...model.arrays import Array
from ...model.symbols import MEASURED, QUANTITIES, SIGNALS, STATES, hat
from ...observers.behind.spread import SPREADS, sd
from ..files.versions import versions
from ..scenarios.paths import RUN, block_paths
from ..scenarios.prepare import BASELINE, Prepared
from ..scenarios.scenario import CHOICES
from .conditions import gain_conditions
from .failures import observer_failure, plant_failure
from .measures import SENTENCES, measures
from .step_error import about_error, error_of, step_error


def dataset(
    prepared: Prepared, traces: Mapping[str, Trace], halved: Mapping[str, Mapping[str, float]], library: str
) -> xr.Dataset:
    """The Dataset that `simulate` describes.

    halved: the score of each estimator in the same run at half the step; library: names the code that ran.
    """
    loop, grid = prepared.loop, prepared.grid
    truth, n = traces["truth"], grid.steps // grid.record + 1
    signal = dict(zip(loop.truth.y, truth.y.T, strict=True))
    observers, estimators = list(prepared.observers), [*prepared.observers, BASELINE]

    outputs = {block.name: list(block.y) for block in loop.observers if block.name in observers}

    def told(names: Sequence[str]) -> Array:
        """(observer, time, name) of the outputs `names`; NaN where an observer has none."""
        unknown = np.full(n, np.nan)
        columns = [
            [traces[o].y[:, outputs[o].index(x)] if x in outputs[o] else unknown for x in names] for o in observers
        ]
        return np.array(columns).reshape(len(observers), len(names), n).transpose(0, 2, 1)

    def hats(names: Sequence[str]) -> Array:
        return told([hat(name) for name in names])

    def true(names: Sequence[str]) -> Array:
        return np.stack([signal[name] for name in names], axis=1)

    data: dict[str, tuple[tuple[str, ...], Array, dict[str, str]]] = {
        "x": (("time", "state"), true(STATES), about("true states")),
        "u": (("time", "muscle"), true(("u1", "u2")), about("true virtual inputs: minus the fibre velocities")),
        "a": (("time", "muscle"), true(("a1", "a2")), about("true activations")),
        "Delta": (("time",), signal["Delta"], about(SIGNALS["Delta"].sentence)),
        "y": (("time", "sensor"), traces[loop.sensors.name].y, about("measured position and tendon forces")),
        "taut": (("time", "muscle"), true(("taut1", "taut2")), about("1 while the tendon carries force")),
        "x_hat": (("observer", "time", "state"), hats(STATES), about("estimated states")),
        "u_hat": (("observer", "time", "muscle"), hats(("u1", "u2")), about("estimated virtual inputs")),
        "a_hat": (("observer", "time", "muscle"), hats(("a1", "a2")), about("estimated activations, within [0, 1]")),
        "Delta_hat": (("observer", "time"), hats(("Delta",))[:, :, 0], about("estimated uncertainty")),
    }
    if any(set(SPREADS) <= set(names) for names in outputs.values()):
        for variable, names in (("x", STATES), ("u", ("u1", "u2")), ("a", ("a1", "a2")), ("Delta", ("Delta",))):
            dims, _, attributes = data[f"{variable}_hat"]
            values = told([sd(name) for name in names])
            values = values if len(dims) == values.ndim else values[..., 0]
            data[sd(variable)] = (dims, values, about(f"standard deviation of the {attributes['long_name']}"))
    if "r" in signal:
        data["r"] = (("time",), signal["r"], about(SIGNALS["r"].sentence))
    states = {block.name: list(block.x) for block in loop.observers}
    for variable, observer, state in prepared.further_states():
        meaning = SIGNALS[state].sentence if state in SIGNALS else f"state {state}"
        attributes = about(f"{observer}: {meaning}") | {"observer": observer, "state": state}
        data[variable] = (("time",), traces[observer].x[:, states[observer].index(state)], attributes)
    scores = {name: traces[name].score for name in estimators}
    if truth.failure:  # the sums stop with the truth, they are no measures of the run
        scores = {name: dict.fromkeys(sums, np.nan) for name, sums in scores.items()}
    blocks = {block.name: block for block in loop.observers}
    errors = {name: measures(sums, grid.of(blocks[name])) for name, sums in scores.items()}
    finer = {name: measures(sums, grid.halved().of(blocks[name])) for name, sums in halved.items()}
    for measure, sentence in SENTENCES.items():
        values, at_half = (
            np.array([[of[e][measure][q] for q in QUANTITIES] for e in estimators]) for of in (errors, finer)
        )
        data[measure] = (("estimator", "quantity"), values, about(sentence))
        data[error_of(measure)] = (("estimator", "quantity"), step_error(values, at_half), about_error(measure))
    time = np.arange(n) * (grid.record * grid.h)
    coordinates = {
        "time": ("time", time, about("time τ")),
        "state": list(STATES),
        "muscle": [1, 2],
        "sensor": list(MEASURED),
        "observer": observers,
        "estimator": estimators,
        "quantity": list(QUANTITIES),
    }
    return xr.Dataset(data, coordinates, _manifest(prepared, traces, library))


def about(sentence: str) -> dict[str, str]:
    """The attributes of a variable."""
    return {"long_name": sentence, "units": "1"}


def _manifest(prepared: Prepared, traces: Mapping[str, Trace], library: str) -> dict[str, str]:
    """What a run can be repeated from, and what it has to say; everything as text, for NetCDF."""
    scenario = prepared.scenario
    guards = {name: {g: t for g, t in trace.guards.items() if t > 0} for name, trace in traces.items()}
    checked = gain_conditions(prepared, traces["truth"])
    violated = {name: [c for c in conditions if not c.holds] for name, conditions in checked.items()}
    failures = {
        name: _explain(name, trace.failure, [c.name for c in violated.get(name, [])])
        for name, trace in traces.items()
        if trace.failure
    }
    return {
        "title": f"hillobs: {prepared.label}",
        **repeatable(prepared),
        "run": prepared.label,
        "seed": str(scenario.seed),
        "unused": json.dumps(_unused(prepared)),
        "guards": json.dumps({name: times for name, times in guards.items() if times}),
        "failures": json.dumps(failures),
        "violated_conditions": json.dumps({name: [str(c) for c in some] for name, some in violated.items() if some}),
        "library": library,
    }


def repeatable(prepared: Prepared) -> dict[str, str]:
    """All numbers and choices of a run, and the versions that ran it, as text for NetCDF."""
    scenario, table = prepared.scenario, prepared.paths
    used = [path for block in prepared.loop.blocks for path in block_paths(block)]
    values = {path: prepared.value(path) for path in dict.fromkeys([*table.parameters, *used])}
    return {
        "Conventions": "CF-1.11",
        "scenario": scenario.name,
        "description": scenario.description,
        "choices": json.dumps({key: scenario.choices.get(key, valid[0]) for key, valid in CHOICES.items()}),
        "parameters": json.dumps(values),
        "changed": json.dumps(dict(scenario.given)),
        "corrected": json.dumps(prepared.corrected),
        "versions": json.dumps(versions()),
    }


def _unused(prepared: Prepared) -> list[str]:
    """What the scenario gives in vain: numbers that no Block of this loop takes, unless they are the usual ones."""
    blocks, given = prepared.loop.blocks, prepared.scenario.given
    used = {*RUN, *(path for block in blocks for path in block_paths(block))}
    used |= {parameter.shared for block in blocks for parameter in block.parameters.values()}
    usual = {path: prepared.paths.value(path, {p: v for p, v in given.items() if p != path}) for path in given}
    return [path for path, value in given.items() if path not in used and value != usual[path]]


def _explain(name: str, failure: Failure, violated: Sequence[str]) -> str:
    if name == "truth":
        return plant_failure(failure)
    likely = "the step is likely too large for the gains, try a smaller one" if failure.time else "it starts there"
    return observer_failure(name, failure, f"at τ = {failure.time:g}", violated if failure.time else (), likely)
