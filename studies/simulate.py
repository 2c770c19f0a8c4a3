"""One scenario, all observers, one Dataset."""

from __future__ import annotations

import dataclasses
import functools
import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
import xarray as xr

from ..codegen.batch import CompiledLoop, Failure, Grid, Trace
from ..codegen.export import Loop
from ..codegen.library import Array
from ..model.block import Block, Symbols, symbols
from ..model.closed_loop import NOISE_CHANNELS, closed_loop
from ..model.curves import CURVES, NGUYEN2019, CurveSet
from ..model.pair import DRIVES
from ..model.pulses import PULSES
from ..model.symbols import MEASURED, QUANTITIES, SIGNALS, STATES, hat
from ..observers import OBSERVERS, baseline_estimator, estimator
from ..observers.conditions import FACTS, Checked, check
from ..observers.score import score
from .measures import Measure, measures
from .scenario import CHOICES, Scenario, Value, read, scenario
from .table import ScenarioError, Table, block_paths, table
from .versions import versions

BASELINE = "baseline"

# a run of 10⁹ steps takes an hour; a million recorded points are 1 GB
_MOST_STEPS = 1_000_000_000
_MOST_POINTS = 1_000_000

Progress = Callable[[float], None]


def simulate(
    source: str | Path = "paper-clean",
    observers: Sequence[str | Block] | None = None,
    changes: Mapping[str, Value] | None = None,
    progress: Progress = lambda done: None,
) -> xr.Dataset:
    """Run a scenario and return states, inputs, activations, estimates and measures with named dimensions.

    source: the name of a shipped scenario, or the path of a TOML file.
    observers: names from the registry, or Blocks with an observer's ports; all registered ones by default.
    changes: path → value on top of the scenario, such as {"plant.m": 1.2, "seed": 3}.
    The Dataset has the dimensions time, state, muscle, sensor, observer, estimator (observers and the baseline)
    and quantity; everything is dimensionless. Failures are in its attributes, the numbers after one are NaN.
    ScenarioError for a wrong scenario, path, value or observer; BuildError if nothing can be compiled.
    """
    return simulate_prepared(prepare(source, observers, changes or {}), progress)


@dataclasses.dataclass(frozen=True)
class Prepared:
    """A checked scenario with the Blocks that run it."""

    scenario: Scenario
    loop: Loop
    table: Table
    grid: Grid
    observers: tuple[str, ...]

    def value(self, path: str) -> float:
        """The number at `path`."""
        return self.table.value(path, self.scenario.given)


def prepare(source: str | Path, observers: Sequence[str | Block] | None, changes: Mapping[str, Value]) -> Prepared:
    """Everything of a run that can be wrong before it starts. ScenarioError says what is."""
    name, content = read(source)
    custom = tuple(block for block in observers or () if isinstance(block, Block))
    chosen = tuple(dict.fromkeys(o.name if isinstance(o, Block) else o for o in (observers or OBSERVERS)))
    known = [*OBSERVERS, *(block.name for block in custom)]
    for observer in chosen:
        if observer not in known:
            raise ScenarioError(f"unknown observer {observer!r}; there are {', '.join(known)}")
    if clash := [block.name for block in custom if block.name in (*OBSERVERS, BASELINE, "truth", "score")]:
        raise ScenarioError(f"the name {clash[0]!r} is taken; give your observer another one")
    every = full_table(custom)
    checked = scenario(name, content, changes, every)
    curves = CURVES[checked.choices.get("muscle.curves", NGUYEN2019.name)]
    every.check(curves, checked.given)
    loop = paper_loop(checked.drive, curves, custom)
    return Prepared(checked, loop, every, time_grid(lambda path: every.value(path, checked.given)), chosen)


def simulate_prepared(prepared: Prepared, progress: Progress = lambda done: None) -> xr.Dataset:
    """Run what `prepare` has checked."""
    loop, grid = prepared.loop, prepared.grid
    parameters = {block.name: prepared.table.values(block, prepared.scenario.given) for block in loop.blocks}
    compiled = compile_loop(loop)
    traces = compiled.run(grid, prepared.scenario.seed, parameters, (BASELINE, *prepared.observers), progress)
    return _dataset(prepared, traces, str(compiled.library.path.stem))


@functools.lru_cache(maxsize=16)
def paper_loop(drive: str, curves: CurveSet, custom: tuple[Block, ...] = (), controller: Block | None = None) -> Loop:
    """The closed loop with all registered observers, the baseline and `custom` ones."""
    own = [baseline_estimator(curves), *(estimator(observer.build(curves), curves) for observer in OBSERVERS.values())]
    return Loop(
        truth=closed_loop(drive, curves, controller),
        observers=(*own, *(estimator(block, curves) for block in custom)),
        score=score(),
        measured=MEASURED,
        noise=NOISE_CHANNELS,
        pulses=PULSES,
    )


