"""Runs of a scenario: shipped ones, files of their own, numbers and choices changed."""

from __future__ import annotations

from random import Random

from hillobs.studies.scenarios.loops import all_paths
from hostile.case import Layer
from hostile.draw.names import odd_kind, odd_name
from hostile.draw.numbers import number, refused
from places import OF_THE_PAIR

OBSERVERS = ("high_gain", "high_gain_3", "sliding_mode", "adaptive_sliding_mode", "levant")
_FILE = "x.toml"
# a number of the grid of time decides how long a case takes: these are short, or refused
_TIMES = {
    "duration": ("0", "0.01", "0.05", "0.3", "1", "2", "1e300", "1e-300", "-1", "nan", "1e7", "0.2000001"),
    "step": (
        "0",
        "1e-3",
        "1e-4",
        "5e-4",
        "0.05",
        "0.1",
        "0.2",
        "1",
        "1e-300",
        "1e300",
        "3e-4",
        "-5e-4",
        "0.0005000001",
    ),
    "record": ("0", "0.01", "0.05", "0.2", "1e-300", "1e300", "0.0005", "0.003", "-1"),
    "noise.period": ("0", "0.005", "0.05", "0.2", "1e-300", "1e300", "0.0007", "-1"),
}
_DRIVES = ("virtual", "given", "neural", "", "VIRTUAL", "\x1b[31m", "virtual ")
_TEXTS = (
    "",
    "nan",
    "a\x1b[31mb",
    "\u202eabc",
    "[red]x[/red]",
    "x" * 5000,
    "a\udcffb",
    "zero\0byte",
    "[/]",
    "\n\n",
    "%s",
)


def short_run(random: Random) -> Layer:
    """What makes a run short enough for many cases."""
    duration = random.choice(["0.2"] * 8 + ["0.05", "1"])
    return {"words": ["--set", f"duration={duration}", "--set", "score.start=0.04"]}


def scenario(random: Random) -> Layer:
    """A shipped scenario of the pair, since a mechanism takes long to compile, or a valid file."""
    if random.random() < 0.7:
        return {"words": [random.choice(OF_THE_PAIR)]}
    return {"words": [_FILE], "files": {_FILE: {"text": _document(random, [])}}}


def change(random: Random) -> Layer:
    """A number, a choice or a text changed by --set."""
    path, value = changed(random)
    return {"words": ["--set", f"{path}={value}"], **(refused(value) if path != "description" else {})}


def slight_change(random: Random) -> Layer:
    """A number that hardly differs from the usual one, written in some way that is allowed."""
    path = random.choice(("plant.m", "high_gain.m", "high_gain.eps_h", "sliding_mode.delta_s", "controller.gamma"))
    value = all_paths().parameters[path].default
    written = random.choice(("{!r}", "{:.12e}", "{:+.6f}", "{:.9g}"))
    return {"words": ["--set", f"{path}={written.format(value * random.choice((0.999, 1.0, 1.001)))}"]}


def changed(random: Random) -> tuple[str, str]:
    """A path and what it is set to."""
    kind = random.random()
    if kind < 0.03:
        return "plant.drive", random.choice(_DRIVES)
    if kind < 0.05:
        return "description", random.choice(_TEXTS)
    if kind < 0.08:
        return "seed", random.choice(
            ("0", "-1", "18446744073709551615", "18446744073709551616", "1.0", "1e3", "٣", "1_0")
        )
    if kind < 0.11:
        return random.choice(
            ("plant", "plant.mass", "", ".", "plant.m.", "high_gain.muscle1.k", "\x1b", "x" * 3000)
        ), "1"
    if kind < 0.18:
        path = random.choice(list(_TIMES))
        return path, random.choice(_TIMES[path])
    paths = all_paths()
    known = {**paths.groups(), **paths.parameters}
    path = random.choice([path for path in known if path not in _TIMES])
    return path, number(random, known[path].default)


def gain(random: Random) -> tuple[str, str]:
    """A gain of an observer, or a path that is none, and its number."""
    paths = all_paths().parameters
    path = random.choice([*(path for path in paths if path.startswith(OBSERVERS)), "plant.m", "high_gain.nothing"])
    return path, number(random, paths[path].default if path in paths else 1.0)


def document(random: Random) -> Layer:
    """A scenario file with something wrong in it, instead of the scenario."""
    lines = [f"{path} = {value}" for path, value in (changed(random) for _ in range(random.choice([1, 1, 2])))]
    odd = ["[plant\n", "a = " + "[" * 3000, "\udcff = 1", 'base = "nothing"', 'base = "slack"', "x = 1", "plant = 1"]
    odd += ["plant.m = 1\n[plant]\nm = 2", 'description = "a\\u0000b"', "seed = 1.5", "plant.m = true", "\ufeff", "[]"]
    odd += [
        "plant.m = 2020-01-01",
        "seed = 0x" + "f" * 5000,
        "plant.m = inf",
        "[plant]",
        "[a.b.c.d.e.f.g.h.i.j.k]\nx=1",
    ]
    if random.random() < 0.3:
        lines.append(random.choice(odd))
    return {"words": [_FILE], "files": {_FILE: {"text": _document(random, lines)}}}


def _document(random: Random, lines: list[str]) -> str:
    return "\n".join(["duration = 0.2", "score.start = 0.04", *lines]) + "\n"


def odd_file(random: Random) -> Layer:
    """A scenario file with an odd name, or that is none."""
    good = {"words": [_FILE], "files": {_FILE: {"text": _document(random, [])}}}
    if random.random() < 0.6:
        layer = odd_name(random, _FILE)
        # `--` for names that begin with a dash
        return {**good, **layer, "words": ["--", _FILE]}
    return {**good, **odd_kind(random, _FILE)}


def observers(random: Random) -> Layer:
    """One observer that may not be named here, or not twice, or that there is none of."""
    return named(random.choice([["kalman"], [""], ["high_gain", "high_gain"], ["baseline"], ["\x1b[31m"], ["truth"]]))


def odd_observers(random: Random) -> Layer:
    """One that there is none of, whatever is simulated."""
    return named([random.choice(("", "baseline", "truth", "\x1b[31m", "own.py:block", ":"))])


def good_observers(random: Random) -> Layer:
    """Some observers."""
    return named(random.sample(OBSERVERS, random.choice([1, 2, 4])))


def named(names: list[str]) -> Layer:
    """These observers."""
    return {"words": [word for name in names for word in ("--observer", name)]}
