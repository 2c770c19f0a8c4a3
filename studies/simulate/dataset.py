"""What the kernel recorded as a Dataset, with everything a run can be repeated from."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from ...codegen.batch import Trace
from ...codegen.failure import Failure
from ...model.arrays import Array
from ...model.symbols import SIGNALS, hat
from ...observers.behind.spread import SPREADS, sd
from ..files.versions import versions
from ..scenarios.paths import block_paths
from ..scenarios.prepare import BASELINE, Prepared
from .conditions import gain_conditions
from .failures import observer_failure, plant_failure
from .measures import SENTENCES, measures
from .schema import FILE
from .step_error import about_error, error_of, step_error

Variable = tuple[tuple[str, ...], np.ndarray[Any, Any], dict[str, str]]


def dataset(
    prepared: Prepared, traces: Mapping[str, Trace], halved: Mapping[str, Mapping[str, float]], library: str
) -> xr.Dataset:
    """The Dataset that `simulate` describes.

    halved: the score of each estimator in the same run at half the step; library: names the code that ran.
    """
    loop, grid, system = prepared.loop, prepared.grid, prepared.system
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

    u, a, Delta = system.muscle("u"), system.muscle("a"), system.joint("Delta")

    def of_joint(dims: tuple[str, ...], values: Array, sentence: str) -> Variable:
        # a pair's one position needs no dimension for joints
        return (dims, values[..., 0], about(sentence)) if system.paper else ((*dims, "joint"), values, about(sentence))

    data: dict[str, Variable] = {
        "x": (("time", "state"), true(system.states), about("true states")),
        "u": (("time", "muscle"), true(u), about("true virtual inputs: minus the fibre velocities")),
        "a": (("time", "muscle"), true(a), about("true activations")),
        "Delta": of_joint(("time",), true(Delta), SIGNALS["Delta"].sentence),
        "y": (("time", "sensor"), traces[loop.sensors.name].y, about("measured positions and tendon forces")),
        "taut": (("time", "muscle"), true(system.muscle("taut")), about("1 while the tendon carries force")),
        "x_hat": (("observer", "time", "state"), hats(system.states), about("estimated states")),
        "u_hat": (("observer", "time", "muscle"), hats(u), about("estimated virtual inputs")),
        "a_hat": (("observer", "time", "muscle"), hats(a), about("estimated activations, within [0, 1]")),
        "Delta_hat": of_joint(("observer", "time"), hats(Delta), "estimated uncertainty"),
    }
    if any(set(SPREADS) <= set(names) for names in outputs.values()):
        for variable, names in (("x", system.states), ("u", u), ("a", a), ("Delta", Delta)):
            dims, _, attributes = data[f"{variable}_hat"]
            values = told([sd(name) for name in names])
            values = values if len(dims) == values.ndim else values[..., 0]
            data[sd(variable)] = (dims, values, about(f"standard deviation of the {attributes['long_name']}"))
    data |= _led(prepared, signal)
    states = {block.name: list(block.x) for block in loop.observers}
    for variable, observer, state in prepared.further_states():
        meaning = SIGNALS[state].sentence if state in SIGNALS else f"state {state}"
        attributes = about(f"{observer}: {meaning}") | {"observer": observer, "state": state}
        data[variable] = (("time",), traces[observer].x[:, states[observer].index(state)], attributes)
    scores = {name: traces[name].score for name in estimators}
    if truth.failure:  # the sums stop with the truth, they are no measures of the run
        scores = {name: dict.fromkeys(sums, np.nan) for name, sums in scores.items()}
    blocks = {block.name: block for block in loop.observers}
    errors = {name: measures(sums, grid.of(blocks[name]), system.quantities) for name, sums in scores.items()}
    finer = {name: measures(sums, grid.halved().of(blocks[name]), system.quantities) for name, sums in halved.items()}
    for measure, sentence in SENTENCES.items():
        values, at_half = (
            np.array([[of[e][measure][q] for q in system.quantities] for e in estimators]) for of in (errors, finer)
        )
        data[measure] = (("estimator", "quantity"), values, about(sentence))
        data[error_of(measure)] = (("estimator", "quantity"), step_error(values, at_half), about_error(measure))
    time = np.arange(n) * (grid.record * grid.h)
    subject = prepared.scenario.world.subject
    if subject:
        about_file = {"long_name": "the mechanism in SI, as JSON"}
        data["Phi_S"] = (("time", "muscle"), true(system.muscle("Phi_S")), about("true tendon forces"))
        data[FILE] = ((), np.array(prepared.scenario.mechanism), about_file)
    coordinates = {
        "time": ("time", time, about("time τ")),
        "state": list(system.states),
        "muscle": list(subject.labels if subject else (1, 2)),
        "sensor": list(system.measured),
        **({"joint": list(system.joints)} if subject else {}),
        "observer": observers,
        "estimator": estimators,
        "quantity": list(system.quantities),
    }
    return xr.Dataset(data, coordinates, _manifest(prepared, traces, library))


def _led(prepared: Prepared, signal: Mapping[str, Array]) -> dict[str, Variable]:
    """The reference, if there is one; of a mechanism also where what follows it is."""
    subject = prepared.scenario.world.subject
    if subject is None:
        return {"r": (("time",), signal["r"], about(SIGNALS["r"].sentence))} if "r" in signal else {}
    led = {name.removeprefix("r."): values for name, values in signal.items() if name.startswith("r.")}
    if not led:
        return {}
    places = subject.laws.places(np.stack([signal[name] for name in prepared.system.joint("q")], axis=-1))
    dims = ("time", "place")
    return {
        "place": (("place",), np.array(list(led)), {"long_name": "what is led along the reference"}),
        "r": (dims, np.stack(list(led.values()), axis=-1), about("reference")),
        "at": (dims, np.stack([places[name] for name in led], axis=-1), about("where it is")),
    }


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
    # of a mechanism each number once: what shares one has it
    paths = [path for path in table.parameters if prepared.system.paper or table.origin(path, scenario.given) == path]
    values = {path: prepared.value(path) for path in dict.fromkeys([*paths, *(used if prepared.system.paper else ())])}
    subject = scenario.world.subject
    s = subject.scales if subject else None
    return {
        **({"scales": json.dumps({"length": s.length, "force": s.force, "rate": s.rate})} if s else {}),
        "Conventions": "CF-1.11",
        "scenario": scenario.name,
        "description": scenario.description,
        "choices": json.dumps(dict(scenario.world.choices)),
        "parameters": json.dumps(values),
        "changed": json.dumps(dict(scenario.given)),
        "corrected": json.dumps(prepared.corrected),
        "versions": json.dumps(versions()),
    }


def _unused(prepared: Prepared) -> list[str]:
    """What the scenario gives in vain: numbers that no Block of this loop takes, unless they are the usual ones."""
    blocks, given = prepared.loop.blocks, prepared.scenario.given
    used = {*prepared.paths.run, *(path for block in blocks for path in block_paths(block))}
    used |= {parameter.shared for block in blocks for parameter in block.parameters.values()}
    usual = {path: prepared.paths.value(path, {p: v for p, v in given.items() if p != path}) for path in given}
    return [path for path, value in given.items() if path not in used and value != usual[path]]


def _explain(name: str, failure: Failure, violated: Sequence[str]) -> str:
    if name == "truth":
        return plant_failure(failure)
    likely = "the step is likely too large for the gains, try a smaller one" if failure.time else "it starts there"
    return observer_failure(name, failure, f"at τ = {failure.time:g}", violated if failure.time else (), likely)