@functools.lru_cache(maxsize=16)
def compile_loop(loop: Loop) -> CompiledLoop:
    """The loop as machine code, from the cache if it is there."""
    return CompiledLoop(loop)


@functools.lru_cache(maxsize=4)
def full_table(custom: tuple[Block, ...] = (), curves: CurveSet = NGUYEN2019) -> Table:
    """The table of all paths, whatever drives the plant."""
    loops = [paper_loop(drive, curves, custom) for drive in DRIVES]
    return table([*(loop.truth for loop in loops), *loops[0].observers, loops[0].score])


def time_grid(value: Callable[[str], float]) -> Grid:
    """The grid in whole steps; ScenarioError if a time is not a multiple of the step, or the run too long."""
    h, duration = value("step"), value("duration")
    if h > duration:
        raise ScenarioError(f"step = {h:g} must not exceed duration = {duration:g}")
    if duration / h > _MOST_STEPS:
        raise ScenarioError(f"duration = {duration:g} at step = {h:g} is more than {_MOST_STEPS:,} steps")
    if duration / value("record") > _MOST_POINTS:
        raise ScenarioError(f"record = {value('record'):g} keeps more than {_MOST_POINTS:,} points; record fewer")

    def whole(path: str) -> int:
        """The time at `path` in steps."""
        steps = value(path) / h
        if abs(steps - round(steps)) > _ROUNDING * max(1.0, steps):
            raise ScenarioError(f"{path} = {value(path):.12g} must be a whole multiple of step = {h:.12g}")
        return round(steps)

    return Grid(
        h=h,
        steps=whole("duration"),
        record=whole("record"),
        hold=whole("noise.period"),
        window=math.ceil(value("score.start") / h * (1 - _ROUNDING)),
        pulses=tuple((whole(f"{name}.start"), whole(f"{name}.stop")) for name in PULSES),
    )


# what decimal fractions may be off as doubles
_ROUNDING = 1e-9


def _dataset(prepared: Prepared, traces: Mapping[str, Trace], library: str) -> xr.Dataset:
    loop, grid = prepared.loop, prepared.grid
    truth, n = traces["truth"], grid.steps // grid.record + 1
    signal = dict(zip(loop.truth.y, truth.y.T, strict=True))
    observers, estimators = list(prepared.observers), [*prepared.observers, BASELINE]

    def hats(names: Sequence[str]) -> Array:
        """(observer, time, name) of the estimates of `names`."""
        outputs = {block.name: list(block.y) for block in loop.observers}
        return np.stack([traces[o].y[:, [outputs[o].index(hat(x)) for x in names]] for o in observers])

    def columns(names: Sequence[str]) -> Array:
        return np.stack([signal[name] for name in names], axis=1)

    data: dict[str, tuple[tuple[str, ...], Array, dict[str, str]]] = {
        "x": (("time", "state"), columns(STATES), _about("true states")),
        "u": (("time", "muscle"), columns(("u1", "u2")), _about("true virtual inputs: minus the fibre velocities")),
        "a": (("time", "muscle"), columns(("a1", "a2")), _about("true activations")),
        "Delta": (("time",), signal["Delta"], _about(SIGNALS["Delta"].sentence)),
        "y": (("time", "sensor"), columns(MEASURED), _about("measured position and tendon forces")),
        "taut": (("time", "muscle"), columns(("taut1", "taut2")), _about("1 while the tendon carries force")),
        "x_hat": (("observer", "time", "state"), hats(STATES), _about("estimated states")),
        "u_hat": (("observer", "time", "muscle"), hats(("u1", "u2")), _about("estimated virtual inputs")),
        "a_hat": (("observer", "time", "muscle"), hats(("a1", "a2")), _about("estimated activations, within [0, 1]")),
        "Delta_hat": (("observer", "time"), hats(("Delta",))[:, :, 0], _about("estimated uncertainty")),
    }
    if "r" in signal:
        data["r"] = (("time",), signal["r"], _about(SIGNALS["r"].sentence))
    for block in loop.observers:
        for i, state in enumerate(block.x):
            if block.name in observers and state not in block.y:
                about = SIGNALS[state].sentence if state in SIGNALS else f"state {state}"
                attributes = _about(f"{block.name}: {about}") | {"observer": block.name, "state": state}
                data[f"{block.name}_{state}"] = (("time",), traces[block.name].x[:, i], attributes)
    points = max(0, grid.steps - grid.window + 1)
    errors = {name: measures(traces[name].score, points, grid.h, grid.steps * grid.h) for name in estimators}
    for key in (field.name for field in dataclasses.fields(Measure)):
        values = np.array([[getattr(errors[e][q], key) for q in QUANTITIES] for e in estimators])
        data[key] = (("estimator", "quantity"), values, _about(_MEASURES[key]))
    time = np.arange(n) * (grid.record * grid.h)
    coordinates = {
        "time": ("time", time, _about("time τ")),
        "state": list(STATES),
        "muscle": [1, 2],
        "sensor": list(MEASURED),
        "observer": observers,
        "estimator": estimators,
        "quantity": list(QUANTITIES),
    }
    return xr.Dataset(data, coordinates, _manifest(prepared, traces, library))


