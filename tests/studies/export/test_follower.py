"""What every target calls, as CasADi evaluates it: units change nothing but units, and time is what it must be."""

from collections.abc import Sequence

import casadi as ca
import numpy as np
import pytest

from exported_programs import PERIOD
from hillobs.codegen.bank import Bank
from hillobs.codegen.targets.floats import summed_apart, without_literals
from hillobs.codegen.targets.follower import Clock, Follower, follower
from hillobs.codegen.targets.manifest import Manifest
from hillobs.model.block import Block, Symbols, symbols
from hillobs.model.system import PAIR
from hillobs.observers import ESTIMATES, OBSERVERS, estimator, estimator_of
from hillobs.observers.tendons import tendons
from hillobs.studies.estimate.start import from_first_sample
from hillobs.studies.export.prepare import exported
from hillobs.studies.laboratory.subject import subject_of
from places import RECORDINGS


def stepped(made: Manifest | Follower, substeps: int, p: Sequence[float], samples: np.ndarray) -> np.ndarray:
    """(n × estimates) of the functions, called as a target calls them."""
    f, results = made.functions, []
    s = f["start"](p, samples[0])
    for k, u in enumerate(samples):
        m = f["depart"](s)
        for i in range(substeps if k else 0):
            m = f["advance"](i, p, s, u, m)
        s, e, fine, _ = f["arrive"](min(k, 1), p, s, u, m)
        assert fine == 1
        results.append(np.array(e)[:, 0])
    return np.array(results)


@pytest.mark.parametrize("observer", OBSERVERS)
def test_units_change_nothing_but_units(observer: str) -> None:
    subject = subject_of(RECORDINGS / "dgf_smooth.toml")
    system, s = subject.system, subject.scales
    si = exported(observer, PERIOD, muscles=subject)
    assert [member.unit for member in si.input] == ["m", "N", "N"]
    block = from_first_sample(estimator_of(OBSERVERS[observer], True, system), system)
    bank = Bank(system.measured, tendons(system), None, (block,))
    plain = follower(bank, Clock(PERIOD * s.rate, si.substeps, {}), observer)
    t = np.arange(30)[:, None] * PERIOD
    y = np.hstack([subject.pair.C / 2 + 0.01 * np.sin(5 * t), 50 + 20 * np.sin(9 * t), 60 + 20 * np.cos(7 * t)])
    theirs = stepped(si, si.substeps, si.defaults, y)
    ours = stepped(plain, si.substeps, si.defaults, y / [s.length, s.force, s.force])
    units = {"x1": s.length, "x2": s.length * s.rate, "x4": s.length, "u1": s.length * s.rate, "a2": 1.0}
    for name, unit in {**units, "Delta": s.length * s.rate**2}.items():
        column = plain.estimates.index(f"{name}_hat")
        expected = ours[:, column] * unit
        # quotients by a unit round otherwise than those by a float of NumPy's
        atol = 1e-9 * np.abs(expected).max()
        np.testing.assert_allclose(theirs[:, column], expected, rtol=0, atol=atol, err_msg=name)


def timed(absolute: bool) -> Block:
    """An observer whose x̂₂ is the time since the last sample, or since the first one."""
    x, u = symbols("last"), symbols("t y1")
    zero = dict.fromkeys(ESTIMATES, u.y1 * 0)
    y = {**zero, "x1_hat": u.y1, "x2_hat": u.t if absolute else u.t - x.last}
    return Block("timed", x=x, u=u, next=Symbols(last=u.t), x0=Symbols(last=u.t), y=Symbols(y))


def test_time_is_counted_from_the_last_sample_unless_more_is_asked() -> None:
    samples = np.tile([2.6, 0.1, 0.1], (4, 1))
    for absolute, states, expected in ((False, 5, [0, 0, 0, 0]), (True, 7, [0, 1, 2, 3])):
        block = estimator(timed(absolute))
        made = follower(Bank(PAIR.measured, tendons(), None, (block,)), Clock(PERIOD, 0, {}), "timed")
        assert len(made.states) == states
        p = [parameter.default for parameter in block.parameters.values()]
        told = stepped(made, 0, p, samples)[:, made.estimates.index("x2_hat")]
        # what an observer tells at a sample follows its jump there
        np.testing.assert_allclose(told, np.array(expected) * PERIOD, rtol=1e-14)


def test_a_filter_that_asks_how_long_ago_the_last_sample_was_needs_no_clock() -> None:
    made = exported("kalman", PERIOD)
    assert not {"t", "last.t"} & {member.name for member in made.state}


def test_an_observer_that_asks_for_the_sampling_period_is_told_it_unless_it_is_given_by_hand() -> None:
    subject = subject_of(RECORDINGS / "dgf_smooth.toml")
    for expected, asked in (
        (0.01, {"period": 0.01}),
        (0.01 * subject.scales.rate, {"period": 0.01, "muscles": subject}),
        (0.02, {"period": 0.01, "changes": {"kalman_constant.T": 0.02}}),
    ):
        made = exported("kalman_constant", **asked)
        assert dict(zip((member.name for member in made.params), made.defaults, strict=True))["T"] == expected


# x + (a + b) and (x + a) + b, where floats of seven digits keep a
def test_sums_that_begin_with_a_state_add_it_last() -> None:
    x, a = ca.SX.sym("x", 2), ca.SX.sym("a", 3)
    f = ca.Function(
        "f", [x, a], [ca.vertcat(x[0] + a[0] + a[1] - a[2], a[0] * (a[2] - (x[1] + a[1])))], ["x", "a"], ["y"]
    )
    apart = summed_apart(f, "x")
    tiny = 2.0**-53
    assert float(f([1, 0], [tiny, tiny, 0])[0]) == 1
    assert float(apart([1, 0], [tiny, tiny, 0])[0]) == 1 + 2 * tiny
    random = np.random.default_rng(0)
    for _ in range(20):
        point = random.normal(size=2), random.normal(size=3)
        np.testing.assert_allclose(np.array(apart(*point)), np.array(f(*point)), rtol=1e-13, atol=1e-14)


def test_without_literals_is_the_same_function() -> None:
    x = ca.SX.sym("x", 3)
    f = ca.Function(
        "f", [x], [ca.vertcat(2 * x[0] + 1 / x[1], ca.if_else(x[2] > 0, ca.sqrt(x[2]), ca.fabs(x[0]) ** x[1]))]
    )
    plain = without_literals(f)
    kinds = {plain.instruction_id(k) for k in range(plain.n_instructions())}
    assert not kinds & {ca.OP_TWICE, ca.OP_INV}
    for point in ([0.3, 2.0, 4.0], [-1.5, 0.7, -2.0]):
        assert np.array(plain(point)).tolist() == np.array(f(point)).tolist()
