"""The table of paths: whose number each path takes."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hillobs.studies.scenarios.loops import all_paths

TABLE = all_paths()
SHARING = sorted(path for path, parameter in TABLE.parameters.items() if parameter.shared not in (None, "", path))
SOME = st.sets(st.sampled_from(sorted(TABLE.parameters)), max_size=60)


def test_a_number_of_ones_own_wins_over_the_shared_one() -> None:
    """Each way: given nowhere, where it is shared, at the path itself, at both."""
    assert SHARING
    for path in SHARING:
        shared = TABLE.parameters[path].shared
        assert TABLE.origin(path, {shared}) == TABLE.origin(path, ()) == TABLE.origin(shared, ())
        assert TABLE.origin(path, {path}) == TABLE.origin(path, {path, shared}) == path


@given(SOME)
def test_a_path_takes_its_number_from_one_that_takes_its_own(at: set[str]) -> None:
    for path in TABLE.parameters:
        origin = TABLE.origin(path, at)
        assert TABLE.origin(origin, at) == origin


@given(SOME, st.sampled_from(sorted(TABLE.parameters)))
def test_a_number_changes_the_values_that_have_their_origin_there_and_no_others(at: set[str], changed: str) -> None:
    before = {path: float(i) for i, path in enumerate(sorted({*at, changed}))}
    after = {**before, changed: -1.0}
    for path in TABLE.parameters:
        moved = TABLE.value(path, before) != TABLE.value(path, after)
        assert moved == (TABLE.origin(path, after) == changed)
