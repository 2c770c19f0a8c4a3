"""A user's own observer follows a recording as ours do; one that cannot is refused."""

import dataclasses
import json

import casadi as ca
import numpy as np
import pytest

from double_pole import double_pole
from hillobs.model.block import Symbols, symbols
from hillobs.studies.cli.reports.estimates.estimate import notes
from hillobs.studies.estimate.run import estimate
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.laboratory.recording import Recording
from shipped_recording import MUSCLES

pytestmark = pytest.mark.numerics


def test_a_users_own_observer_follows_a_recording(short: Recording) -> None:
    mine = double_pole(name="mine")
    # as fast as this both take one step from sample to sample, 0.05 in τ
    by_hand = {"mine.rate": 10, "high_gain.eps_h": 0.1, "high_gain.eps_L": 0.1}
    estimates = estimate(short, MUSCLES, ["high_gain", mine], changes=by_hand)
    assert json.loads(estimates.attrs["substeps"]) == {"high_gain": 1, "mine": 1}
    for name in ("position", "velocity", "fibre_length", "fibre_velocity", "activation"):
        ours, theirs = (estimates[f"{name}_hat"].sel(observer=observer).values for observer in ("high_gain", "mine"))
        np.testing.assert_allclose(theirs, ours, rtol=1e-9, atol=1e-10)
    assert next(line for line in notes(estimates) if line.startswith("mine")).endswith("sample; rate = 10")


def test_a_users_own_observer_has_its_defaults_and_steps_of_its_eigenvalues(short: Recording) -> None:
    mine = double_pole(name="mine")
    estimates = estimate(short, MUSCLES, mine)
    assert json.loads(estimates.attrs["gains"]) == {"mine": {}}
    assert "mine: 1 step from sample to sample" in list(notes(estimates))
    # its triple pole, 0.05 · rate/2.5
    fast = estimate(short, MUSCLES, mine, changes={"mine.rate": 200.0})
    assert json.loads(fast.attrs["substeps"]) == {"mine": 5}
    with pytest.raises(
        ScenarioError, match=r"the gains of mine are too fast for samples τ = 0.05 apart: they ask for 1e\+"
    ):
        estimate(short, MUSCLES, mine, changes={"mine.rate": 5e7})


def test_an_observer_that_estimates_activations_itself_has_no_limits(short: Recording) -> None:
    plain = double_pole(name="mine")
    a = Symbols(a1_hat=ca.SX(0.25), a2_hat=ca.SX(0.5))
    estimates = estimate(short, MUSCLES, dataclasses.replace(plain, y=Symbols({**plain.y, **a})))
    assert (estimates.activation_hat == [0.25, 0.5]).all()
    assert not estimates.activation_limited.any()


@pytest.mark.parametrize("name", ["high_gain", "plant", "initial", "muscle1", "lengths", "tendons"])
def test_a_name_that_is_taken_is_refused(name: str, short: Recording) -> None:
    with pytest.raises(ScenarioError, match=f"the name '{name}' is taken; give your observer another one"):
        estimate(short, MUSCLES, double_pole(name=name))


def test_a_users_own_observer_that_no_recording_can_move_is_refused(short: Recording) -> None:
    mine = double_pole(name="mine")
    counting = symbols("n")
    counter = dataclasses.replace(mine, x=Symbols({**mine.x, **counting}), per_step=Symbols(n=counting.n + 1))
    with pytest.raises(ScenarioError, match="mine moves at the points of a time grid, and a recording has none"):
        estimate(short, MUSCLES, counter)
    with pytest.raises(ScenarioError, match="two observers are called 'mine'; give one another name"):
        estimate(short, MUSCLES, [mine, double_pole(name="mine")])
    assert estimate(short, MUSCLES, [mine, mine]).sizes["observer"] == 1
