"""What trials cannot tell, of covariances that are known."""

import numpy as np
import pytest

from hillobs.studies.calibrate.told import Direction, untold

KEYS, PARTS = ("F_max", "optimal_fibre_length", "v_max"), np.array([0.2, 0.1, 0.2])


def told(left: list[list[float]]) -> list[Direction]:
    return list(untold("muscle1", KEYS, PARTS, np.array(left)))


def test_without_a_trial_each_number_is_as_open_as_it_was() -> None:
    directions = told(np.eye(3).tolist())
    assert [dict(direction.parts) for direction in directions] == [
        {key: part} for key, part in zip(KEYS, PARTS, strict=True)
    ]
    assert all(direction.sd == 1 and direction.cure for direction in directions)


def test_what_is_told_is_not_named() -> None:
    assert told((0.01 * np.eye(3)).tolist()) == []


def test_numbers_that_are_told_only_as_a_product_stay_open_together() -> None:
    """ξ₁ + ξ₂ is told, ξ₁ − ξ₂ is not: half of each variance is left, and all of it in that direction."""
    (direction,) = told([[0.5, -0.5, 0], [-0.5, 0.5, 0], [0, 0, 0.01]])
    share = np.sqrt(0.5)
    largest, other = direction.parts.values()
    assert direction.sd == pytest.approx(1)
    assert sorted([abs(largest), abs(other)]) == pytest.approx([0.1 * share, 0.2 * share])
    assert largest * other < 0
