"""Trials of a calibration: a good file of one, and what may be wrong with it."""

from __future__ import annotations

from random import Random

from hostile.case import Layer
from hostile.draw.names import odd_kind, odd_name
from hostile.draw.numbers import number

FILE, RECORDING, MUSCLES = "trial.toml", "maximal.csv.gz", "guess.toml"
_LEVELS = ("1.0", "{ value = 1.0, sd = 0.01 }", "{ value = 1, sd = 0 }", "0.98")
_ODD_LEVELS = (
    *(
        '"force_1"',
        '"no such column"',
        '"\\u001b[31m"',
        "true",
        "[1.0]",
        "{ value = 1 }",
        "{ sd = 1 }",
        "{ value = 1, sd = nan }",
    ),
    *('{ column = "position", sd = 0.1 }', "{ value = 1.0, sd = -1 }", "{ value = { }, sd = { } }", "1979-05-27"),
)
_LINES = (
    *("between = [4, 1]", "between = [nan, inf]", "between = [0.3, 0.4]", "between = [0.5, 4.5, 5]", "between = 1"),
    *("x = 1", "a = [", "\ufeff", "columns = 1", 'recording = "no.csv"', 'recording = "\\u0000"', "recording = 1"),
    *('recording = "../other/letter.txt"', f'recording = "{FILE}"', f'recording = "{MUSCLES}"'),
)
_TABLES = (
    *(
        '[columns]\nposition = "force_1"',
        '[columns]\nposition = { column = "position", unit = "mm" }',
        "[columns]\ntime = 1",
    ),
    *('[columns]\nforce_1 = "force_2"', '[columns]\nnothing = "x"', "[activations]", "[muscle1]\nF_max = 1"),
)


def trial(random: Random) -> Layer:
    """A good file with its recording, and the muscles as they are guessed."""
    files = {
        FILE: {"text": _text(random.choice(_LEVELS))},
        RECORDING: {"shipped": RECORDING},
        MUSCLES: {"shipped": MUSCLES},
    }
    return {"words": [FILE, "--muscles", MUSCLES], "files": files}


def changed(random: Random) -> Layer:
    """The file with something else in it."""
    level, lines, tables = random.choice(_LEVELS), [f'recording = "{RECORDING}"'], []
    match random.randrange(5):
        case 0:
            level = random.choice(_ODD_LEVELS)
        case 1:
            level = number(random, 1.0)
        case 2:
            lines = random.choice(([*lines, random.choice(_LINES)], [random.choice(_LINES)], []))
        case 3:
            tables = [random.choice(_TABLES)]
        case _:
            tables = [f"muscle{random.choice((2, 3))} = {number(random, 0.5)}"]
    return {"files": {FILE: {"text": _text(level, lines, tables)}}}


def again(random: Random) -> Layer:
    """The same trial twice, or one of the passive muscle beside it."""
    if random.random() < 0.5:
        return {"words": [FILE], "code": 2}
    return {
        "words": ["stretch.toml"],
        "files": {name: {"shipped": name} for name in ("stretch.toml", "stretch.csv.gz")},
    }


def odd_file(random: Random) -> Layer:
    """One of the files under an odd name, or something else in its place."""
    name = random.choice((FILE, RECORDING, MUSCLES))
    return odd_name(random, name) if random.random() < 0.3 else odd_kind(random, name)


def _text(level: str, lines: list[str] | None = None, tables: list[str] | None = None) -> str:
    first = [f'recording = "{RECORDING}"'] if lines is None else lines
    return "\n".join([*first, "[activation]", f"muscle1 = {level}", *(tables or [])]) + "\n"
