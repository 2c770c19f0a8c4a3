"""Numbers written into the code, and what follows from time alone taken out of it: the same results for less."""

import casadi as ca
import numpy as np
import pytest

from hillobs.codegen.batch import compile_loop
from hillobs.codegen.clock import clocked
from hillobs.codegen.constants import hoisted
from hillobs.codegen.loop import Loop
from hillobs.studies.scenarios.prepare import Prepared, prepare

pytestmark = pytest.mark.numerics

BRIEF = {"duration": 2.0, "score.start": 0.5}
WAVES = (ca.OP_SIN, ca.OP_COS)
ROUNDING = np.finfo(float).eps


def numbers_of(prepared: Prepared) -> dict[str, dict[str, float]]:
    blocks, given = prepared.loop.blocks, prepared.scenario.given
    return {b.name: dict(zip(b.p, prepared.paths.values(b, given), strict=True)) for b in blocks}


def operations(f: ca.Function) -> list[int]:
    return [f.instruction_id(k) for k in range(f.n_instructions())]


def written(prepared: Prepared, left: tuple[str, ...] = ()) -> Loop:
    """The loop with all numbers in it but those of the truth that are `left`."""
    fixed = numbers_of(prepared)
    fixed["truth"] = {name: value for name, value in fixed["truth"].items() if name not in left}
    return prepared.loop.with_numbers(fixed)


@pytest.mark.parametrize("numbers", [False, True], ids=["arguments", "numbers"])
def test_a_clock_changes_no_function(numbers: bool) -> None:
    """Each role with the clock's row for t is the role with t, but for the order of a few operations."""
    prepared = prepare("challenge", None, {})
    truth = (written(prepared) if numbers else prepared.loop).truth
    table = hoisted(truth.name, prepared.loop.functions(truth))
    quick = clocked(truth.name, table)
    given = [value for name, value in numbers_of(prepared)["truth"].items() if name in truth.p]
    random, c = np.random.default_rng(2), table["constants"](1e-3, given)
    for t in random.uniform(0, 20, 5):
        row = quick["clock"](t, c)
        for role in ("step", "out", "watch"):
            f = table[role]
            sizes = {name: f.size_in(name) for name in f.name_in()}
            values = {n: random.uniform(0.9, 1.1, size) for n, size in sizes.items()} | {"c": c}
            old, new = f(**{**values, "t": t}), quick[role](**{**values, "t": row})
            for name, value in old.items():
                np.testing.assert_allclose(new[name], value, rtol=64 * ROUNDING, atol=64 * ROUNDING)


def test_what_time_alone_decides_is_found() -> None:
    """Reference and uncertainty are sines of time: none is left in a step once their numbers are known."""
    prepared = prepare("paper-noisy", None, {})
    as_argument, as_number = (
        clocked("truth", hoisted("truth", prepared.loop.functions(truth)))
        for truth in (prepared.loop.truth, written(prepared).truth)
    )
    assert set(WAVES) & {*operations(as_argument["step"])}
    assert not set(WAVES) & {*operations(as_argument["clock"])}
    assert not set(WAVES) & {*operations(as_number["step"])}
    assert set(WAVES) <= {*operations(as_number["clock"])}
    # a sine whose frequency is left is one of each run
    mixed = written(prepared, ("uncertainty.frequency",)).truth
    table = clocked("truth", hoisted("truth", prepared.loop.functions(mixed)))
    assert set(WAVES) <= {*operations(table["step"])}
    assert set(WAVES) <= {*operations(table["clock"])}


def test_numbers_in_the_code_make_it_shorter_and_leave_its_results() -> None:
    """Noise-free, a truth per run, all measures.

    The last bit of a length near 3 is 4e−16; the gains make at most 1e3 of it in an estimate. Sums of squares move by
    twice that, relative to the root mean square; a thousand roundings of them at 1e−16 are below 1e−11.
    """
    prepared = prepare("paper-clean", None, BRIEF)
    loop = written(prepared, ("initial.x1",))
    assert list(loop.truth.p) == ["initial.x1"]
    assert not any(block.p for block in (*loop.observers, loop.bank.front, loop.sensors, loop.score))
    before, after = (
        sum(len(operations(f)) for b in of.exported for f in hoisted(b.name, of.functions(b)).values())
        for of in (prepared.loop, loop)
    )
    assert after < 0.85 * before
    numbers, runs = numbers_of(prepared), 20
    starts = numbers["truth"]["initial.x1"] + 1e-6 * np.arange(runs)
    every = {name: np.array([*of.values()]) for name, of in numbers.items()}
    every["truth"] = np.tile(every["truth"], (runs, 1))
    every["truth"][:, [*prepared.loop.truth.p].index("initial.x1")] = starts
    none = {block.name: np.zeros(0) for block in loop.blocks}
    batches = (
        compile_loop(of).batch(prepared.grid, np.arange(runs), given, prepared.observers)
        for of, given in ((prepared.loop, every), (loop, {**none, "truth": starts[:, None]}))
    )
    one, other = batches
    names = list(prepared.loop.score.x)
    for observer in prepared.observers:
        assert (one[observer].failed == -1).all()
        for name, old, new in zip(names, one[observer].sums.T, other[observer].sums.T, strict=True):
            if name.endswith("squares"):
                size = np.sqrt(old / one[observer].sums[:, names.index("always.count")])
                assert (np.abs(new - old) <= np.maximum(1e-11, 2 * 1e3 * 2 * ROUNDING / size) * old).all(), (
                    observer,
                    name,
                )


def test_what_observers_share_is_a_number_for_all_or_for_none() -> None:
    """The front looks its parameters up by name in whichever observer runs."""
    prepared = prepare("paper-noisy", None, {})
    fixed = numbers_of(prepared)
    first, second = prepared.loop.bank.front.p, "high_gain"
    name, other = list(first)[:2]
    fixed[second] = {key: value for key, value in fixed[second].items() if key != name}
    fixed["sliding_mode"] = {**fixed["sliding_mode"], other: 1.25 * fixed["sliding_mode"][other]}
    bank = prepared.loop.with_numbers(fixed).bank
    assert list(bank.front.p) == [name, other]
    assert all([*block.p] == [name, other] for block in bank.observers)
    assert bank.near is not None
    assert [*bank.near.p] == [key for key in prepared.loop.bank.near.p if key in (name, other)]


def test_names_of_states_and_outputs_stay() -> None:
    """So that what reads a result need not know which code made it."""
    prepared = prepare("paper-noisy", None, {})
    for old, new in zip(prepared.loop.exported, written(prepared).exported, strict=True):
        for group in ("x", "y", "u", "guards", "domain", "limits"):
            assert list(getattr(new, group)) == list(getattr(old, group)), old.name
