"""Saved states of a follower: a good one, and ones that are damaged or forged."""

from __future__ import annotations

from random import Random

from hostile.case import Layer
from hostile.draw.names import odd_kind, odd_name, odd_out
from hostile.results import STATE

FILE, _LEFT = "kept", "left"
_LISTS = ("last", "start", "followed", "learnt_from", "first", "x", "y", "taut", "states")
_NUMBERS = ("version", "period", "T", "seconds", "base", "count")
_NAN = float("nan")
_NUMBER = (0, -1, 1, 0.5, 5e-324, 1e-300, 1e300, -1e300, 1.7e308, _NAN, 2**53, 2**80, -0.0, 1e9)
_NO_NUMBER = ("x", None, True, [], {}, [[]], [None], ["1"], [0.0] * 7, [1e300] * 3, [[0.0, 0.3, 1.0, 1.0]], "\x1b[31m")
_GAINS = (
    *({}, {"high_gain.eps_h": 0.0}, {"high_gain.eps_h": 1e-300, "high_gain.eps_L": 1e-300}, {"x": 1.0}, {"": 1.0}),
    *({"high_gain.eps_h": 1e300, "high_gain.eps_L": 1e300}, {"high_gain.eps_h": _NAN}, {"high_gain.m": -1.0}),
)


def state(random: Random) -> Layer:
    """A good state of the high gain observer of the shipped muscles."""
    words = ["--state", FILE, "--observer", "high_gain"]
    return {"words": words, "files": {FILE: {"result": STATE}}}


def damaged(random: Random) -> Layer:
    """The state cut, flipped or forged, or something else in its place."""
    match random.randrange(8):
        case 0:
            return odd_name(random, FILE) if random.random() < 0.5 else odd_kind(random, FILE)
        case 1:
            return {"files": {FILE: {"result": STATE, "cut": random.choice((0.0, 0.5, 0.999, random.random()))}}}
        case 2:
            piece = random.choice(("00", "ff", "41", "0a", "3d3d"))
            return {"files": {FILE: {"result": STATE, "edits": [[random.random(), piece]]}}}
        case _:
            changes = dict(_change(random) for _ in range(random.choice((1, 1, 2, 3))))
            return {"files": {FILE: {"forged": changes}}}


def kept(random: Random) -> Layer:
    """Where the state is kept at the end."""
    return {"words": ["--save-state", _LEFT]}


def out(random: Random) -> Layer:
    """A place for the state where something is already, or nothing can be."""
    if random.random() < 0.5:
        return {"words": ["--save-state", _LEFT], **odd_out(random, _LEFT)}
    name = random.choice((FILE, "a/b", "..", "", ".", "/", "/dev/null", "../other/letter.txt", "my.csv", "\x1b[31m"))
    return {"words": ["--save-state", name]}


def _change(random: Random) -> tuple[str, object]:
    if random.random() < 0.1:
        return "gains", random.choice(_GAINS)
    if random.random() < 0.1:
        return random.choice(
            ("kind", "observer", "corrected", "muscles", "learning", "failure", "more")
        ), random.choice(_NO_NUMBER)
    # numbers within the lists of numbers lead further than other lists
    name = random.choice((*_LISTS, *_NUMBERS, "x", "x", "y", "first"))
    return name, random.choice(_NUMBER if random.random() < 0.75 else _NO_NUMBER)
