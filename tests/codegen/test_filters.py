"""Observers that follow samples: against a NumPy text of the same equations, a simulation, and a loop by hand."""

import itertools
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hillobs.codegen.bank import Bank
from hillobs.codegen.recordings.filters import CompiledBank
from hillobs.model.block import Block, Symbols, symbols
from hillobs.model.system import PAIR
from hillobs.observers import OBSERVERS
from hillobs.studies.estimate.follow import compiled_bank, follower_bank
from hillobs.studies.scenarios.paths import paths_of
from hillobs.studies.simulate.run import simulate
from independent.model import Model
from independent.muscle import Phi_S_inv, activation

pytestmark = pytest.mark.numerics

# the states of an observer in the independent text, then the activations
NAMES = [f"{name}_hat" for name in ("x1", "x2", "Delta", "x3", "u1", "x4", "u2", "a1", "a2")]
PLAIN = ("high_gain", "sliding_mode", "adaptive_sliding_mode")
# RK4 of the paper's gains is stable with this step
STEP = 0.01


def uncorrected() -> CompiledBank:
    observers = tuple(replace(observer, fitted=False) for observer in OBSERVERS.values())
    return compiled_bank(follower_bank(PAIR, False, observers))


def numbers(compiled: CompiledBank, observer: str, given: Mapping[str, float] | None = None) -> np.ndarray:
    every = paths_of(compiled.bank.observers)
    block = next(block for block in compiled.bank.observers if block.name == observer)
    return np.array(every.values(block, given or {}))


def followed(
    observer: str, t: np.ndarray, y: np.ndarray, substeps: int = 1, given: Mapping[str, float] | None = None
) -> np.ndarray:
    """The nine estimates in the order of NAMES."""
    compiled = uncorrected()
    filter_ = compiled.follow(observer, numbers(compiled, observer, given), substeps)
    order = [list(filter_.block.y).index(name) for name in NAMES]
    return filter_.samples(t, y).y[:, order]


