"""Every parameter that a sweep can vary reaches its runs: whose numbers it changes, and to what."""

from collections.abc import Iterator, Mapping
from contextlib import nullcontext

import numpy as np
import pytest

from few_observers import few_observers
from hillobs.codegen.batch import compile_loop
from hillobs.model.arrays import Array
from hillobs.model.plant import DRIVES
from hillobs.model.symbols import QUANTITIES
from hillobs.observers import OBSERVERS as REGISTERED
from hillobs.observers.score import MEASURES
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.scenarios.loops import all_paths
from hillobs.studies.scenarios.paths import RUN, block_paths
from hillobs.studies.scenarios.prepare import BASELINE, prepare
from hillobs.studies.simulate.run import simulate
from hillobs.studies.sweep.axes import Range
from hillobs.studies.sweep.plan import Plan, plan
from hillobs.studies.sweep.points import run_points
from hillobs.studies.sweep.run import sweep

pytestmark = pytest.mark.numerics

# nothing else compiles this drive, and observers are the same with each
FEW = {"requested": ("high_gain",)}
# fibres long enough for Φ_P, forces that pretension holds, pulses, noise, and estimates that begin on both sides
ACTIVE = {
    "duration": 0.4,
    "step": 1e-3,
    "score.start": 0.05,
    "plant.C": 6.4,
    "reference.offset": 3.2,
    "controller.k_c": 5.0,
    "controller.F_c": 0.2,
    **{"reference.amplitude": 0.05, "reference.frequency": 2.0},
    **{"uncertainty.offset": 0.01, "uncertainty.amplitude": 0.03, "uncertainty.frequency": 1.3},
    **{"initial.x1": 3.19, "initial.x1_hat": 3.2, "initial.x2": 0.1, "initial.x3": 2.0225, "initial.x4": 2.0225},
    **{"initial.x3_hat": 2.03, "initial.x4_hat": 2.03},
    **{"pulse1.amplitude": 0.05, "pulse1.start": 0.02, "pulse1.stop": 0.08},
    **{"pulse2.amplitude": 0.05, "pulse2.start": 0.1, "pulse2.stop": 0.15},
    **{"noise.x1": 1e-3, "noise.force": 1e-3, "noise.drift": 1e-3},
}
# limits matter where they are reached, tolerances where an error crosses them
REACHED = {
    **{f"tolerance.{name}": 1e3 for name in QUANTITIES},
    "u_max": 1e-3,
    "Delta_min": 1e6,
    "u_low": -1e-3,
    "u_high": 1e-3,
    **{"delta00": 0.5, "delta01": 0.5, "delta02": 0.5},
    "L_min": 0.5,
    "k_max": 0.1,
    "r_max": 0.1,
    "a_min": 0.9,
    "z_max": 1.001,
    "least_slope": 1.0,
}
# û = 0 for ever: no limit of it is reached, and g(0) = 1 whatever its constants are
WITHOUT_EFFECT = {
    f"baseline.{name}"
    for name in ("u_low", "u_high", *(f"muscle{j}.{constant}" for j in ("", 1, 2) for constant in ("A_hill", "g_max")))
} | {"muscle2.z_max"}  # muscle 2 only shortens here; the next test turns the motion round


def observers() -> tuple[str, ...]:
    return (BASELINE, *REGISTERED)


@pytest.fixture
def drive(request: pytest.FixtureRequest) -> Iterator[str]:
    """A drive, and the registry that its library has."""
    with few_observers(*FEW[request.param]) if request.param in FEW else nullcontext():
        yield request.param


def another(path: str, own: float) -> float:
    """A value of the parameter that matters where `own` does not, or the other way round."""
    if reached := [value for name, value in REACHED.items() if f".{path}".endswith(f".{name}")]:
        return reached[0]
    if all_paths().parameters[path].whole:
        return own - 1
    return own * (1.01 if not all_paths().parameters[path].objection(own * 1.01) else 0.99) or 0.01


def run_together(sweeps: list[Plan]) -> np.ndarray:
    """(sweeps × points × observers × measures × quantities) of sweeps with equally many points, in one batch."""
    base = sweeps[0]
    points = [one.numbers(np.arange(one.runs)) for one in sweeps]
    parameters = {name: np.concatenate([numbers[name] for numbers in points]) for name in points[0]}
    seeds = np.zeros(len(sweeps) * base.runs, dtype=np.uint64)
    rows = run_points(base, compile_loop(base.prepared.loop), base.prepared.grid, seeds, parameters)
    assert np.isnan(rows["failed_at"]).all(), "an observer failed"
    assert np.isnan(rows["plant_failed_at"]).all(), "the plant failed"
    scores = np.stack([rows[measure] for measure in MEASURES], axis=2)
    return scores.reshape(len(sweeps), base.runs, *scores.shape[1:])


