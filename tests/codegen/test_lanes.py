"""Runs side by side: a run's numbers depend on nothing but its own, and what is no number stays in its lane.

For this processor; `make portable` runs them for the classes of processors.
"""

import dataclasses
import itertools

import numpy as np
import pytest

from hillobs.codegen.batch import CompiledLoop, Outcome, compile_loop
from hillobs.codegen.recordings.filters import CompiledBank
from hillobs.codegen.toolchain import NATIVE
from hillobs.model.arrays import Array
from hillobs.studies.scenarios.prepare import BASELINE, Prepared, prepare
from hillobs.studies.sweep import plan as planning
from hillobs.studies.sweep.computing import on_threads
from hillobs.studies.sweep.plan import Plan, plan
from hillobs.studies.sweep.row import Rows

pytestmark = pytest.mark.numerics

OBSERVERS = (BASELINE, "high_gain", "sliding_mode", "adaptive_sliding_mode")
TENTH = {"duration": 0.1, "score.start": 0.02}

THREADS = (1, 2, 3, 8, 16)
RUNS = (1, 2, 7, 8, 15, 16, 17, 31, 33)
ORDERS = ("as is", "reversed", "shuffled")
PARTS = (1, 7, 64, "all")


def ordered(runs: int, order: str) -> np.ndarray:
    places = np.arange(runs)
    return {"as is": places, "reversed": places[::-1], "shuffled": np.random.default_rng(runs).permutation(runs)}[order]


def planned(kind: str, places: np.ndarray) -> Plan:
    """Runs with numbers of their own, or with seeds of their own and a truth that all share."""
    if kind == "seeds":
        return plan("paper-noisy", {}, (1000 + places).tolist(), OBSERVERS, TENTH)
    share = places / 64
    over = {
        "high_gain.eps_h": 0.05 + share,
        "plant.m": 1 + share,
        "sliding_mode.delta_s": 0.01 + share,
        "noise.x1": share,
    }
    return plan("paper-noisy", over, [7], OBSERVERS, TENTH, "zip")


def computed(plan: Plan, compiled: CompiledLoop, threads: int) -> Rows:
    rows = np.zeros(plan.runs, plan.row)
    for part, numbers in on_threads(threads)(plan, compiled, range(plan.parts)):
        rows[plan.members(part)] = numbers
    return rows


