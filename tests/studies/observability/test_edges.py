"""At the edge of a tendon the model has a kink: both sides are asked, and the lower rank counts."""

from hillobs.studies.observability.point import answer, start_point
from hillobs.studies.observability.question import pose
from hillobs.studies.scenarios.prepare import prepare
from observed_systems import TAUT, verdict


def test_at_the_edge_itself_two_orders_see_nothing() -> None:
    """Φ = Φ′ = Φ″ = 0 at 2."""
    v = verdict("u", {**TAUT, "x3": 2.0}, order=2)
    assert v.ranks == (2, 4, 6)
    assert "u1" in v.unobservable or "x3" in v.unobservable


def test_at_the_edge_both_sides_are_asked_and_the_lower_counts() -> None:
    """At x₃ = 2 the derivatives of O belong to neither side: from the slack one neither x₃ nor u₁ leaves a trace."""
    question = pose(prepare("paper-clean", None, {}), unknown="u")
    seen = answer(question, {**TAUT, "x2": -0.03, "u1": -0.02, "x3": 2.0})
    assert seen.kinks == {"x3": (5, 7)}
    assert (seen.verdict.rank, seen.verdict.unobservable) == (5, ("x3", "u1"))
    assert answer(question, {**TAUT, "x3": 2.018}).kinks == {}


def test_two_tendons_at_their_edges_are_as_bad_as_two_slack_ones() -> None:
    for unknown, lost in (("u", 4), ("a", 4)):
        seen = answer(pose(prepare("paper-clean", None, {}), unknown=unknown), {**TAUT, "x3": 2.0, "x4": 2.0})
        assert len(seen.verdict.unobservable) == lost
        assert set(seen.kinks) >= {"x3", "x4"}


def test_a_steep_slope_is_no_kink() -> None:
    prepared = prepare("challenge", None, {})
    assert answer(pose(prepared, unknown="a"), start_point(prepared)).kinks == {}