def same(one: Array, other: Array) -> bool:
    return np.array_equal(one, other, equal_nan=True)


def alone(changes: Mapping[str, float | str]) -> Array:
    """(observers × measures × quantities) of a single run."""
    found = simulate("paper-noisy", list(REGISTERED), changes).sel(estimator=list(observers()))
    return np.stack([found[measure].values for measure in MEASURES], axis=1)


def numbers_of(changes: Mapping[str, float | str]) -> dict[str, list[float]]:
    """The numbers of each Block in a single run."""
    prepared = prepare("paper-noisy", list(REGISTERED), changes)
    return {block.name: prepared.paths.values(block, prepared.scenario.given) for block in prepared.loop.blocks}


@pytest.mark.parametrize("drive", DRIVES, indirect=True)
def test_every_parameter_of_every_block_reaches_the_run(drive: str) -> None:
    """It changes the measures of the observer that it belongs to, and of no other; each run is that of `simulate`.

    A run takes time: all have the numbers of `simulate`, and one in ten is run by itself.
    """
    changes = {**ACTIVE, "plant.drive": drive}
    prepared = prepare("paper-noisy", list(REGISTERED), changes)
    paths = list(dict.fromkeys(path for block in prepared.loop.blocks for path in block_paths(block)))
    table = all_paths()
    groups = [path for path in table.groups() if path not in RUN and set(table.expand(path)) <= set(paths)]
    assert "muscle.k" in groups
    values = {path: another(table.expand(path)[0], prepared.value(table.expand(path)[0])) for path in [*paths, *groups]}
    sweeps = [
        plan("paper-noisy", {path: [prepared.value(table.expand(path)[0]), value]}, 1, observers(), changes)
        for path, value in values.items()
    ]
    found = dict(zip(values, run_together(sweeps), strict=True))
    blocks = {block.name: i for i, block in enumerate(prepared.loop.observers)}
    changed = {
        path: {name for name, i in blocks.items() if not same(own[i], other[i])} for path, (own, other) in found.items()
    }
    expected = {
        path: set() if path in WITHOUT_EFFECT else {path.partition(".")[0]} & set(blocks) or set(blocks)
        for path in values
    }
    wrong = {path for path in values if path.partition(".")[0] in blocks and changed[path] != expected[path]}
    assert not wrong
    assert not {path for path in values if path not in WITHOUT_EFFECT and not changed[path]}
    unchanged = alone(changes)
    for i, (path, one) in enumerate(zip(values, sweeps, strict=True)):
        own, other = found[path]
        assert same(own, unchanged), path
        # the other drives have the same observers
        if drive != "virtual" and path.startswith(observers()):
            continue
        changed_run = {**changes, **dict.fromkeys(table.expand(path), values[path])}
        for name, numbers in numbers_of(changed_run).items():
            assert one.numbers(np.arange(2))[name][1].tolist() == list(numbers), (path, name)
        if i % 10 == 0:
            assert same(other, alone(changed_run)), path


@pytest.mark.parametrize("drive", [drive for drive in DRIVES if drive != "virtual"], indirect=True)
def test_the_force_limit_of_muscle_2_reaches_a_run_in_which_it_lengthens(drive: str) -> None:
    changes = {**ACTIVE, "plant.drive": drive, "initial.x2": -0.3}
    assert not same(alone(changes), alone({**changes, "muscle2.z_max": REACHED["z_max"]}))


def test_no_parameter_is_forgotten() -> None:
    """All paths of the table are numbers of the run itself, or of a Block: of each drive, and closed on estimates."""
    found = set(RUN)
    for choice in (*({"plant.drive": drive} for drive in DRIVES), {"controller.feedback": "high_gain"}):
        blocks = prepare("paper-noisy", None, choice).loop.blocks
        found |= {path for block in blocks for path in block_paths(block)}
    # what all Blocks share that have it has a path of its own
    shared = {parameter.shared for parameter in all_paths().parameters.values() if parameter.shared}
    assert set(all_paths().parameters) == found | shared


SHARED = sorted({p.shared for p in all_paths().parameters.values() if p.shared})


