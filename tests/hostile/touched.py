"""Where a command may write, and what it has touched beside that."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from hostile.case import Case
from hostile.sandbox import DESK, TEMPORARY, Snapshot

# what these are told to write is a file, not a folder, by this option
_FILES = {"sweep": "--out", "import": "--out", "calibrate": "--out", "live": "--save-state", "export page": "--out"}
_USUAL = {
    "simulate": "results",
    "tune": "results",
    "estimate": "estimates",
    "calibrate": "calibrated.toml",
    "observability": "results",
    "curves": "results",
}


def may_write(case: Case, box: Path) -> list[str]:
    """The files and folders that a command is told to write to, from the folder of its case."""
    cache = case.environment.get("HILLOBS_CACHE") or ""
    own_cache = [cache.removeprefix("BOX/")] if cache.startswith("BOX/") else []
    return [*own_cache, *_results(case, box)]


def _results(case: Case, box: Path) -> list[str]:
    desk = os.path.join(box, DESK)
    if case.python:
        return [_from(box, os.path.join(desk, name)) for name in case.writes]
    verb = case.words[0] if case.words else ""
    file = _FILES.get(" ".join(case.words[:2]), _FILES.get(verb))
    out = _option(case.words, file or "--out")
    if verb == "figures" and out is None:
        out = os.path.dirname(next((word for word in case.words[1:] if not word.startswith("-")), "")) or "."
    out = _USUAL.get(verb) if out is None else out
    if out is None or "\0" in out:
        return []
    # a folder may be a link: it is what the user has named
    place = os.path.realpath(os.path.join(desk, out)) if file is None else _beside_link(desk, out)
    if file is None:
        return [_from(box, place)]
    written = os.path.join(os.path.dirname(place), f".hillobs-{os.geteuid()}")  # the list of what is ours there
    names = [place, f"{place}.parts", f"{os.path.splitext(place)[0]}-*", written]
    return [_from(box, name) for name in names]


def _beside_link(desk: str, out: str) -> str:
    """The name of a result: its folder is followed, it itself is not."""
    whole = os.path.join(desk, out)
    return os.path.join(os.path.realpath(os.path.dirname(whole)), os.path.basename(whole))


def _from(box: Path, path: str) -> str:
    return os.path.relpath(path, os.path.realpath(box))


def _option(words: tuple[str, ...], name: str) -> str | None:
    value = None
    for i, word in enumerate(words):
        if word == "--":
            break
        if word == name and i + 1 < len(words):
            value = words[i + 1]
        elif word.startswith(f"{name}="):
            value = word.partition("=")[2]
    return value


def wrongly_touched(before: Snapshot, after: Snapshot, allowed: list[str], made: set[str]) -> Iterator[str]:
    """A sentence for each thing that is changed, gone, or new where it must not be.

    made: what earlier runs of ours have left there, which may be written again or removed.
    """
    for name, was in before.items():
        # an empty folder of parts is taken for that of a start that was killed: SECURITY.md
        if name in made or (name not in after and name in allowed and _is_empty_parts(name, before)):
            continue
        if name not in after:
            yield f"{name!r} is gone"
        elif after[name] != was:
            yield f"{name!r} is changed: {was[:3]} became {after[name][:3]}"
    for name in after.keys() - before.keys():
        if not any(_is_at(name, place) or (_is_at(place, name) and after[name][0] == "folder") for place in allowed):
            where = "is left in the temporary folder" if _is_at(name, TEMPORARY) else "is new, and not where it may be"
            yield f"{name!r} {where}"


def _is_empty_parts(name: str, before: Snapshot) -> bool:
    empty = before[name][0] == "folder" and not any(other.startswith(f"{name}/") for other in before)
    return empty and name.endswith(".parts")


def _is_at(name: str, place: str) -> bool:
    """Whether a name is the place or below it; a place that ends in -* is figures of a sweep."""
    if place.endswith("-*"):
        return name.startswith(place[:-1]) and name.endswith((".png", ".pdf"))
    return place == "." or name == place or name.startswith(f"{place}/")
