"""Outputs, orders, unknowns and states that cannot be asked about are refused by name."""

from collections.abc import Callable, Sequence

import pytest

from hillobs.model.block import Block, BlockError, Symbols, symbols
from hillobs.model.plant import plant as plant_of
from hillobs.model.system import PAIR
from hillobs.observers.observability import augmented, lie_derivatives, observability_matrix, structural_rank
from observed_systems import SENSORS


@pytest.mark.parametrize("act", [lie_derivatives, observability_matrix, structural_rank])
def test_bad_outputs_and_orders_are_refused(act: Callable[[Block, Sequence[str], int], object]) -> None:
    plant = plant_of()
    with pytest.raises(BlockError, match=r"plant: no output F1, F2; there are x1, x2, .*Phi_S1.*taut2"):
        act(plant, ["x1", "F1", "F2"], 3)
    with pytest.raises(BlockError, match=r"without an output nothing can be observed; there are x1, x2, "):
        act(plant, [], 3)
    with pytest.raises(BlockError, match=r"order of the Lie derivatives must be at least 0, not -1"):
        act(plant, SENSORS, -1)


@pytest.mark.parametrize("drive", ["virtual", "given"])
def test_bad_unknowns_are_refused(drive: str) -> None:
    plant = plant_of(PAIR, drive)
    valid = ", ".join(plant.u)
    with pytest.raises(BlockError, match=f"plant: no input x3, a9; there are {valid}"):
        augmented(plant, ["Delta", "x3", "a9"])
    with pytest.raises(BlockError, match="order of the unknowns' derivatives must be at least 0, not -1"):
        augmented(plant, ["Delta"], -1)
    with pytest.raises(BlockError, match="no input Delta"):
        augmented(augmented(plant, ["Delta"]), ["Delta"])


def test_a_sensor_list_that_is_one_word_is_refused() -> None:
    with pytest.raises(BlockError, match="no output x, 1"):
        lie_derivatives(plant_of(), "x1", 1)


def test_a_sampled_state_is_refused() -> None:
    x = symbols("a held")
    sampled = Block("sampled", x=x, dx=Symbols(a=x.held), next=Symbols(held=x.a), y=Symbols(a=x.a))
    with pytest.raises(BlockError, match="held"):
        observability_matrix(sampled, ["a"], 1)
