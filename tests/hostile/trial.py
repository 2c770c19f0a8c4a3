"""One case tried: its folder made, the command run, everything looked at before and after."""

from __future__ import annotations

import contextlib
import os
import re
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from hostile.case import Case
from hostile.oracle import violations
from hostile.process import Ending, run
from hostile.results import result
from hostile.sandbox import DESK, content, lay, remove, snapshot
from hostile.touched import may_write, wrongly_touched

# how long something took, and whether something had to be compiled, differs from time to time
_TIMES = re.compile(r"^.*(?: in [\d.,]+ s| a second|µs a sample|hillobs: compiling ).*\n", re.MULTILINE)


@dataclass(frozen=True)
class Verdict:
    """What is wrong with a case, and what was seen."""

    wrong: tuple[str, ...]
    code: int
    out: str
    err: str
    seconds: float


def tried(case: Case, again: bool = False) -> Verdict:
    """The verdict on a case; `again`: it is run twice and must do the same."""
    start = time.monotonic()
    with _box() as box:
        ending, wrong, files = _once(case, box)
    if again and not wrong and not ending.came:
        with _box() as box:
            other, _, other_files = _once(case, box)
        wrong += list(_differences(ending, other, files, other_files))
    # the folders of this machine are no news
    wrong = [sentence.replace(str(box), "BOX") for sentence in wrong]
    return Verdict(tuple(wrong), ending.code, ending.out, ending.err, time.monotonic() - start)


@contextlib.contextmanager
def _box() -> Iterator[Path]:
    # a name that is as long each time: it is part of what is printed
    box = Path(tempfile.mkdtemp(prefix="hostile-"))
    try:
        yield box
    finally:
        remove(box)


def _once(case: Case, box: Path) -> tuple[Ending, list[str], dict[str, bytes]]:
    """How the case ended, what is wrong, and the new files."""
    lay(box, case.files, result)
    before, allowed = snapshot(box), may_write(case, box)
    ending = run(case, box, content(case.input, result) if case.input else b"")
    after = snapshot(box)
    made = {os.path.normpath(os.path.join(DESK, name)) for name, entry in case.files.items() if "result" in entry}
    inside = {name for name in before if any(name == place for place in allowed)}
    wrong = list(wrongly_touched(before, after, allowed, made & inside))
    written = [box / name for name, now in after.items() if now[0] == "file" and before.get(name) != now]
    wrong += violations(case, ending, written)
    return ending, wrong, {os.path.relpath(path, box): path.read_bytes() for path in written}


def _differences(one: Ending, other: Ending, files: dict[str, bytes], others: dict[str, bytes]) -> Iterator[str]:
    if one.code != other.code:
        yield f"exit code {one.code}, the second time {other.code}"
    for name in ("out", "err"):
        first, second = (_TIMES.sub("", getattr(ending, name)) for ending in (one, other))
        if _nameless(first) != _nameless(second):
            yield f"std{name} is another one the second time"
    # the lock of an unfinished sweep names its process
    names = (name for name in files.keys() | others.keys() if not name.endswith(".parts/lock"))
    if different := sorted(name for name in names if files.get(name) != others.get(name)):
        yield f"other files the second time: {', '.join(different)}"


def _nameless(text: str) -> str:
    """A text without the names of temporary folders, and without addresses of objects."""
    return re.sub(r"hostile-\w{8}|hillobs-\w{8}|0x[0-9a-f]+", "", text)
