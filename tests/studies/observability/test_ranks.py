"""The ranks in docs/observers.md#observability, found by hand: of the pair in each region, and of the pattern alone."""

import pytest

from hillobs.observers.observability import judge, structural_rank
from observed_systems import REGIONS, SENSORS, TAUT, UNKNOWN, block, matrix, sizes, verdict


def by_order(*ranks: int, of: int = 7) -> tuple[int, ...]:
    return (*ranks, *[ranks[-1]] * (of - len(ranks)))


TABLE = {
    ("none", "both taut"): (by_order(3, 4, of=4), ()),
    ("none", "toe and linear"): (by_order(3, 4, of=4), ()),
    ("none", "1 slack"): (by_order(2, 3, of=4), ("x3",)),
    ("none", "2 slack"): (by_order(2, 3, of=4), ("x4",)),
    ("none", "both slack"): (by_order(1, 2, of=4), ("x3", "x4")),
    ("none, a", "both taut"): (by_order(3, 4, of=4), ()),
    ("none, a", "1 slack"): (by_order(2, 3, of=4), ("x3",)),
    ("none, a", "2 slack"): (by_order(2, 3, of=4), ("x4",)),
    ("none, a", "both slack"): (by_order(1, 2, of=4), ("x3", "x4")),
    ("u", "both taut"): (by_order(3, 6, 7), ()),
    ("u", "toe and linear"): (by_order(3, 6, 7), ()),
    ("u", "1 slack"): (by_order(2, 4, 5), ("x3", "u1")),
    ("u", "2 slack"): (by_order(2, 4, 5), ("x4", "u2")),
    ("u", "both slack"): (by_order(1, 2, 3), ("x3", "x4", "u1", "u2")),
    ("a", "both taut"): (by_order(3, 6, 7), ()),
    ("a", "toe and linear"): (by_order(3, 6, 7), ()),
    ("a", "1 slack"): (by_order(2, 4, 5), ("x3", "a1")),
    ("a", "2 slack"): (by_order(2, 4, 5), ("x4", "a2")),
    ("a", "both slack"): (by_order(1, 2, 3), ("x3", "x4", "a1", "a2")),
}


@pytest.mark.parametrize(("unknown", "region"), TABLE)
def test_the_table_of_ranks(unknown: str, region: str) -> None:
    ranks, lost = TABLE[unknown, region]
    v = verdict(unknown, REGIONS[region], order=len(ranks) - 1)
    assert v.ranks == ranks
    assert (v.rank, v.unobservable, v.full) == (ranks[-1], lost, not lost)
    # each null direction is one lost coordinate and nothing else, or a mixture of the lost ones
    assert {name for direction in v.null_directions for name in direction} == set(lost)
    assert len(v.null_directions) == len(lost) == len(ranks) - v.rank


@pytest.mark.parametrize("unknown", UNKNOWN)
def test_the_pattern_alone_always_says_full(unknown: str) -> None:
    n = len(block(unknown).x)
    assert structural_rank(block(unknown), SENSORS, n - 1) == n


def test_the_pattern_knows_what_is_never_seen() -> None:
    assert [structural_rank(block("u"), SENSORS, k) for k in range(3)] == [3, 6, 7]
    # without a length the pattern has no x₁ at all
    assert structural_rank(block("u"), ("Phi_S1", "Phi_S2"), 6) == 6


def test_the_ranks_with_unknown_signals() -> None:
    """The unknowns with two derivatives each, 13 coordinates."""
    b = block("u", 2)
    assert len(b.x) == 13
    one = (2, 4, 6, 8)
    expected = {"both taut": (3, 6, 9, 12), "1 slack": one, "2 slack": one, "both slack": (1, 2, 3, 4)}
    # muscle 1 slack, orders 0, 0–1, 0–2, 0–3
    seen = ["x1 x4", "x1 x2 x4 u2", "x1 x2 x4 Delta u2", "x1 x2 x4 Delta u2"]
    for region, ranks in expected.items():
        M = matrix("u", SENSORS, 3, REGIONS[region], derivatives=2)
        v = judge(M, list(b.x), sizes(b), 3)
        assert v.ranks == ranks
        if region == "1 slack":
            for k, names in enumerate(seen, start=1):
                lost = judge(M[: 3 * k], list(b.x), sizes(b), 3).unobservable
                assert tuple(name for name in block("u").x if name not in lost) == tuple(names.split())
    # one order more determines the last coordinate, Δ″
    assert judge(matrix("u", SENSORS, 4, TAUT, derivatives=2), list(b.x), sizes(b), 3).full
