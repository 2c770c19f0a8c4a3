"""Signals at a counted call, limits, and how a program of the façade ends: what a process of a case does to itself.

Imported before hillobs is, so that it disturbs no start: the standard library only.
"""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import sys
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

# what Python reports too often, or only inside another call
_UNCOUNTED = {"object.__getattr__", "sys._getframe", "marshal.loads", "sys.audit"}


def strike_at_calls(signals: Sequence[tuple[str, int]], tell: Callable[[str], None], since: str = "") -> None:
    """Send this process each signal at its call, counted from the start of the file `since`, and tell of it."""
    count, waits = 0, bool(since)
    left = sorted(signals, key=lambda one: one[1])

    def hook(event: str, arguments: tuple[object, ...]) -> None:
        nonlocal count, waits
        if not left or event in _UNCOUNTED:
            return
        if waits:
            code = getattr(arguments[0], "co_filename", "") if event == "exec" else ""
            waits = not str(code).endswith(since)
            return
        count += 1
        while left and left[0][1] <= count:
            name, _ = left.pop(0)
            tell(name)
            os.kill(os.getpid(), getattr(signal, name))

    if left:
        sys.addaudithook(hook)


def teller(report: int) -> Callable[[str], None]:
    """What tells the other end of a pipe that a signal is sent."""

    def tell(name: str) -> None:
        with contextlib.suppress(OSError):
            os.write(report, f"{name}\n".encode())

    return tell


def limit(limits: Mapping[str, int]) -> None:
    """Limit this process; its memory beyond what it has now."""
    for name, number in limits.items():
        kind = getattr(resource, name)
        extra = 0
        if name == "RLIMIT_AS":
            extra = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
        resource.setrlimit(kind, (number + extra, resource.getrlimit(kind)[1]))


def run_program(text: str) -> None:
    """Run a program that uses the façade: our errors are a sentence and exit code 2, our warnings sentences."""
    import hillobs
    from hillobs.studies.files.quote import escaped
    from hostile.nonsense import NONSENSE, nonsense_in

    def show(message: Warning | str, category: type[Warning], *_: object) -> None:
        ours = category.__module__.startswith("hillobs")
        say(escaped(f"{'hillobs: ' if ours else ''}{category.__name__}: {message}"))

    def say(sentence: str) -> None:
        # nobody may hear it; where there is no error stream, `print` would take the other one
        with contextlib.suppress(OSError):
            if sys.stderr is not None:
                print(sentence, file=sys.stderr)

    warnings.showwarning = show
    names: dict[str, object] = {"hillobs": hillobs}
    try:
        exec(text, names)  # noqa: S102  a program of the test
    except hillobs.Error as error:
        say(f"hillobs: {escaped(str(error))}")
        sys.exit(2)
    for sentence in nonsense_in(names.get("result")):
        say(f"{NONSENSE}{sentence}")
