"""What must hold after every case, whatever it was: the list of what does not."""

from __future__ import annotations

import re
import shutil
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path

from hillobs.model.errors import Error
from hillobs.studies.files.datasets.netcdf import load
from hostile.case import Case
from hostile.nonsense import NONSENSE, lost, nonsense_in, nonsense_told
from hostile.process import Ending

DONE, NUMERICAL, USAGE, READER_GONE = 0, 1, 2, 141
# verbs whose exit code 1 says something else than numbers that failed
_RANKS = ("observability",)
# a warning of NumPy is no sentence of ours
_BARE = re.compile(r"encountered in|[Mm]ean of empty|All-NaN|[Dd]egrees of freedom|RuntimeWarning|DeprecationWarning")
_NO_NUMBER = re.compile(r"(?<![\w./=-])[+-]?(inf|nan)(?![\w./=-])")
_STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror")
# after it follow the compiler's own words
_COMPILER = "hillobs: The compiler "


def violations(case: Case, ending: Ending, written: list[Path]) -> Iterator[str]:
    """A sentence for each promise that is broken; `written` are the new files."""
    if ending.hung:
        yield "it does not end"
        return
    yield from _wrong_code(case, ending)
    if ending.orphans:
        yield f"{ending.orphans} processes are left running"
    yield from _wrong_words(case, ending)
    yield from _wrong_numbers(case, ending, written)
    if ending.code == DONE:
        yield from _wrong_C(written)


def _wrong_code(case: Case, ending: Ending) -> Iterator[str]:
    if ending.came:
        # a shell says 128 + n of a process that the n-th signal has ended
        first = 128 + getattr(signal, ending.came[0])
        code = 128 - ending.code if ending.code < 0 else ending.code
        if code != first:
            yield f"exit code {ending.code} after {' and '.join(ending.came)}, not {first}"
        return
    allowed = {DONE, NUMERICAL, USAGE} | ({READER_GONE} if "broken" in case.streams.values() else set())
    if ending.code not in allowed:
        yield f"exit code {ending.code}"
    if case.code not in (None, ending.code):
        yield f"exit code {ending.code}, where only {case.code} is right"
    heard = "stderr" not in case.streams
    if ending.code == USAGE and heard and not ending.err:
        yield "exit code 2 without a sentence"


def _wrong_words(case: Case, ending: Ending) -> Iterator[str]:
    both = ending.out + ending.err
    if "Traceback (most recent call last)" in both or "Exception ignored" in both:
        yield f"a traceback: {_last_line(both)}"
        return
    # numbers that a forger has sealed into a result are not ours
    forged = any(entry.get("seal") for entry in case.files.values())
    lines = [line for line in ending.err.splitlines() if not (forged and line.startswith(NONSENSE))]
    told = next((i for i, line in enumerate(lines) if line.startswith(_COMPILER)), len(lines))
    if strange := [line for line in lines[:told] if not line.startswith("hillobs: ")]:
        yield f"a line that is no sentence of ours: {strange[0]!r}"
    elif bare := [line for line in lines if _BARE.search(line)]:
        yield f"a bare warning: {bare[0]!r}"
    if control := [c for c in both if not c.isprintable() and c != "\n"]:
        yield f"control characters are printed: {sorted(set(control))!r}"


def _wrong_numbers(case: Case, ending: Ending, written: list[Path]) -> Iterator[str]:
    if number := _NO_NUMBER.search(ending.out):
        yield f"{number[0]!r} is printed as a number: {_line_with(ending.out, number.start())!r}"
    if case.words[:1] == ("live",):
        known = [*case.words, *(str(entry.get("text", "")) for entry in (case.input, *case.files.values()))]
        yield from nonsense_told(ending.out, "\n".join(known))
    for path in written:
        if path.suffix == ".nc":
            yield from _wrong_result(case, ending, path)
        elif path.suffix == ".csv" and (number := re.search(r"\binf\b", path.read_text(errors="replace"))):
            yield f"{path.name} has {number[0]} as a number"


def _wrong_result(case: Case, ending: Ending, path: Path) -> Iterator[str]:
    try:
        result = load(path)
    except Error as error:
        yield f"a result that cannot be read: {error}"
        return
    for sentence in nonsense_in(result):
        yield f"{path.name}: {sentence}"
    verb = case.words[0] if case.words else ""
    if ending.code == DONE and lost(result) and verb not in _RANKS:
        yield f"{path.name}: numbers end, but the exit code is 0"


def _wrong_C(written: list[Path]) -> Iterator[str]:
    """What a strict compiler says of exported sources."""
    sources = [path for path in written if path.suffix == ".c"]
    compiler = shutil.which("cc")
    if not sources or not compiler:
        return
    command = [compiler, *_STRICT, *(path.name for path in sources), "-lm", "-o", "linked"]
    done = subprocess.run(command, cwd=sources[0].parent, capture_output=True, text=True, check=False)
    if done.returncode:
        yield f"C that does not compile: {next(iter(done.stderr.splitlines()[1:]), '')}"


def _last_line(text: str) -> str:
    lines = [line for line in text.splitlines() if re.match(r"\w+(\.\w+)*(Error|Exception|Interrupt|Warning)\b", line)]
    return (lines or text.splitlines())[-1][:200]


def _line_with(text: str, place: int) -> str:
    return text[text.rfind("\n", 0, place) + 1 :].partition("\n")[0][:200]
