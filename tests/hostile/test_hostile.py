"""No drawn command breaks a promise, and none that once did does it again."""

import dataclasses
import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from hostile.case import read_case
from hostile.warm import Warm

CORPUS = sorted((Path(__file__).parent / "corpus").glob("*.json"))
# it compiles a library of its own
LONG = "sweep-of-an-unstable-gain"
SEED = 22
# of the 2,000 of a seed that `make hostile` tries
DRAWN = range(40)


@pytest.fixture(scope="session")
def warm() -> Iterator[Warm]:
    with Warm() as here:
        yield here


@pytest.mark.parametrize(
    "path",
    [pytest.param(path, marks=pytest.mark.chaos if path.stem == LONG else [], id=path.stem) for path in CORPUS],
)
def test_what_was_found_once_is_not_found_again(path: Path, warm: Warm) -> None:
    case, _ = read_case(path)
    warm.ask(layers=[dataclasses.asdict(case)])
    assert_kept(warm)


@pytest.mark.parametrize("number", DRAWN)
def test_a_drawn_command_breaks_no_promise(number: int, warm: Warm) -> None:
    warm.ask(seed=SEED, number=number)
    assert_kept(warm)


def assert_kept(warm: Warm) -> None:
    verdict = warm.answer()["verdict"]
    assert not verdict["wrong"], json.dumps(verdict, indent=1)