_MEASURES = {
    "rmse": "root of the mean squared error over [score.start, T]",
    "peak": "largest |error| over [0, T]",
    "settling": "last time the error exceeded its tolerance; NaN if it still does at the end",
    "chattering": "mean change of the estimate from sample to sample over [score.start, T]",
    "masked": "time within [score.start, T] in which the tendon was slack and the quantity did not count",
}


def _about(sentence: str) -> dict[str, str]:
    return {"long_name": sentence, "units": "1"}


def _manifest(prepared: Prepared, traces: Mapping[str, Trace], library: str) -> dict[str, str | int]:
    """What a run can be repeated from, and what it has to say; everything as text, for NetCDF."""
    scenario, every = prepared.scenario, prepared.table
    used = [path for block in prepared.loop.blocks for path in block_paths(block)]
    values = {path: prepared.value(path) for path in dict.fromkeys([*every.paths, *used])}
    guards = {name: {g: t for g, t in trace.guards.items() if t > 0} for name, trace in traces.items()}
    failures = {name: _explain(name, trace.failure) for name, trace in traces.items() if trace.failure}
    checked = gain_conditions(prepared, traces["truth"])
    violated = {name: [str(c) for c in conditions if not c.holds] for name, conditions in checked.items()}
    return {
        "Conventions": "CF-1.11",
        "title": f"hillobs: {scenario.name}",
        "scenario": scenario.name,
        "description": scenario.description,
        "seed": str(scenario.seed),
        "choices": json.dumps({key: scenario.choices.get(key, valid[0]) for key, valid in CHOICES.items()}),
        "parameters": json.dumps(values),
        "changed": json.dumps(dict(scenario.given)),
        "guards": json.dumps({name: times for name, times in guards.items() if times}),
        "failures": json.dumps(failures),
        "violated_conditions": json.dumps({name: words for name, words in violated.items() if words}),
        "library": library,
        "versions": json.dumps(versions()),
    }


def gain_conditions(prepared: Prepared, truth: Trace) -> dict[str, list[Checked]]:
    """The gain conditions of each registered observer, with suprema from the recorded truth."""
    signal = dict(zip(prepared.loop.truth.y, truth.y.T, strict=True))
    spacing = prepared.grid.h * prepared.grid.record

    def supremum(name: str) -> float:
        rates = np.abs(np.diff(signal[name])) / spacing
        return float(np.nanmax(rates)) if np.isfinite(rates).any() else math.nan

    driven = prepared.scenario.drive != "given"
    facts = {
        "h": prepared.grid.h,
        "U_m": prepared.value("controller.u_max") if driven else float(np.nanmax(np.abs([signal["u1"], signal["u2"]]))),
        **{f"sup_d{name}": supremum(name) for name in ("Delta", "u1", "u2")},
    }
    result = {}
    for block in prepared.loop.observers:
        if block.name in prepared.observers and block.name in OBSERVERS:
            p, about = symbols(block.p), symbols(FACTS)
            values = dict(zip(block.p, prepared.table.values(block, prepared.scenario.given), strict=True))
            conditions = OBSERVERS[block.name].conditions(p, about)
            result[block.name] = check(conditions, Symbols({**p, **about}), {**values, **facts})
    return result


def _explain(name: str, failure: Failure) -> str:
    """What failed, when, and the likely reason."""
    at = f"at τ = {failure.time:g}"
    if failure.group == "domain":
        what = "fibre" if "L_C" in failure.name else "tendon"
        return (
            f"{name}: the {what} length {failure.name} reached 0 {at}: the mass is pulled beyond what a muscle can be"
        )
    reason = (
        "the step is likely too large for the gains, try a smaller one"
        if name != "truth"
        else "the parameters or the reference ask for more than the muscles can give"
    )
    return f"{name}: {failure.name} is not a finite number {at}; {reason}"
