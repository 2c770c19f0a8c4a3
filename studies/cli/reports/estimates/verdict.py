"""A verdict in words."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ....estimate.scores import Score
from ....verdict.run import Verdict

_DOUBTFUL, _PLAIN = "? ", "  "


def sentences(verdict: Verdict) -> Iterator[str]:
    """A line for the whole, then one for each finding, doubtful ones marked."""
    doubts = sum(finding.doubtful for finding in verdict.findings)
    whole = f"{doubts} of {len(verdict.findings)} findings are doubtful" if doubts else "nothing is doubted"
    yield f"verdict: {whole}"
    yield from (f"{_DOUBTFUL if f.doubtful else _PLAIN}{f.sentence}" for f in verdict.findings)


def answer(verdict: Verdict | None, scores: Sequence[Score], written: Sequence[Path]) -> str:
    """Verdict, scores and files for a program."""
    said = {
        "verdict": None if verdict is None else verdict.as_dict(),
        "scores": [_number(asdict(score)) for score in scores],
        "written": [str(path) for path in written],
    }
    return json.dumps(said, indent=2, allow_nan=False, ensure_ascii=True)


def _number(score: dict[str, Any]) -> dict[str, Any]:
    """JSON has no NaN: an observer that failed has no score."""
    return {
        key: None if isinstance(value, float) and not math.isfinite(value) else value for key, value in score.items()
    }