def test_a_shared_number_reaches_all_who_share_it() -> None:
    changes = {**ACTIVE, "plant.drive": "virtual"}
    prepared = prepare("paper-noisy", list(REGISTERED), changes)
    values = {path: another(path, prepared.value(path)) for path in SHARED}
    sweeps = [
        plan("paper-noisy", {path: [prepared.value(path), values[path]]}, 1, observers(), changes) for path in SHARED
    ]
    for path, one, (own, other) in zip(SHARED, sweeps, run_together(sweeps), strict=True):
        users = [
            (block, own_path)
            for block in prepared.loop.blocks
            for own_path in block_paths(block)
            if prepared.paths.parameters[own_path].shared == path
        ]
        assert users
        for block, own_path in users:
            column = block_paths(block).index(own_path)
            assert one.numbers(np.arange(2))[block.name][:, column].tolist() == [prepared.value(path), values[path]]
        assert not same(own, other)
        assert same(other, alone({**changes, path: values[path]})), path


def test_one_muscle_wins_over_both() -> None:
    over = {"muscle1.k": [18.0], "muscle.k": [19.0, 20.0], "plant.m": [1.1]}
    wanted = plan("paper-clean", over, 1)
    for run, k in enumerate((19.0, 20.0)):
        given = prepare("paper-clean", None, {"muscle.k": k, "muscle1.k": 18.0, "plant.m": 1.1})
        for block in given.loop.blocks:
            expected = given.paths.values(block, given.scenario.given)
            np.testing.assert_array_equal(wanted.numbers(np.arange(2))[block.name][run], expected)


def test_combinations_are_checked_as_they_run() -> None:
    """What a sweep sets wins over a change of the same number, also where one names a muscle and the other both."""
    with pytest.raises(ScenarioError, match=r"at muscle\.k = 40: muscle1: k·toe"):
        plan("paper-clean", {"muscle.k": [19.0, 40.0]}, 1, None, {"muscle1.k": 19.0, "muscle2.k": 19.0})
    assert plan("paper-clean", {"muscle.k": [19.0]}, 1, None, {"muscle1.k": 20.0}).runs == 1


def test_numbers_that_do_not_limit_each_other_are_checked_apart() -> None:
    """A thousand stiffnesses at a thousand durations are two thousand checks; an error names only what it is about."""
    over = {"muscle.k": Range(15.0, 20.0, 1000), "duration": 0.1 * np.arange(1, 1001)}
    assert plan("paper-clean", over, 1, "high_gain").runs == 10**6
    with pytest.raises(ScenarioError, match=r"^at duration = 0\.1234: duration = 0\.1234 must be a whole multiple"):
        plan("paper-clean", {**over, "duration": [0.1, 0.1234]}, 1, "high_gain")
    over = {"muscle.k": [19.0, 20.0], "muscle1.g_max": [1.4, 1.2], "muscle.z_max": [1.1, 1.3]}
    with pytest.raises(ScenarioError, match=r"^at muscle1\.g_max = 1\.2, muscle\.z_max = 1\.3: muscle1\.z_max"):
        plan("paper-clean", over, 1, None, {"plant.drive": "requested"})


# two times of each, different on the grid
TIMES = {
    "duration": (0.4, 0.41),
    "step": (1e-3, 5e-4),
    "score.start": (0.05, 0.06),
    "noise.period": (0.005, 0.01),
    "pulse.start": (0.02, 0.03),
    "pulse.stop": (0.15, 0.16),
    "pulse1.start": (0.02, 0.03),
    "pulse1.stop": (0.08, 0.09),
    "pulse2.start": (0.1, 0.11),
    "pulse2.stop": (0.15, 0.16),
}


def test_what_a_run_records_cannot_be_swept() -> None:
    """A sweep keeps nothing of it; every other number of the run itself can."""
    assert {"record", *TIMES} >= set(RUN)
    with pytest.raises(ScenarioError, match="record cannot be swept"):
        sweep("paper-noisy", {"record": [0.01, 0.02]}, 1, observers(), ACTIVE)


@pytest.mark.parametrize("path", TIMES)
def test_every_number_of_the_run_itself_reaches_it(path: str) -> None:
    found = sweep("paper-noisy", {path: TIMES[path]}, 1, observers(), ACTIVE).isel(seed=0)
    points = [np.stack([found[measure].isel({path: i}).values for measure in MEASURES], axis=1) for i in range(2)]
    assert not same(*points)
    for value, point in zip(TIMES[path], points, strict=True):
        assert same(point, alone({**ACTIVE, **dict.fromkeys(all_paths().expand(path), value)}))


def test_the_seed_reaches_the_run() -> None:
    found = sweep("paper-noisy", None, [4, 2**64 - 1], observers(), ACTIVE)
    for seed in found.seed.values:
        point = np.stack([found[measure].sel(seed=seed).values for measure in MEASURES], axis=1)
        assert same(point, alone({**ACTIVE, "seed": int(seed)}))
    assert not same(found.rmse[0].values, found.rmse[1].values)
