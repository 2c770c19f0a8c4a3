"""A verdict in words."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from ....estimate.scores import Score
from ....verdict.run import Verdict
from ..number import counted

_DOUBTFUL, _PLAIN = "? ", "  "


def sentences(verdict: Verdict) -> Iterator[str]:
    """A line for the whole, then one for each finding, doubtful ones marked."""
    doubts = sum(finding.doubtful for finding in verdict.findings)
    are = "is" if doubts == 1 else "are"
    whole = (
        f"{doubts} of {counted(len(verdict.findings), 'finding')} {are} doubtful" if doubts else "nothing is doubted"
    )
    yield f"verdict: {whole}{_weighed(verdict)}"
    yield from (f"{_DOUBTFUL if f.doubtful else _PLAIN}{f.sentence}" for f in verdict.findings)


def _weighed(verdict: Verdict) -> str:
    """By which part of the recording the muscles were weighed, if that is not all of it."""
    if not verdict.weighed:
        return "; the muscles' numbers are not weighed before that is mended"
    if verdict.weighed == verdict.samples:
        return ""
    start, end = verdict.between
    return (
        f"; the muscles' numbers are weighed by the {verdict.weighed:,} samples from {start:.4g} to {end:.4g} s, all "
        f"else by all {verdict.samples:,}"
    )


def answer(verdict: Verdict | None, scores: Sequence[Score], written: Sequence[Path]) -> str:
    """Verdict, scores and files for a program."""
    said = {
        "verdict": None if verdict is None else verdict.as_dict(),
        "scores": [_row(score) for score in scores],
        "written": [str(path) for path in written],
    }
    return json.dumps(said, indent=2, allow_nan=False, ensure_ascii=True)


def _row(score: Score) -> dict[str, Any]:
    """A score by the names of its columns, but `joint` for the name of one."""
    return {"joint" if key == "muscle" and score.joint else key: _number(value) for key, value in score.row().items()}


def _number(value: str | float) -> str | float | None:
    """JSON has no NaN: an observer that failed has no score."""
    return None if isinstance(value, float) and not math.isfinite(value) else value
