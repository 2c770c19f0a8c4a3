"""A run short enough for a test, and `hillobs` in a process of its own."""

import os
import subprocess
import sys

SHORT = ["--set", "duration=0.2", "--set", "score.start=0.1"]
# what is changed beside a scenario is in the names of its files
CHANGED = ",duration=0.2,score.start=0.1"


def in_a_process(*arguments: str, timeout: float | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(
        [sys.executable, *arguments],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
        encoding="utf-8",
        timeout=timeout,
    )
    # which test is the first to compile a library is chance
    complaints = [line for line in done.stderr.splitlines(keepends=True) if "hillobs: compiling " not in line]
    done.stderr = "".join(complaints)
    return done
