"""What every command says and how: lines, and one sentence for a mistake."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Iterator

import click

from ....codegen.cache import BuildError
from ....codegen.system.room import has_room
from ....model.errors import Error
from ...files.quote import escaped

# exit codes: numbers that are not finite, a user's mistake
NUMERICAL, USAGE = 1, 2
_LIBRARY = 100_000_000  # bytes: more than the largest library that a command loads


def say(*lines: str, err: bool = False) -> None:
    """Lines on standard output: what others have named smuggles neither control characters nor lines into them."""
    for line in lines:
        click.echo(escaped(line), err=err)


def write(text: str) -> None:
    """A text on standard output as it is: what others have named is already escaped in it."""
    click.echo(text)


@contextlib.contextmanager
def user_errors() -> Iterator[None]:
    """A user's mistake as one sentence and exit code 2."""
    try:
        yield
    except BuildError as error:  # the compiler's own words take several lines
        say(*f"hillobs: {error}".splitlines(), err=True)
        sys.exit(USAGE)
    except Error as error:
        complain(str(error))
        sys.exit(USAGE)
    except Exception as error:
        # for want of memory a library may seem not to be installed, or a number out of range
        if not isinstance(error, MemoryError) and has_room(_LIBRARY):
            raise
        words = error if isinstance(error, MemoryError) else ""  # NumPy says how much it asked for
        complain(f"there is not enough memory. {words}".rstrip(". "))
        sys.exit(USAGE)


def complain(sentence: str) -> None:
    """A sentence, on one line of the error stream."""
    with contextlib.suppress(OSError):  # without a listener the exit code says it
        say(f"hillobs: {sentence}", err=True)