def recorded(n: int, uneven: bool = True, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Times and measurements of nothing in particular, with some noise."""
    random = np.random.default_rng(seed)
    t = np.cumsum(random.uniform(0.3, 1.7, n) if uneven else np.ones(n)) * STEP
    y = np.stack([2.62 + 0.05 * np.sin(t), 0.2 + 0.1 * np.sin(2 * t), 0.25 + 0.1 * np.cos(3 * t)], axis=1)
    return t, y + random.normal(size=(n, 3)) * 1e-4


def by_hand(t: np.ndarray, y: np.ndarray, substeps: int) -> tuple[np.ndarray, Model]:
    """The 31 states of the independent text at each sample: RK4, measurements in straight lines."""
    model = Model({})
    X = model.start()[:, None]
    sign, c = np.array([[1.0], [-1.0]]), model.curves["plant"]

    def rhs(X: np.ndarray, seen: np.ndarray) -> np.ndarray:
        d = np.zeros_like(X)
        lengths = Phi_S_inv(seen[1:, None], c)
        for i, name in enumerate(PLAIN):
            o = 4 + 7 * i
            e = lengths - X[o + 3 : o + 7 : 2]
            accel = (seen[2] - seen[1]) / model.m[name]
            model.observers[name].rates(X, d, o, seen[0] - X[o], e, accel, sign * X[o + 1])
        return d

    every = [X]
    for i in range(1, len(t)):
        h = (t[i] - t[i - 1]) / substeps
        for s in range(substeps):
            # the parts of the way from sample to sample at which RK4 looks
            first, middle, last = (y[i - 1] + (y[i] - y[i - 1]) * (s + part) / substeps for part in (0, 0.5, 1))
            k1 = rhs(X, first)
            k2 = rhs(X + h / 2 * k1, middle)
            k3 = rhs(X + h / 2 * k2, middle)
            k4 = rhs(X + h * k3, last)
            X = X + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        every.append(X)
    return np.stack(every)[:, :, 0], model


# with a coarser step the adaptive observer's laws, which jump, make much of a rounding error
@pytest.mark.parametrize(("substeps", "observers"), [(1, PLAIN[:2]), (3, PLAIN)])
def test_the_estimates_are_those_of_an_independent_text(substeps: int, observers: tuple[str, ...]) -> None:
    t, y = recorded(400)
    states, model = by_hand(t, y, substeps)
    for i, name in enumerate(observers):
        found, theirs = followed(name, t, y, substeps), states[:, 4 + 7 * i : 11 + 7 * i]
        np.testing.assert_allclose(found[:, :7], theirs, atol=1e-9, err_msg=name)
        u = np.clip(theirs[:, [4, 6]].T, -5, 0.95)
        a = activation(theirs[:, 0], theirs[:, [3, 5]].T, u, model.C[name], model.curves[name])
        np.testing.assert_allclose(found[:, 7:], np.clip(a, 0, 1).T, atol=1e-8, err_msg=name)


def test_the_first_sample_is_where_an_observer_starts() -> None:
    t, y = recorded(1)
    start = {"initial.x1_hat": 2.7, "initial.x2_hat": 0.1, "initial.x3_hat": 2.02, "initial.x4_hat": 2.03}
    lengths = Phi_S_inv(y[0, 1:, None], Model({}).curves["plant"])[:, 0]
    for name, observer in OBSERVERS.items():
        found = followed(name, t, y, given=start)[0, :7]
        if "initial.x1_hat" in observer.block().p:
            assert found.tolist() == [2.7, 0.1, 0, 2.02, 0, 2.03, 0]
        else:
            np.testing.assert_allclose(found, [y[0, 0], 0, 0, lengths[0], 0, lengths[1], 0], rtol=1e-14)


@settings(max_examples=30)
@given(st.sampled_from(list(OBSERVERS)), st.lists(st.tuples(st.integers(0, 9), st.booleans()), max_size=9))
def test_samples_one_by_one_and_a_state_change_no_bit(observer: str, parts: list[tuple[int, bool]]) -> None:
    t, y = recorded(60)
    compiled = uncorrected()
    chosen = numbers(compiled, observer)
    whole = compiled.follow(observer, chosen, 2).samples(t, y)
    rows = np.concatenate([whole.y, whole.guards], axis=1)
    filter_ = compiled.follow(observer, chosen, 2)
    at = 0
    # pieces, in between a sample by itself, and another filter that goes on
    for length, another in parts:
        filter_.samples(t[at : at + length], y[at : at + length])
        at += length
        if at < len(t):
            filter_.sample(t[at], y[at].tolist())
            np.testing.assert_array_equal(filter_.row, rows[at])
            at += 1
        if another:
            state, filter_ = filter_.state, compiled.follow(observer, chosen, 2)
            filter_.go_on_from(state)
    np.testing.assert_array_equal(filter_.samples(t[at:], y[at:]).y, whole.y[at:])


@settings(max_examples=30)
@given(st.sampled_from(list(OBSERVERS)), st.lists(st.integers(0, 60), max_size=5), st.integers(1, 4))
def test_pieces_change_no_bit(observer: str, cuts: list[int], substeps: int) -> None:
    t, y = recorded(60)
    compiled = uncorrected()
    values = numbers(compiled, observer)
    whole = compiled.follow(observer, values, substeps).samples(t, y)
    filter_ = compiled.follow(observer, values, substeps)
    edges = [0, *sorted(cuts), 60]
    pieces = [filter_.samples(t[a:b], y[a:b]) for a, b in itertools.pairwise(edges)]
    assert np.concatenate([piece.y for piece in pieces]).tobytes() == whole.y.tobytes()
    assert np.concatenate([piece.guards for piece in pieces]).tobytes() == whole.guards.tobytes()


def test_a_simulation_is_followed_as_the_simulation_did() -> None:
    """The same observers with the same numbers; what differs is the straight line between samples: order 2."""
    apart = []
    for step in (STEP, STEP / 2):
        run = simulate("challenge", changes={"duration": 2.0, "step": step, "record": step, "noise.period": 0})
        given = {"initial.x1_hat": 2.77}
        errors = []
        for name in PLAIN:
            found = followed(name, run.time.values, run.y.values, given=given)
            theirs = run.x_hat.sel(observer=name)
            errors += [np.abs(found[:, j] - theirs.sel(state=x)).max() for x, j in (("x1", 0), ("x2", 1), ("x3", 3))]
        apart.append([float(error) for error in errors])
    coarse, fine = np.array(apart)
    assert coarse.max() < 1e-3
    assert (coarse > 2.8 * fine).all(), (coarse, fine)


def test_substeps_converge_with_order_4() -> None:
    t, y = recorded(100)
    t = t * 4
    exact, *errors = (followed("high_gain", t, y, n) for n in (64, 2, 4, 8))
    e2, e4, e8 = (np.abs(found - exact).max() for found in errors)
    assert e2 / e4 > 12
    assert e4 / e8 > 12


def test_each_step_of_time_counts_as_it_is() -> None:
    """A straight line, sampled where it was straight anyway, tells nothing new; but to a filter each sample is news."""
    t, y = recorded(40)
    twice_t, twice_y = np.repeat(t, 2)[:-1].copy(), np.repeat(y, 2, axis=0)[:-1].copy()
    twice_t[1::2] += np.diff(t) / 2
    twice_y[1::2] += np.diff(y, axis=0) / 2
    for name in (name for name, observer in OBSERVERS.items() if not observer.block().sampled):
        once, twice = followed(name, t, y, 2), followed(name, twice_t, twice_y, 1)
        np.testing.assert_allclose(twice[::2], once, atol=1e-12, err_msg=name)


def test_an_observer_that_jumps_at_samples_sees_each_once() -> None:
    x, u, p = symbols("mean count"), symbols("y1 y2 y3"), Symbols()
    zero = dict.fromkeys(("x2_hat", "Delta_hat", "x3_hat", "u1_hat", "x4_hat", "u2_hat"), u.y1 * 0)
    # mean⁺ = mean + (y₁ − mean)/(count + 1)
    block = Block(
        "sampled",
        x=x,
        u=u,
        p=p,
        next=Symbols(mean=x.mean + (u.y1 - x.mean) / (x.count + 1), count=x.count + 1),
        y=Symbols(x1_hat=x.mean, **zero),
    )
    front = Block("nothing", y=Symbols(L_S1=u.y1 * 0 + 1, L_S2=u.y1 * 0 + 1), u=Symbols(y1=u.y1))
    compiled = CompiledBank(Bank(("y1", "y2", "y3"), front, None, (block,)))
    t, y = recorded(50)
    filter_ = compiled.follow("sampled", [], 3)
    found = np.concatenate([filter_.samples(t[a:b], y[a:b]).y for a, b in ((0, 7), (7, 50))])
    np.testing.assert_allclose(found[:, 0], np.cumsum(y[:, 0]) / np.arange(1, 51), rtol=1e-13)


@pytest.mark.parametrize(
    ("width", "same"),
    [
        ("high_gain.eps_L", "high_gain.eps_h"),
        ("high_gain_3.eps_L", "high_gain_3.eps_h"),
        ("sliding_mode.delta_L", "sliding_mode.delta_s"),
        ("adaptive_sliding_mode.delta_L", "adaptive_sliding_mode.delta_a"),
        ("adaptive_sliding_mode.delta_1", "adaptive_sliding_mode.delta_a"),
    ],
)
def test_without_a_width_of_its_own_a_chain_has_the_paper_s(width: str, same: str) -> None:
    t, y = recorded(100)
    observer = width.partition(".")[0]
    paper, again = (followed(observer, t, y, 2, given) for given in ({same: 0.07}, {same: 0.07, width: 0.07}))
    other = followed(observer, t, y, 2, {same: 0.07, width: 0.05})
    assert paper.tobytes() == again.tobytes()
    assert paper.tobytes() != other.tobytes()


def test_a_number_too_few_is_refused() -> None:
    compiled = uncorrected()
    with pytest.raises(ValueError, match="high_gain takes"):
        compiled.follow("high_gain", numbers(compiled, "high_gain")[:-1], 1)
