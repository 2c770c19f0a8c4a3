"""What is answered to a line of a stream: estimates as a line, and words on what was left out, learnt or has failed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from ..files.errors import RecordingError
from ..laboratory.subject import Subject
from .estimate import Estimate
from .follower import Follower
from .lines import Lines, Sample
from .table import EstimateTable

# words on lines that are no samples; a stream of nothing else would flood a terminal
_MOST_WORDS = 20


@dataclass
class Answer:
    """Lines for those who read the estimates, and words for those who look after them."""

    lines: list[str] = field(default_factory=list)
    words: list[str] = field(default_factory=list)


class Answers:
    """Answers the lines of a stream, one after the other. failed: the observers that have no estimates any more."""

    def __init__(self, followers: Sequence[Follower], lines: Lines, subject: Subject) -> None:
        self._followers, self._lines = followers, lines
        sure = [follower.observer for follower in followers if follower.sure]
        self._table = EstimateTable(subject, [follower.observer for follower in followers], sure)
        self._learning = [follower for follower in followers if follower.learning]
        self._begun = self._headed = False
        self._left_out = 0
        self.failed: set[str] = set()

    def first(self) -> Answer:
        """What there is to say before a line has come."""
        return Answer(words=[f"learning gains in the first {f.seconds:g} s" for f in self._learning[:1]])

    def answer(self, line: bytes) -> Answer:
        """The answer to a line. RecordingError if nothing in the stream can be a sample."""
        try:
            sample = self._lines.sample(line)
        except RecordingError as error:
            if not self._lines.begun:
                raise RecordingError(f"standard input: {error}") from error
            return self._without(str(error))
        return Answer() if sample is None else self._followed(sample)

    def last(self) -> Answer:
        """What there is to say after the last line. RecordingError if there was no sample."""
        if not self._lines.begun:
            raise RecordingError("standard input ended before there was a sample")
        return Answer(words=[f"{self._left_out:,} lines were left out"] if self._left_out > _MOST_WORDS else [])

    def _without(self, why: str) -> Answer:
        self._left_out += 1
        answer = Answer()
        if self._left_out <= _MOST_WORDS:
            answer.words.append(f"left out: {why}")
        if self._left_out == _MOST_WORDS:
            answer.words.append("further lines that are left out are counted only")
        return answer

    def _followed(self, sample: Sample) -> Answer:
        row = self._lines.row
        try:
            estimates = [follower.step(*sample.values, time=sample.time) for follower in self._followers]
        except RecordingError as error:
            return self._without(f"row {row}: {error}")
        answer = Answer()
        if self._begun and not estimates[0].age:
            answer.words.append(f"row {row}: no sample came for too long to bridge it: the observers begin anew")
        self._begun = True
        answer.words += self._news()
        answer.lines += self._rows(estimates)
        return answer

    def _news(self) -> Iterator[str]:
        """What is learnt, or has failed, since the last sample."""
        for follower in [follower for follower in self._learning if not follower.learning]:
            self._learning.remove(follower)
            known = ", ".join(f"{path}={value!r}" for path, value in follower.gains.items())
            yield f"learnt: {known}"
        for follower in self._followers:
            if follower.failure and follower.observer not in self.failed:
                self.failed.add(follower.observer)
                yield follower.failure

    def _rows(self, estimates: Sequence[Estimate]) -> Iterator[str]:
        if not (row := self._table.numbers(estimates[0].time, estimates)):
            return
        if self._lines.is_json:
            yield self._table.as_json(row)
            return
        if not self._headed:
            self._headed = True
            yield self._table.head()
        yield self._table.as_csv(row)
