"""`hillobs live`: estimates of samples as they come, line by line."""

from __future__ import annotations

import base64
import contextlib
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import click

from ...model.block import Block
from ..estimate.start import refuse_foreign
from ..files.datasets.netcdf import load
from ..files.errors import RecordingError, ResultError, ScenarioError
from ..files.quote import escaped
from ..files.reading import cause, read_whole
from ..files.writing import refuse_overwriting, write_whole
from ..laboratory.lines import LONGEST_LINE
from ..laboratory.mapping import read_mapping
from ..laboratory.subject import Subject
from ..live.answers import Answer, Answers
from ..live.follower import LEARNING, Follower
from ..live.gains import gains_of_estimates, period_of_estimates
from ..live.lines import Lines
from ..live.run import follow
from ..live.state import LARGEST_STATE
from ..scenarios.layers import Value
from ..scenarios.observers import observers_named
from .shell.options import corrected_option, mapping_option, observer_option, seconds_option, set_option
from .shell.own_observers import loaded
from .shell.progress import bar
from .shell.stopping import Stopped
from .shell.subjects import subject_asked_for, subject_options
from .shell.terminal import NUMERICAL, complain, say


@click.command()
@subject_options()
@observer_option()
@corrected_option(default=True)
@mapping_option()
@click.option("--gains", metavar="ESTIMATES.nc", help="Take the gains and the period of estimates.")
@set_option("A gain by hand: high_gain.eps_h=0.05.")
@seconds_option("--period", "From sample to sample: 5ms; 0 if times or estimates tell it.")
@seconds_option("--learning", "How long gains that are not given are learnt.", default=f"{LEARNING:g}s")
@click.option("--state", metavar="FILE", help="Go on from a state that was saved.")
@click.option("--save-state", metavar="FILE", help="Save the state at the end, also after Ctrl-C.")
def live(
    muscles: str | None,
    mechanism: str | None,
    observers: tuple[str, ...],
    corrected: bool,
    maps: tuple[str, ...],
    gains: str | None,
    changes: dict[str, Value],
    period: float,
    learning: float,
    state: str | None,
    save_state: str | None,
) -> None:
    """Estimate from samples on standard input, and write a line of estimates as soon as each is there.

    They are CSV with the header of a recording, or an object of JSON on each line; so are the estimates.
    """
    chosen, subject, mapping = loaded(observers), subject_asked_for(muscles, mechanism), read_mapping(maps)
    own = {block.name: block for block in chosen or () if isinstance(block, Block)}
    named = {name: own.get(name, name) for name in observers_named(chosen)}
    if save_state is not None:
        refuse_overwriting([Path(save_state)])
    with bar("compiling"):
        if state is None:
            followers = _begun(subject, named, corrected, gains, changes, period, learning)
        elif gains or changes or period:
            raise ScenarioError("a state knows its gains and its period; leave out --gains, --set and --period")
        else:
            states = _states(Path(state), len(named))
            followers = [
                follow(subject, observer, corrected=corrected, state=content)
                for observer, content in zip(named.values(), states, strict=True)
            ]
    lines = Lines(subject.columns, mapping, timeless=all(follower.period for follower in followers))
    answers = Answers(followers, lines, subject)
    with _kept(followers, save_state):
        _tell(answers.first())
        for line in _stdin():
            _tell(answers.answer(line))
        _tell(answers.last())
    if unlearnt := [follower.observer for follower in followers if follower.learning and save_state is None]:
        raise RecordingError(f"standard input ended while the gains of {unlearnt[0]} were learnt: nothing is estimated")
    if answers.failed:
        sys.exit(NUMERICAL)


def _begun(
    subject: Subject,
    named: Mapping[str, str | Block],
    corrected: bool,
    gains: str | None,
    changes: Mapping[str, Value],
    period: float,
    learning: float,
) -> list[Follower]:
    """Followers before their first sample. ScenarioError for gains of no observer among them."""
    refuse_foreign(changes, named)
    estimates = None if gains is None else load(gains)
    if estimates is not None:
        period = period or period_of_estimates(estimates)
    followers = []
    for name, observer in named.items():
        by_hand = {path: value for path, value in changes.items() if path.partition(".")[0] == name}
        known = {} if estimates is None else gains_of_estimates(estimates, name)
        known_and_typed = {**known, **by_hand}
        followers.append(follow(subject, observer, period or None, known_and_typed, corrected, learning))
    return followers


def _tell(answer: Answer) -> None:
    for word in answer.words:
        complain(word)
    if answer.lines:
        say(*answer.lines)


def _stdin() -> Iterator[bytes]:
    """Lines as they come, of a long one its parts. RecordingError if there is nothing to be read."""
    stream = getattr(sys.stdin, "buffer", None)
    if stream is None:
        raise RecordingError("standard input is closed")
    try:
        while line := stream.readline(LONGEST_LINE + 2):
            yield line
    except OSError as error:
        raise RecordingError(f"standard input cannot be read: {cause(error)}") from error


@contextlib.contextmanager
def _kept(followers: Sequence[Follower], path: str | None) -> Iterator[None]:
    """Save the states at the end, whatever it is."""
    try:
        yield
    except Stopped as stopped:
        if path is not None:
            stopped.add_note(escaped(f"the state is in {path}"))
        raise
    finally:
        if path is not None:
            write_whole(Path(path), b"".join(base64.b64encode(follower.state()) + b"\n" for follower in followers))


def _states(path: Path, count: int) -> list[bytes]:
    """What was saved, of as many observers. ResultError if it was not."""
    try:
        # a third more than what is encoded
        lines = read_whole(path, 2 * LARGEST_STATE).split(b"\n")[:-1]
        states = [base64.b64decode(line, validate=True) for line in lines]
    except (OSError, ValueError) as error:
        why = cause(error) if isinstance(error, OSError) else "it is no state of hillobs"
        raise ResultError(f"{path} cannot be read: {why}") from error
    if len(states) != count:
        raise ResultError(f"{path} has the states of {len(states)} observers, and {count} are asked for")
    return states
