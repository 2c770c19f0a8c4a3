"""`--muscles` and `--mechanism`: whose recording, or whose samples, a command is given."""

from __future__ import annotations

import click

from ...files.errors import ScenarioError
from ...laboratory.mechanisms.reading import read_mechanism
from ...laboratory.muscles import read_muscles
from ...laboratory.subject import Subject, pair_subject, subject_of
from .scenario_arguments import Decorator

_MUSCLES = click.option("--muscles", metavar="FILE.toml", help="A pair of muscles in SI, see docs/recordings.md.")
_MECHANISM = click.option("--mechanism", metavar="FILE.toml", help="Or joints and muscles, see docs/mechanisms.md.")


def subject_options() -> Decorator:
    """Both options, for `subject_asked_for`."""
    return lambda command: _MUSCLES(_MECHANISM(command))


def subject_asked_for(muscles: str | None, mechanism: str | None) -> Subject:
    """The pair or the mechanism of a file. ScenarioError unless there is one of both, or for what is wrong in it."""
    if (muscles is None) == (mechanism is None):
        raise ScenarioError("a recording needs either --muscles FILE.toml, a pair, or --mechanism FILE.toml")
    if mechanism is not None:
        return subject_of(read_mechanism(mechanism))
    return pair_subject(read_muscles(str(muscles)))
