"""Whose recording it is, as two options say it."""

from __future__ import annotations

from ...files.errors import ScenarioError
from ...laboratory.mechanisms.reading import read_mechanism
from ...laboratory.muscles import read_muscles
from ...laboratory.subject import Subject, pair_subject, subject_of


def subject_asked_for(muscles: str | None, mechanism: str | None) -> Subject:
    """The pair or the mechanism of a file. ScenarioError unless there is one of both, or for what is wrong in it."""
    if (muscles is None) == (mechanism is None):
        raise ScenarioError("a recording needs --muscles FILE.toml, a pair, or --mechanism FILE.toml, one of them")
    if mechanism is not None:
        return subject_of(read_mechanism(mechanism))
    return pair_subject(read_muscles(str(muscles)))
