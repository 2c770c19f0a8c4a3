"""`python -m hillobs` and the command `hillobs`."""

import contextlib
import gc
import os
import re
import sys

from .codegen.system.room import has_room
from .studies.cli.shell.stopping import stoppable
from .studies.files.dask import leave_out

# bytes of address space that a command takes before it has done anything, most of them for libraries
_LEAST = 500_000_000
# objects between two searches for garbage: most of what a command makes lives until it ends
_MADE = 10_000
# seconds since 1970, up to the year 5138
_DATE = re.compile("[0-9]{1,11}")


def main() -> None:
    """Run the command line and exit, see `studies.cli.main`; a signal ends it at any moment, see `stoppable`."""
    stoppable(_command_line)


def _command_line() -> None:
    gc.set_threshold(_MADE)
    # OpenBLAS asks for memory without end, and interrupts the process if it gets no thread; our matrices are small
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    if not has_room(_LEAST):
        _refuse(f"there is not enough memory: it takes {_LEAST / 1e6:.0f} MB of address space")
    # NumPy and matplotlib read it as they are imported, and raise whatever it makes them
    if not _DATE.fullmatch(os.environ.get("SOURCE_DATE_EPOCH", "0")):
        _refuse("SOURCE_DATE_EPOCH must be seconds since 1970, at most 11 digits")
    leave_out()
    try:
        from .studies.cli.main import main as command_line  # takes a while, in which a signal may come
    except OSError as error:  # no file may be opened any more
        _refuse(f"{error.filename} cannot be read: {error.strerror}")
    else:
        command_line()


def _refuse(sentence: str) -> None:
    # without a listener the exit code says it; where there is no error stream, `print` would take the other one
    with contextlib.suppress(OSError):
        if sys.stderr is not None:
            print(f"hillobs: {sentence}", file=sys.stderr)
    sys.exit(2)


if __name__ == "__main__":
    main()
