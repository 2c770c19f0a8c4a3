"""A change typed as PATH=VALUE, or given in Python, is a path and a number, or a sentence."""

from typing import Any, cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from documents import document
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.scenarios.scenario import parse_change
from hillobs.studies.simulate.run import simulate


@pytest.mark.parametrize(
    "text", ["plant.m", "=1", "", "plant.m=1_000", "plant.m=١", "plant.m= 1", "plant.m=0x1", "plant.m=nan"]
)
def test_a_change_that_is_none_is_refused(text: str) -> None:
    with pytest.raises(ScenarioError):
        parse_change(text)


@given(st.text(max_size=60))
def test_any_text_as_a_change_is_a_number_or_a_sentence(text: str) -> None:
    message = ""
    try:
        path, value = parse_change(text)
        document({}, {path: value})
    except ScenarioError as error:
        message = str(error)
    assert message == "" or len(message) > 10


def test_a_path_is_a_text() -> None:
    with pytest.raises(ScenarioError, match=r"a name in changes must be a text such as plant\.m, not 3"):
        simulate("paper-clean", changes=cast(Any, {3: 1.0}))
