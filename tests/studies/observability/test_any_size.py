"""Numbers of any size: an answer that means something, or a sentence, and soon."""

import math

import pytest

from hillobs import Error, observability


@pytest.mark.parametrize("exponent", [-300, -100, -30, -9, -6, 6, 30, 100, 300])
@pytest.mark.parametrize("path", ["plant.m", "muscle.k", "muscle.k_P"])
def test_numbers_of_any_size_give_an_answer_or_a_sentence(path: str, exponent: int) -> None:
    try:
        given = observability("paper-clean", changes={path: 10.0**exponent})
    except Error:
        return
    assert given.verdict.rank in range(5)
    assert all(value > 0 or math.isnan(value) for value in given.deviations.values())


@pytest.mark.parametrize("exponent", [-300, 300])
@pytest.mark.parametrize("name", ["x1", "x2", "x3"])
def test_a_place_of_any_size_gives_an_answer_or_a_sentence(name: str, exponent: int) -> None:
    try:
        given = observability("paper-clean", {name: 10.0**exponent}, unknown="u")
    except Error:
        return
    assert given.verdict.rank in range(8)


def test_samples_too_many_for_a_sum_are_said_at_once() -> None:
    tiny = {"step": 1e-9, "duration": 1e-6, "record": 1e-6, "noise.period": 1e-9}
    assert all(math.isnan(value) for value in observability("paper-clean", changes=tiny).deviations.values())


def test_the_position_of_a_light_mass_is_known_whatever_the_mass() -> None:
    """Tendons in balance hold it: once its oscillation is as fast as the samples it averages out, within a third."""
    light, lighter = (observability("paper-clean", changes={"plant.m": m}).deviations["x1"] for m in (1e-5, 1e-6))
    assert light == pytest.approx(lighter, rel=1 / 3)
