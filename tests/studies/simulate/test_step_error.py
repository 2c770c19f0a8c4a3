"""How good the step is: the truth is resolved in every shipped scenario, and each run says what its step makes."""

import numpy as np
import pytest
import xarray as xr

from hillobs.codegen.batch import compile_loop
from hillobs.codegen.memory import Grid
from hillobs.model.arrays import Array
from hillobs.model.symbols import QUANTITIES
from hillobs.studies.scenarios.prepare import prepare
from hillobs.studies.simulate.measures import measures
from hillobs.studies.simulate.run import recorded, simulate
from hillobs.studies.simulate.step_error import error_of, relative, step_error
from places import OF_THE_PAIR

pytestmark = pytest.mark.numerics

MEASURED = ("rmse", "peak", "settling", "chattering", "masked")


def rmse(scenario: str, seeds: int, **changes: float) -> Array:
    """(seeds, observers, quantities), all in one batch."""
    prepared = prepare(scenario, None, changes)
    numbers = {b.name: prepared.paths.values(b, prepared.scenario.given) for b in prepared.loop.blocks}
    found = compile_loop(prepared.loop).batch(prepared.grid, range(seeds), numbers, prepared.observers)
    sums = [dict(zip(prepared.loop.score.x, found[name].sums.T, strict=True)) for name in prepared.observers]
    each = [measures(of, prepared.grid, QUANTITIES)["rmse"] for of in sums]
    return np.moveaxis([[of[quantity] for quantity in QUANTITIES] for of in each], -1, 0)


# until the last tendon is taut again: a mean over less time shows more of what happens at the edges of slackness
@pytest.mark.parametrize(
    ("scenario", "duration", "fine"),
    [
        ("slack", 8.0, 5e-5),
        ("slack-deep", 15.0, 5e-5),
        pytest.param("slack", 20.0, 1e-5, marks=pytest.mark.chaos),
        pytest.param("slack-deep", 20.0, 1e-5, marks=pytest.mark.chaos),
    ],
)
def test_the_step_resolves_a_tendon_that_goes_taut_again(scenario: str, duration: float, fine: float) -> None:
    """The RMSE of every observer, quantity and seed is within 0.5 % of that at a much smaller step."""
    usual, much_finer = (rmse(scenario, 8, duration=duration, step=h) for h in (5e-4, fine))
    np.testing.assert_allclose(usual, much_finer, rtol=5e-3)


@pytest.mark.parametrize("scenario", OF_THE_PAIR)
def test_a_difference_at_the_start_hardly_grows(scenario: str) -> None:
    """10⁻¹⁰ grows by 100 at most, so rounding, 4·10⁻¹⁶ of a length, stays below 10⁻¹³ however it falls."""
    first = prepare(scenario, None, {})
    other = prepare(scenario, None, {"initial.x3": first.value("initial.x3") + 1e-10})
    one, near = (recorded(prepared, compile_loop(prepared.loop))["truth"].x for prepared in (first, other))
    assert np.abs(one - near).max() <= 100e-10


def test_without_noise_a_run_converges_with_the_fourth_order() -> None:
    """Truth and observer together; what the observer sees is taken at each stage."""

    def last(h: float) -> Array:
        # a period of the noise is a whole number of steps, even where there is none
        changes = {"step": h, "record": 0.04, "noise.period": 0.04, "duration": 4.0, "score.start": 1.0}
        return simulate("paper-clean", ["high_gain"], changes).x_hat.isel(time=-1).values

    h = np.array([0.04, 0.02, 0.01])
    errors = [np.linalg.norm(last(step) - last(1e-3)) for step in h]
    assert 3.7 <= np.polyfit(np.log(h), np.log(errors), 1)[0] <= 4.3


@pytest.mark.parametrize("scenario", ["paper-noisy", "challenge", "activation"])
def test_the_estimate_is_once_to_twice_the_error(scenario: str) -> None:
    """2 (1 − 2⁻ᵖ) times for the order p: 1 for p = 1, 15/8 for p = 4; a tenth for what the next orders add.

    The reference is 25 times finer: its own error is at most 4 % of what is compared.
    """
    of = {"duration": 6.0, "score.start": 1.0}
    coarse, fine = (simulate(scenario, changes={**of, "step": h}).rmse for h in (2.5e-3, 1e-4))
    true = np.abs(coarse - fine)
    large = (true > 5e-3 * fine).values
    estimated = simulate(scenario, changes={**of, "step": 2.5e-3}).rmse_step_error
    assert large.any()
    ratio = (estimated / true).values[large]
    assert ratio.min() >= 0.9
    assert ratio.max() <= 15 / 8 + 0.1


def test_every_measure_has_its_error_and_only_where_it_is_defined() -> None:
    run = simulate("slack", changes={"duration": 6.0, "step": 1e-3})
    for measure in MEASURED:
        error = run[error_of(measure)]
        assert error.dims == run[measure].dims
        assert "h/2" in error.attrs["comment"]
        xr.testing.assert_equal(error.isnull(), run[measure].isnull() & (error != np.inf))
    # an observer that fails at both steps
    lost = simulate("paper-noisy", ["sliding_mode"], {"sliding_mode.tau_s": 1e-5, "duration": 3.0})
    assert lost.rmse_step_error.sel(estimator="sliding_mode").isnull().all()


def test_half_the_step_sees_the_same_noise_and_the_same_times() -> None:
    """The error is the change to the run that `step` h/2 makes."""
    of = {"duration": 6.0, "step": 1e-3, "noise.period": 0.005, "seed": 3}
    whole, half = simulate("slack", changes=of), simulate("slack", changes={**of, "step": 5e-4})
    for measure in MEASURED:
        np.testing.assert_array_equal(whole[error_of(measure)], step_error(whole[measure], half[measure]))


def test_a_grid_of_half_steps_has_the_same_times() -> None:
    grid = Grid(h=0.3, steps=10, record=5, hold=2, window=3, pulses=((1, 4), (0, 0)))
    half = grid.halved()
    assert half == Grid(h=0.15, steps=20, record=10, hold=4, window=6, pulses=((2, 8), (0, 0)))


@pytest.mark.parametrize(
    ("at_h", "at_half", "error", "fraction"),
    [
        (4.0, 3.0, 2.0, 0.5),
        (0.0, 0.0, 0.0, 0.0),
        (0.0, 1.0, 2.0, np.inf),
        (np.nan, np.nan, np.nan, np.nan),
        (4.0, np.nan, np.inf, np.inf),
        (np.nan, 4.0, np.inf, np.nan),
    ],
)
def test_errors_of_numbers_and_of_none(at_h: float, at_half: float, error: float, fraction: float) -> None:
    found = step_error(at_h, at_half)
    np.testing.assert_array_equal(found, error)
    np.testing.assert_array_equal(relative(found, at_h), fraction)
