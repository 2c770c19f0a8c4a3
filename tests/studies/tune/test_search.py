"""The search by itself, on landscapes whose optimum is known: no observer runs here."""

import math
from pathlib import Path

import numpy as np
import pytest

from hillobs.studies.files.errors import ResultError
from hillobs.studies.sweep.axes import Range
from hillobs.studies.tune.journal import Journal
from hillobs.studies.tune.search import ROUND, Judge, Trials, front, search

RANGES = {"a": Range(0.1, 10, logarithmic=True), "b": Range(-1, 3)}
OWN = np.array([3.0, 2.0])


def distances(numbers: np.ndarray, *centres: tuple[float, float]) -> np.ndarray:
    """(trials × centres) e to the squared distance from a point of (ln a, b)."""
    at = np.column_stack([np.log(numbers[:, 0]), numbers[:, 1]])
    return np.exp([((at - centre) ** 2).sum(axis=1) for centre in np.array(centres)]).T


def judge(*centres: tuple[float, float], broken=lambda numbers: np.zeros(len(numbers))) -> Judge:
    def judged(numbers: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        breaks = broken(numbers)
        return breaks, np.where(breaks[:, None] > 0, np.inf, distances(numbers, *centres))

    return Judge(OWN, len(centres), broken, judged)


def run(judge: Judge, rounds: int, path: Path | None = None, progress=lambda *_: None) -> Trials:
    return search(RANGES, rounds * ROUND, judge, Journal(path, "mine"), progress)


def test_it_begins_at_the_own_numbers_and_ends_near_the_optimum() -> None:
    made = run(judge((-1.0, 0.5)), 8)
    np.testing.assert_array_equal(made.numbers[0], OWN)
    best = made.numbers[front(made)][0]
    # of 350 children a good part lies within a tenth of the widths, 4.6 and 4, of the parents' generation
    assert abs(math.log(best[0]) + 1) < 0.3
    assert abs(best[1] - 0.5) < 0.3
    # a later generation is better than the first one
    first, last = (np.median(made.factors[part, 0]) for part in (slice(0, ROUND), slice(-ROUND, None)))
    assert last < first / 2


def test_all_numbers_are_within_their_ranges() -> None:
    made = run(judge((5.0, 5.0)), 4)
    low, high = (np.array([getattr(span, end) for span in RANGES.values()]) for end in ("low", "high"))
    assert ((low <= made.numbers) & (made.numbers <= high)).all()


def test_what_is_broken_is_never_on_the_front_however_good() -> None:
    """The optimum is at b = 0.5, and only b ≥ 1 is allowed: the best allowed is on that edge."""

    def broken(numbers: np.ndarray) -> np.ndarray:
        return (numbers[:, 1] < 1).astype(float)

    made = run(judge((0.0, 0.5), broken=broken), 8)
    chosen = made.numbers[front(made)][0]
    assert (made.broken[ROUND:] > 0).any()
    assert 1 <= chosen[1] < 1.2
    assert not front(made)[made.broken > 0].any()


def test_the_front_of_two_objectives_lies_between_their_optima() -> None:
    made = run(judge((-1.0, 0.0), (1.0, 0.0)), 10)
    on_front = front(made)
    a, b = made.numbers[on_front].T
    assert on_front.sum() >= 5
    assert (np.abs(np.log(a)) < 1.3).all()
    assert (np.abs(b) < 0.5).all()
    # neither is better in both
    factors = made.factors[on_front][np.argsort(made.factors[on_front, 0])]
    assert (np.diff(factors[:, 1]) <= 0).all()


def test_without_anything_allowed_there_is_no_front() -> None:
    made = run(judge((0.0, 0.0), broken=lambda numbers: np.ones(len(numbers))), 2)
    assert not front(made).any()


def test_killed_and_gone_on_it_ends_as_undisturbed(tmp_path: Path) -> None:
    two = judge((-1.0, 0.0), (1.0, 0.0))
    undisturbed, path, seen = run(two, 5), tmp_path / "search.trials", []

    def killed(done: int, of: int) -> None:
        seen.append(done)
        if done == 2 * ROUND:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run(two, 5, path, killed)
    resumed = run(two, 5, path, lambda done, of: seen.append(done))
    assert seen == [ROUND * done for done in (0, 1, 2, 2, 3, 4, 5)]
    for name in ("numbers", "broken", "factors"):
        np.testing.assert_array_equal(getattr(resumed, name), getattr(undisturbed, name))
    # fewer are the first of them, more go on
    np.testing.assert_array_equal(run(two, 3, path).numbers, undisturbed.numbers[: 3 * ROUND])
    np.testing.assert_array_equal(run(two, 6, path).numbers[: 5 * ROUND], undisturbed.numbers)


def test_the_same_search_makes_the_same_file(tmp_path: Path) -> None:
    """Whoever makes it, whenever: Optuna's names of processes and its dates are not in it."""
    files = [tmp_path / "one.trials", tmp_path / "two.trials"]
    for path in files:
        run(judge((0.0, 0.0)), 2, path)
    assert files[0].read_bytes() == files[1].read_bytes()


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b'{"hillobs search": "theirs"}\n', "not as hillobs wrote it"),
        (b"", "not as hillobs wrote it"),
        (None, "of another search"),
    ],
)
def test_a_file_of_something_else_is_left_alone(tmp_path: Path, content: bytes | None, sentence: str) -> None:
    path = tmp_path / "search.trials"
    if content is None:
        run(judge((0.0, 0.0)), 1, path)
        content = path.read_bytes()
    else:
        path.write_bytes(content)
    with pytest.raises(ResultError, match=sentence):
        Journal(path, "another")
    assert path.read_bytes() == content
