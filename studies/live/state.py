"""Where a follower stands, as bytes: what is read is checked, whoever has written it."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from typing import Any

from ..files.datasets.netcdf import sealed, unsealed
from ..files.datasets.schema import read_json
from ..files.errors import ResultError
from .setup import Setup

_VERSION = 1
_KIND = "a follower of hillobs"
# bytes; ten minutes at 1 kHz from which gains are learnt are 100 MB
LARGEST_STATE = 200_000_000
# samples
_MOST = 2**53
# what is in a state: name → type
_FORM: Mapping[str, Any] = {
    "kind": str,
    "version": int,
    "observer": str,
    "corrected": bool,
    "muscles": str,
    "states": list[str],
    "gains": dict[str, float],
    "period": float,
    "T": float,
    "learning": bool,
    "seconds": float,
    # the last time that was given, and samples since then
    "base": float,
    "count": int,
    # each of these is empty or has one number: before the first sample none is known
    "last": list[float],
    "start": list[float],
    "followed": list[float],
    "learnt_from": list[list[float]],
    "failure": str,
    # empty before the first sample and after a failure
    "first": list[float],
    "x": list[float],
    "y": list[float],
    "taut": list[bool],
}


def packed(content: Mapping[str, Any], setup: Setup) -> bytes:
    """What a follower stands on, by the names of the form, as bytes of one line."""
    known = {"kind": _KIND, "version": _VERSION, **_identity(setup), **content}
    return sealed(json.dumps({name: known[name] for name in _FORM}, allow_nan=False).encode())


def unpacked(state: object, setup: Setup) -> dict[str, Any]:
    """What was packed for the same set-up, of the right types and sizes. ResultError if it was not."""
    if not isinstance(state, bytes) or len(state) > LARGEST_STATE or (text := unsealed(state)) is None:
        raise ResultError("it is none of hillobs, or it is damaged")
    try:
        plain = text.decode("ascii")
    except UnicodeDecodeError as error:
        raise ResultError("it is none of hillobs") from error
    head = read_json("content", plain, dict)
    if head.get("kind") != _KIND or head.get("version") != _VERSION:
        raise ResultError("it is none of this version of hillobs")
    told: dict[str, Any] = read_json("content", plain, dict(_FORM))
    for name, own in _identity(setup).items():
        if told[name] != own:
            raise ResultError(f"it is that of another observer or of other muscles: its {name} differ")
    _check_sizes(told, setup)
    _check_times(told)
    return told


def known(number: float) -> list[float]:
    """A time that may not be known yet."""
    return [number] if math.isfinite(number) else []


def _check_sizes(told: dict[str, Any], setup: Setup) -> None:
    """ResultError if something is not as many numbers as this observer of these muscles has."""
    running, width = bool(told["first"]), len(setup.units)
    begun = running or bool(told["learnt_from"])
    sizes = {"first": width, "y": width, "x": len(setup.block.x), "taut": len(setup.subject.muscles)}
    wrong = [name for name, size in sizes.items() if len(told[name]) != size * running]
    wrong += [name for name in ("start", "followed", "last") if not begun <= len(told[name]) <= 1]
    wrong += ["learnt_from"] * any(len(row) != 1 + width for row in told["learnt_from"])
    if wrong or not -1 <= told["count"] <= _MOST:
        raise ResultError(f"its {(*wrong, 'count')[0]} has another size than this observer's")


def _check_times(told: dict[str, Any]) -> None:
    """ResultError unless the times are those of one clock: else steps of any length would follow."""
    last = [told["base"] + told["count"] * told["period"]] if told["count"] >= 0 else []
    samples = [row[0] for row in told["learnt_from"]]
    rising = [*told["start"], *told["followed"], *told["last"]]
    if told["last"] != last or rising != sorted(rising):
        raise ResultError("its times do not belong together")
    if samples and (samples != sorted(set(samples)) or [samples[0], samples[-1]] != rising[:2]):
        raise ResultError("the times of its samples do not rise from its start")


def _identity(setup: Setup) -> dict[str, Any]:
    """Whose state it is."""
    muscles = hashlib.sha256(json.dumps(setup.subject.file, sort_keys=True).encode()).hexdigest()
    about = {"observer": setup.block.name, "corrected": setup.corrected, "muscles": muscles}
    return {**about, "states": list(setup.block.x)}