@pytest.mark.parametrize(
    ("kind", "every", "pays"), [("numbers", THREADS, np.inf), ("seeds", (1, 3), np.inf), ("numbers", (3,), 0)]
)
def test_threads_runs_order_and_parts_change_no_bit(
    kind: str, every: tuple[int, ...], pays: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All 540 combinations of a run of 0.1, every one to the last bit.

    Fewer threads for a truth that all share, and for a library that has numbers in its code.
    """
    monkeypatch.setattr(planning, "PART", 1)
    monkeypatch.setattr(planning, "PAYS", pays)
    most = planned(kind, np.arange(max(RUNS)))
    assert (most.loop is most.prepared.loop) == (pays > 0)
    compiled = compile_loop(most.loop)
    # each run by itself
    alone = computed(most, compiled, 1)
    assert len({row.tobytes() for row in alone}) == max(RUNS)
    assert not np.isnan(alone["rmse"]).all(axis=(1, 2)).any()
    count = 0
    for runs, order in itertools.product(RUNS, ORDERS):
        places = ordered(runs, order)
        wanted = planned(kind, places)
        for threads, part in itertools.product(every, PARTS):
            monkeypatch.setattr(planning, "PART", runs if part == "all" else part)
            found = computed(wanted, compiled, threads)
            assert found.tobytes() == alone[places].tobytes(), (threads, runs, order, part)
            count += 1
    assert count == 108 * len(every)


def numbers_of(prepared: Prepared) -> dict[str, Array]:
    return {b.name: np.array(prepared.paths.values(b, prepared.scenario.given)) for b in prepared.loop.blocks}


def test_sharing_the_truth_changes_no_bit() -> None:
    prepared = prepare("paper-noisy", None, TENTH)
    compiled, numbers = compile_loop(prepared.loop), numbers_of(prepared)
    shared = compiled.batch(prepared.grid, np.arange(40), numbers, prepared.observers)
    odd = np.tile(numbers["truth"], (40, 1))
    odd[-1] *= 1.001
    own = compiled.batch(prepared.grid, np.arange(40), {**numbers, "truth": odd}, prepared.observers)
    for observer in prepared.observers:
        np.testing.assert_array_equal(shared[observer].sums[:-1], own[observer].sums[:-1])
        assert not np.array_equal(shared[observer].sums[-1], own[observer].sums[-1])


def test_every_lane_agrees_with_the_scalar_library() -> None:
    """Different numbers in each lane: sums ≤ 1e−10; without noise the trajectories ≤ 1e−11.

    Both tendons stay taut: there the loop forgets a last bit, 4e−16 of a length, and gains make at most 1e4 of it.
    """
    prepared = prepare("paper-noisy", None, {"duration": 2.0, "score.start": 0.5})
    lanes, scalar = compile_loop(prepared.loop), CompiledLoop(prepared.loop, "scalar")
    numbers = numbers_of(prepared)
    random = np.random.default_rng(1)
    for name in prepared.observers:
        numbers[name] = numbers[name] * (1 + 0.02 * random.uniform(-1, 1, (20, len(numbers[name]))))
    one, other = (c.batch(prepared.grid, np.arange(20), numbers, prepared.observers) for c in (lanes, scalar))
    squares = [i for i, name in enumerate(prepared.loop.score.x) if name.endswith(("squares", "peak"))]
    for observer in prepared.observers:
        np.testing.assert_allclose(one[observer].sums[:, squares], other[observer].sums[:, squares], rtol=1e-10)
    clean = prepare("paper-clean", None, {"duration": 2.0, "score.start": 0.5})
    runs = [c.run(clean.grid, 0, numbers_of(clean), clean.observers) for c in (lanes, scalar)]
    for name in clean.observers:
        np.testing.assert_allclose(runs[0][name].x, runs[1][name].x, rtol=0, atol=1e-11)


@pytest.mark.parametrize(("scenario", "duration"), [("slack", 8.0), ("slack-deep", 6.0)])
def test_so_does_a_tendon_that_goes_taut_again(scenario: str, duration: float) -> None:
    """A last bit of a length, 4e−16, grows by 100 at most; that is 2e−10 of û (STEEPEST), whose errors exceed 1e−3."""
    prepared = prepare(scenario, None, {"duration": duration})
    seeds, numbers = np.arange(3), numbers_of(prepared)
    lanes, scalar = compile_loop(prepared.loop), CompiledLoop(prepared.loop, "scalar")
    one, other = (c.batch(prepared.grid, seeds, numbers, prepared.observers) for c in (lanes, scalar))
    squares = [i for i, name in enumerate(prepared.loop.score.x) if name.endswith("squares")]
    for observer in prepared.observers:
        np.testing.assert_allclose(one[observer].sums[:, squares], other[observer].sums[:, squares], rtol=4e-7)


# of a length about 2, where the quick inverse does not doubt itself: see test_quick_inverse.py
LENGTH = 2e-15
# from a length to û: at most the layer of a sliding mode, (k_max + η)/δ = 1,100; from there to â: at most 5
STEEPEST = 5e3


def test_the_quick_inverse_of_the_tendon_changes_nothing() -> None:
    """With and without it, of the same measurements, in a scenario whose tendons go slack.

    Two libraries must not simulate the same plant here: there a last bit, which is the compiler's choice, becomes 1e−9.
    """
    prepared = prepare("slack", None, {"duration": 10.0, "record": 5e-4})
    numbers = numbers_of(prepared)
    followers = tuple(block for block in prepared.loop.observers if block.name in prepared.observers)
    bank = dataclasses.replace(prepared.loop.bank, observers=followers)
    run = compile_loop(prepared.loop).run(prepared.grid, 0, numbers, prepared.observers)
    assert (
        run["truth"].y.min(axis=0)[[list(prepared.loop.truth.y).index(name) for name in ("taut1", "taut2")]] == 0
    ).all()
    y = run[prepared.loop.sensors.name].y
    t = prepared.grid.h * np.arange(len(y))
    quick, slow = (CompiledBank(each, NATIVE) for each in (bank, dataclasses.replace(bank, near=None)))
    for name in prepared.observers:
        one, other = (library.follow(name, numbers[name], 1).samples(t, y).y for library in (quick, slow))
        np.testing.assert_allclose(one, other, rtol=0, atol=STEEPEST * LENGTH)


# what is no number, or hardly one

ODD = {"NaN": np.nan, "+Inf": np.inf, "−Inf": -np.inf, "1e308": 1e308, "subnormal": 5e-324}
BRIEF = {"duration": 0.03, "score.start": 0.005}
# the start of an observer, a number of it, what its sensors add, what they look at
STATES = {"high_gain": "x2_hat", "sliding_mode": "x3_hat", "adaptive_sliding_mode": "x1_hat"}
NUMBERS = {"high_gain": "h12", "sliding_mode": "alpha2", "adaptive_sliding_mode": "beta0", BASELINE: "muscle1.toe"}
MEASUREMENTS = [
    ("noise", "x1"),
    ("noise", "force"),
    ("noise", "drift"),
    ("truth", "initial.x1"),
    ("truth", "muscle2.F_toe"),
]
CASES = [
    *(("state", observer, observer, f"initial.{state}") for observer, state in STATES.items()),
    *(("parameter", observer, observer, number) for observer, number in NUMBERS.items()),
    *(("measurement", observer, block, number) for observer in OBSERVERS for block, number in MEASUREMENTS),
]


def batch(prepared: Prepared, numbers: dict[str, Array], runs: int) -> dict[str, Outcome]:
    return compile_loop(prepared.loop).batch(prepared.grid, np.full(runs, 3), numbers, OBSERVERS)


@pytest.mark.parametrize(("kind", "observer", "block", "number"), CASES, ids=lambda value: str(value))
def test_what_is_no_number_stays_in_its_lane(kind: str, observer: str, block: str, number: str) -> None:
    """Of as many vectors as there are lanes, and one that is not full, each has it in another lane."""
    prepared = prepare("paper-noisy", None, BRIEF)
    lanes = compile_loop(prepared.loop).compiled.lanes
    runs = lanes * lanes + 3
    lost = np.append(np.arange(lanes) * (lanes + 1), runs - 1)
    others = np.setdiff1d(np.arange(runs), lost)
    base = numbers_of(prepared)
    # no truth that all share: then there would be no lane of it
    base["truth"] = np.tile(base["truth"], (runs, 1))
    base["truth"][0, list(prepared.loop.truth.p).index("uncertainty.amplitude")] *= 1.001
    base[block] = np.broadcast_to(base[block], (runs, base[block].shape[-1]))
    place = list({b.name: b for b in prepared.loop.blocks}[block].p).index(number)
    clean = batch(prepared, base, runs)
    assert (clean[observer].failed == -1).all()
    for name, value in ODD.items():
        rows = base[block].copy()
        rows[lost, place] = value
        hurt = batch(prepared, {**base, block: rows}, runs)
        for each in ("truth", *OBSERVERS):
            assert hurt[each].sums[others].tobytes() == clean[each].sums[others].tobytes(), (name, each)
            assert (hurt[each].failed[others] == -1).all()
            assert_recorded(hurt[each], hurt["truth"], lost)
        # a force of −∞ is that of a slack tendon; others take the difference of two
        if not np.isfinite(value) and (observer, number, name) != (BASELINE, "drift", "−Inf"):
            whose = "truth" if block == "truth" else observer
            assert (hurt[whose].failed[lost] >= 0).all(), name
        # the same in every lane, and as in a run by itself
        assert len(set(zip(hurt[observer].failed[lost[1:]], hurt[observer].cause[lost[1:]], strict=True))) == 1
        numbers = {key: value[-1] if value.ndim == 2 else value for key, value in {**base, block: rows}.items()}
        alone = compile_loop(prepared.loop).run(prepared.grid, 3, numbers, OBSERVERS)[observer].failure
        found = int(hurt[observer].failed[-1])
        assert (found < 0) == (alone is None)
        if alone:
            assert alone.time == found * prepared.grid.h
            watched = [
                (group, key) for group in ("x", "y", "domain") for key in getattr(_block(prepared, observer), group)
            ]
            assert (alone.group, alone.name) == watched[int(hurt[observer].cause[-1])]


def _block(prepared: Prepared, name: str) -> object:
    return next(block for block in prepared.loop.observers if block.name == name)


def assert_recorded(of: Outcome, truth: Outcome, lost: np.ndarray) -> None:
    """What failed has no sums at all, what did not fail has every one of them."""
    gone = (of.failed >= 0) | (truth.failed >= 0)
    assert np.isnan(of.sums[gone]).all()
    assert not np.isnan(of.sums[~gone]).any()
    assert set(np.flatnonzero(gone)) <= set(lost)


def test_every_number_of_every_block_may_be_none() -> None:
    """Each parameter of each Block in turn, each odd value: one lost run in a vector, the others as they were."""
    prepared = prepare("paper-noisy", None, BRIEF)
    lanes = compile_loop(prepared.loop).compiled.lanes
    base = numbers_of(prepared)
    for block in prepared.loop.blocks:
        cases = [(place, value) for place in range(len(block.p)) for value in ODD.values()]
        runs = lanes * len(cases)
        rows = np.tile(base[block.name], (runs, 1))
        lost = np.array([lanes * i + i % lanes for i in range(len(cases))])
        rows[lost, [place for place, _ in cases]] = [value for _, value in cases]
        others = np.setdiff1d(np.arange(runs), lost)
        hurt = batch(prepared, {**base, block.name: rows}, runs)
        clean = batch(prepared, {**base, block.name: base[block.name]}, lanes + 1)
        for each in ("truth", *OBSERVERS):
            assert (hurt[each].failed[others] == -1).all()
            assert len({row.tobytes() for row in [*hurt[each].sums[others], clean[each].sums[0]]}) <= 1
            assert_recorded(hurt[each], hurt["truth"], lost)
        if block.name == "noise":
            assert (hurt["high_gain"].failed >= 0).any()
