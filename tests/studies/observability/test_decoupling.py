"""The decoupling matrix of the unknown inputs: its determinant in closed form, and what it refuses."""

from functools import cache

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hillobs.model.block import BlockError
from hillobs.observers.observability import decoupling_matrix
from independent import muscle
from observed_systems import SENSORS, TAUT, UNKNOWN, block, evaluate


@cache
def decoupling() -> ca.Function:
    return decoupling_matrix(block("u"), SENSORS, UNKNOWN["u"])


@given(st.lists(st.floats(1.9, 2.2), min_size=2, max_size=2), st.floats(-0.2, 0.2), st.floats(-0.5, 0.5))
def test_the_determinant_is_that_of_the_slopes(lengths: list[float], x2: float, u: float) -> None:
    """|det| = Φ′²_S1 Φ′²_S2: 0 when slack, and fading in the toe."""
    b = block("u")
    at = {**TAUT, "x2": x2, "u1": u, "x3": lengths[0], "x4": lengths[1]}
    D = evaluate(b, decoupling(), at)
    assert D.shape == (7, 7)
    slopes = np.array([float(muscle.dPhi_S(np.array([L]))[0]) for L in lengths])
    assert abs(np.linalg.det(D)) == pytest.approx(np.prod(slopes**2), rel=1e-9)
    if min(lengths) <= 2:
        assert np.linalg.det(D) == 0


def test_decoupling_refuses_an_unknown_that_is_no_coordinate() -> None:
    with pytest.raises(BlockError, match=r"u9.*there are x1, "):
        decoupling_matrix(block("u"), SENSORS, ["u9"])


def test_decoupling_refuses_an_empty_list_of_sensors() -> None:
    with pytest.raises(BlockError, match="without an output nothing can be observed"):
        decoupling_matrix(block("u"), [], ["u1"])
