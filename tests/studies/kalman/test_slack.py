"""Tendons that went slack: soon after they are taut again the Kalman filter knows what they do, and how surely."""

import functools

import numpy as np
import pytest

import hillobs
from hillobs.model.arrays import Array
from hillobs.model.curves import CURVES
from hillobs.studies.laboratory.muscles import Muscle, MusclePair, numbers_of
from hillobs.studies.laboratory.recording import Recording
from hillobs.studies.laboratory.scales import scales
from independent.muscle import Phi_S

# compiles what no other test needs
pytestmark = [pytest.mark.numerics, pytest.mark.chaos]

PERIOD = 0.005
# in τ: until an estimate has recovered, how long it is looked at then: at 8 the pulse ends with a jump
RECOVERED, LOOKED_AT = 0.5, 0.3
# a tendon is surely taut above five standard deviations of noise that is uniform within ±0.001
TAUT = 5 * 1e-3 / 3**0.5
# a normal error is larger once in 16,000 samples
FAR = 4.0
# in s and m: the paper's units are 10/s and 0.1 m
RATE, LENGTH, FORCE = 10.0, 0.1, 1000.0
CURVE_SET = CURVES["nguyen2019"]


def pair() -> MusclePair:
    """The paper's pair, m = 1 and C = 5.54, in SI."""
    numbers = {name: parameter.default for name, parameter in numbers_of(CURVE_SET).items()}
    muscle = Muscle(CURVE_SET, FORCE, LENGTH, 2.0 * LENGTH, RATE, numbers)
    return MusclePair(1.0 * FORCE / (LENGTH * RATE**2), 5.54 * LENGTH, muscle, muscle)


@functools.cache
def slack() -> tuple[Recording, Array]:
    """The scenario as a recording, and the true forces (n × 2), dimensionless. Without drift: no filter sees a bias."""
    s = scales(pair())
    changes: dict[str, object] = {"record": PERIOD, "noise.drift": 0, "duration": 9}
    run = hillobs.simulate("slack", observers=["high_gain"], changes=changes)
    y, x = run.y.values, {str(name): run.x.sel(state=name).values for name in run.state.values}
    true = {"velocity": s.velocity(x["x2"]), "tendon_length_1": s.metres(x["x3"]), "tendon_length_2": s.metres(x["x4"])}
    true |= {f"fibre_velocity_{j}": s.fibre_velocity(run.u.sel(muscle=j).values) for j in (1, 2)}
    measured = {"position": s.metres(y[:, 0]), "force_1": FORCE * y[:, 1], "force_2": FORCE * y[:, 2]}
    recording = Recording("slack", run.time.values / s.rate, measured, true, np.arange(1, len(y) + 1))
    return recording, np.stack([Phi_S(x["x3"]), Phi_S(x["x4"])], axis=1)


@pytest.mark.parametrize("smooth", [False, True], ids=["filter", "smoother"])
@pytest.mark.parametrize("form", ["u", "a"])
def test_half_a_time_unit_after_it_is_taut_again_it_is_known(form: str, smooth: bool) -> None:
    recording, forces = slack()
    assert (forces.min(axis=0) == 0).all()
    of = hillobs.estimate(recording, pair(), "kalman", form=form, smooth=smooth, usual_doubt=False).sel(
        observer="kalman"
    )
    assert not [name for name in of.data_vars if str(name).endswith("_hat") and np.isnan(of[name]).any()]
    for j in (1, 2):
        known = int(np.flatnonzero(forces[:, j - 1] < TAUT)[-1]) + round(RECOVERED / PERIOD)
        after, here = slice(known, known + round(LOOKED_AT / PERIOD)), of.sel(muscle=j)
        for name, of_muscle in (("velocity", of), ("tendon_length", here), ("fibre_velocity", here)):
            error, sd = (of_muscle[f"{name}_hat"] - of_muscle[f"true_{name}"]).values, of_muscle[f"{name}_sd"].values
            assert (abs(error[after]) < FAR * sd[after]).all(), (j, name)
        # and it is not because nothing is known: a band is less than a fifth of how deep the tendon was slack
        sd, depth = here.tendon_length_sd.values, 2.0 * LENGTH - recording.true[f"tendon_length_{j}"].min()
        assert sd[after].max() < depth / 5
        # a slack tendon has no band
        assert np.isnan(sd[forces[:, j - 1] == 0]).all()
