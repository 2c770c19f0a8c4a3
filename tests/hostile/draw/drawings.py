"""Results that are to be drawn again: whole, damaged, or something else."""

from __future__ import annotations

from random import Random

from hostile.case import Layer
from hostile.draw.names import odd_kind, odd_name
from hostile.results import RESULTS

FILE = "r.nc"


def drawing(random: Random) -> Layer:
    """A whole result."""
    return {"words": [FILE], "files": {FILE: {"result": random.choice(RESULTS)}}}


def of(name: str) -> Layer:
    """The whole result of this kind."""
    return {"files": {FILE: {"result": name}}}


def damage(random: Random) -> Layer:
    """A result that is damaged, in the place of the whole one."""
    entry: dict[str, object] = {"result": random.choice(RESULTS)}
    if random.random() < 0.3:
        entry["cut"] = random.choice((0.0, 0.001, 0.5, 0.999, random.random()))
    else:
        pieces = ("00", "ff", "00" * 64, "ff" * 512, "89484446", "41" * 8)
        entry["edits"] = [[random.random(), random.choice(pieces)] for _ in range(random.choice((1, 1, 3)))]
        # a seal that fits lets the damage through to the reader
        entry["seal"] = random.random() < 0.8
    return {"files": {FILE: entry}}


def odd_file(random: Random) -> Layer:
    """An odd name, or something else in its place."""
    return odd_name(random, FILE) if random.random() < 0.5 else odd_kind(random, FILE)
