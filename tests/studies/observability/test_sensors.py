"""What each set of sensors sees: all 63 of six sensors."""

from collections.abc import Iterable
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from scipy.linalg import orth

from hillobs.model.arrays import Array
from hillobs.observers.observability import Verdict, judge
from observed_systems import REGIONS, TAUT, block, function, kernel_of, matrix, same_space, sizes, verdict

LABORATORY = ("x1", "x2", "Phi_S1", "Phi_S2", "L_C1", "L_C2")
SUBSETS = [subset for k in range(1, 7) for subset in combinations(LABORATORY, k)]


@cache
def verdicts(unknown: str, region: str) -> dict[tuple[str, ...], Verdict]:
    b = block(unknown)
    M = matrix(unknown, LABORATORY, 6, REGIONS[region]).reshape(7, 6, 7)

    def rows(subset: Iterable[str]) -> Array:
        return M[:, [LABORATORY.index(name) for name in subset]].reshape(-1, 7)

    return {subset: judge(rows(subset), list(b.x), sizes(b), len(subset)) for subset in SUBSETS}


@pytest.mark.parametrize("region", REGIONS)
@pytest.mark.parametrize("unknown", ["u", "a"])
def test_a_further_sensor_never_hides_anything(unknown: str, region: str) -> None:
    by_subset = verdicts(unknown, region)
    assert len(by_subset) == 63
    for subset, v in by_subset.items():
        for name in LABORATORY:
            if name not in subset:
                more = tuple(n for n in LABORATORY if n in (*subset, name))
                assert by_subset[more].rank >= v.rank, (subset, name)


@pytest.mark.parametrize("subset", [("x1",), ("Phi_S1", "Phi_S2"), ("x2", "Phi_S2", "L_C1")], ids=str)
def test_rows_belong_to_their_sensor(subset: tuple[str, ...]) -> None:
    for unknown in ("u", "a"):
        alone, among = verdict(unknown, TAUT, subset), verdicts(unknown, "both taut")[subset]
        assert (alone.ranks, alone.unobservable) == (among.ranks, among.unobservable)


def test_what_each_set_of_sensors_sees_with_u_unknown() -> None:
    """By hand: L̇_C = −u is no news of the mass, forces see x₂ + u₁ and −x₂ + u₂ only, and only lengths see x₁."""
    for subset, v in verdicts("u", "both taut").items():
        lengths = {"L_C1", "L_C2"} & set(subset)
        movement = {"x2", "Phi_S1", "Phi_S2"} & set(subset)
        if "x1" in subset or (lengths and movement):
            expected: tuple[int, set[str]] = 7, set()
        elif "x2" in subset:
            expected = 6, {"x1"}
        elif movement:
            # the mass and both fibres may drift together: (x₂, u₁, u₂) ∝ (1, −1, 1)
            expected = 5, {"x1", "x2", "u1", "u2"}
        else:
            expected = 2 * len(lengths), {"x1", "x2", "x3", "x4", "Delta", "u1", "u2"} - {f"u{n[-1]}" for n in lengths}
        assert (v.rank, set(v.unobservable)) == expected, subset
    drift = np.array([[1.0, 0, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, -1, 1]]).T
    assert same_space(kernel_of(verdicts("u", "both taut")["Phi_S1", "Phi_S2"]), orth(drift), 1e-5)


def test_the_force_length_curve_carries_the_position_with_a_unknown() -> None:
    """Forces alone: f(x₁ − x₃) tells x₁ where the virtual inputs told nothing; no force, no such news."""
    by_subset = verdicts("a", "both taut")
    assert by_subset["Phi_S1", "Phi_S2"].full
    assert by_subset["x2", "Phi_S1", "Phi_S2"].full
    assert all(v.full for subset, v in by_subset.items() if "x1" in subset)
    # with f = 1 and no parallel element nothing depends on x₁ any more
    flat = [1e9 if name.endswith(".W") else 0.0 if name.endswith(".k_P") else p.default
            for name, p in block("a").parameters.items()]  # fmt: skip
    f = function("a", ("Phi_S1", "Phi_S2"), 6)
    v = judge(np.array(f([TAUT[n] for n in block("a").x], [], flat)), list(block("a").x), sizes(block("a")), 2)
    assert "x1" in v.unobservable
