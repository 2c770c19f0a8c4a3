"""Samples on standard input: good ones, as CSV or JSON, and what may be wrong with a stream of them."""

from __future__ import annotations

import json
from random import Random

from hillobs.studies.laboratory.lines import LONGEST_LINE
from hostile.case import Layer
from hostile.draw.numbers import EDGES
from hostile.draw.recordings import Table, csv_text, damage

# lines that are no samples
_LINES = (
    *("", "#", "# words", "\0\0", "\udcff", "\ufeff", '"', ",,,", "nan,nan,nan,nan", "nonsense", "\r", "\x1b[31m"),
    *("{", "{}", "[1]", "1e999", "null", "{" * 3000, '{"a":' * 3000, "time,position,force_1,force_2", "\u202ex,1"),
    *("x" * (LONGEST_LINE + 1), "1" * LONGEST_LINE, "0," * 10_000),
)
_MANY = 500
# what stands for a number in JSON
_VALUES = (
    *("null", "true", '"0.3"', "[0.3]", "{}", "NaN", "Infinity", "-Infinity", "1e400", "-0", "5e-324", "0x1", "1_0"),
    *('"\\ud800"', '"\\u0000"', '"\\u001b[31m"', "1" + "0" * 400, "1" * 5000, "[" * 2000, "0.3 0.3", *EDGES),
)
_KEYS = (
    *("", "time", "position", "position [mm]", "position [furlong]", "force_1 [kN]", "time_ms", "\x1b[31m", "\udcff"),
    *("x" * 3000, "\u202ex", "position,force_1"),
)


def samples(random: Random, table: Table) -> Layer:
    """Good samples, one after the other."""
    return _given(csv_text(table) if random.random() < 0.6 else _objects(table))


def damaged(random: Random, table: Table) -> Layer:
    """The samples with something wrong among them."""
    lines = (csv_text(table) if random.random() < 0.6 else _objects(table)).splitlines(keepends=True)
    at = random.randrange(len(lines))
    match random.randrange(9):
        case 0 | 1 | 2:
            return _given(csv_text(*damage(random, table)))
        case 3 | 4:
            return _given(_objects(_with_odd_values(random, table)))
        case 5:
            text = "".join(lines)
            return _given(text[: random.randrange(len(text))])
        case 6:
            lines[at:at] = [random.choice(_LINES) + "\n"] * random.choice((1, 1, _MANY))
        case 7:
            lines[at] = random.choice(_LINES) + "\n"
        case _:
            # begun again, or the end of another stream
            lines[at:at] = random.choice((lines, lines[1:], csv_text(table).splitlines(keepends=True)))
    return _given("".join(lines))


def unheard(random: Random) -> Layer:
    """A standard input that cannot be read."""
    return {"streams": {"stdin": random.choice(("closed", "unreadable"))}}


def option(random: Random) -> Layer:
    """A time of `live`, or who follows, good or bad."""
    times = ("0", "5ms", "0.005", "1ms", "1us", "-5ms", "1h", "nan", "inf", "1e300", "1e-300", "5 ms", "١ms", "", "ms")
    observers = (
        "baseline",
        "truth",
        "",
        "nothing",
        "\x1b[31m",
        "own.py:block",
        "own.py:",
        ":x",
        ".py:a b",
        "../x.py:x",
    )
    words = random.choice(
        [
            ["--period", random.choice(times)],
            ["--learning", random.choice((*times, "600s", "601s", "0.3s"))],
            ["--observer", random.choice(observers)],
            ["--observer", "high_gain", "--observer", "high_gain"],
            ["--gains", random.choice(("no.nc", ".", "my.csv", "../other/letter.txt", "\x1b"))],
            ["--state", random.choice(("no", ".", "my.csv", "../other/letter.txt", "/dev/null", ""))],
        ]
    )
    return {"words": words}


def _given(text: str) -> Layer:
    return {"input": {"text": text}}


def _objects(table: Table) -> str:
    """A JSON object for each row."""
    return "".join(_object(zip(table[0], row, strict=False)) for row in table[1:])


def _object(cells: zip[tuple[str, str]]) -> str:
    return "{" + ", ".join(f"{json.dumps(key)}: {value}" for key, value in cells) + "}\n"


def _with_odd_values(random: Random, table: Table) -> Table:
    """Something else for one value, for one key, or one cell less or more."""
    rows = [list(row) for row in table]
    row, column = random.choice(rows[1:]), random.randrange(len(rows[0]))
    match random.randrange(4):
        case 0 | 1:
            row[column] = random.choice(_VALUES)
        case 2:
            rows[0][column] = random.choice(_KEYS)
        case _:
            del row[column:]
    return rows
