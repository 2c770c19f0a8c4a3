"""Recordings, as others write them and as they should not; and the mappings of their columns."""

from __future__ import annotations

import functools
import gzip
from pathlib import Path
from random import Random

from hostile.case import Layer
from hostile.draw.names import odd_kind, odd_name
from hostile.draw.numbers import EDGES, NONE
from places import CORPUS, RECORDINGS

# samples of a recording that is drawn: half a second
_ROWS = 101
OF_A_PAIR = RECORDINGS / "dgf_smooth_noisy.csv.gz"
_CELLS = (
    "",
    "nan",
    "NaN",
    "-nan(ind)",
    "1.#INF",
    "abc",
    '"',
    "'1'",
    "#",
    "0.3 ",
    "0,3",
    "=1+1",
    "\x1b[31m",
    *NONE[:12],
    *EDGES[:9],
)
_HEADERS = (
    *(
        "time",
        "position",
        "force_1",
        "force_2",
        "position [mm]",
        "force_1 (kN)",
        "time_ms",
        "TIME",
        "",
        "x",
        "angle [deg]",
    ),
    *(
        "position [furlong]",
        "/forceset/m1|tendon_force",
        "a\x1b[31m",
        "\u202ex",
        "position,position",
        '"time',
        "time\0",
    ),
)
_MAPPINGS = (
    *(
        "position=x",
        "position=position",
        "position=position[mm]",
        "position=position_measured[m]",
        "time=position",
        "=x",
    ),
    *(
        "position=",
        "position",
        "nothing=position",
        "position=position[furlong]",
        "position=\x1b[31m",
        "map.toml",
        "no.toml",
    ),
    *("force_1=force_2", "force_1=force_1[N", "position=" + "x" * 3000, "position=\udcff", "disturbance=time"),
)


# names of columns, then the cells of each row
Table = list[list[str]]


@functools.cache
def _shipped(path: Path) -> tuple[str, ...]:
    raw = gzip.decompress(path.read_bytes())
    return tuple(raw.decode().splitlines()[: _ROWS + 1])


def table(truth: bool, path: Path = OF_A_PAIR) -> Table:
    """The first rows of a recording that is there, with or without the truth."""
    rows = [line.split(",") for line in _shipped(path)]
    kept = range(len(rows[0])) if truth else range(4)
    return [
        [row[i].removesuffix("_measured") if n == 0 and not truth else row[i] for i in kept]
        for n, row in enumerate(rows)
    ]


def csv_text(table: Table, delimiter: str = ",", newline: str = "\n") -> str:
    """The table as CSV."""
    return "".join(delimiter.join(row) + newline for row in table)


def recording(random: Random, path: Path = OF_A_PAIR) -> Layer:
    """A good recording: CSV, .sto or .mot, plain or gzipped, with or without the truth."""
    name = random.choice(("r.csv", "r.csv", "r.csv.gz", "r.sto", "r.mot"))
    return {"words": [name], "files": {name: _entry(name, table(random.random() < 0.5, path))}}


def _entry(name: str, table: Table, delimiter: str = ",", newline: str = "\n") -> dict[str, str]:
    text = csv_text(table, delimiter, newline)
    if name.endswith((".sto", ".mot")):
        text = f"r\nversion=1\nnRows={len(table) - 1}\nnColumns={len(table[0])}\ninDegrees=no\nendheader\n"
        text += csv_text(table, "\t", newline)
    return {"gzip" if name.endswith(".gz") else "text": text}


def damaged(random: Random, name: str, path: Path = OF_A_PAIR) -> Layer:
    """The recording `name` with something wrong in it."""
    whole = table(random.random() < 0.5, path)
    return {"files": {name: _entry(name, *damage(random, whole))}}


def damage(random: Random, whole: Table) -> tuple[Table, str, str]:
    """A table with something wrong in it, what is between its cells, and what between its rows."""
    table = [list(row) for row in whole]
    row, column = random.randrange(1, len(table)), random.randrange(len(table[0]))
    delimiter, newline = ",", "\n"
    match random.randrange(16):
        case 0 | 1 | 2 | 3:
            table[row][column] = random.choice(_CELLS)
        case 4:
            for each in table[1:]:
                each[column] = random.choice(("0", "1", "-1", "nan", "1e300", "-0", "1e-300", "0.31"))
        case 5:
            factor = random.choice((1e-300, 1e-9, 1e-3, -1.0, 10.0, 1e3, 1e9, 1e300))
            for each in table[1:]:
                each[column] = repr(float(each[column]) * factor)
        case 6 | 7:
            table[0][column] = random.choice(_HEADERS)
        case 8:
            del table[random.choice((1, 2, 3, 50)) :]
        case 9:
            table[row] = table[row - 1] if random.random() < 0.5 else table[row][: random.randrange(len(table[0]))]
        case 10:
            table[1:] = table[:0:-1]
        case 11:
            for each in table[row : row + random.choice((1, 10, 60))]:
                each[1:] = ["nan"] * len(each[1:])
        case 12:
            del table[row : row + random.choice((1, 20, 80))]
        case 13:
            delimiter, newline = (
                random.choice((";", "\t", " ", "|", ", ", ",,")),
                random.choice(("\r\n", "\r", "\n\n", "\n")),
            )
        case 14:
            # a column that leaps or drifts away, as a sensor that has come loose
            for i, each in enumerate(table[1:]):
                each[1] = repr(float(each[1]) + random.choice((0.0, 0.05)) * (i > row) + 1e-3 * i)
        case _:
            random.shuffle(table)
    return table, delimiter, newline


def odd_recording(random: Random, name: str) -> Layer:
    """Something else than a recording, one of the corpus, or an odd name."""
    kind = random.random()
    if kind < 0.4:
        return odd_name(random, name)
    if kind < 0.8:
        return odd_kind(random, name)
    known = random.choice(sorted((CORPUS / "recordings").glob("*.csv")))
    return {"files": {name: {"text": known.read_bytes().decode("utf-8", "surrogateescape")}}}


def mapping(random: Random) -> Layer:
    """Names of columns, and a file of them that is good or not."""
    text = random.choice(
        ('position = "x"\n', "position = 1\n", "position = { column = 1 }\n", "[a]\n", "\ufeff", "a = [")
    )
    words = [word for _ in range(random.choice((1, 1, 2))) for word in ("--map", random.choice(_MAPPINGS))]
    return {"words": words, "files": {"map.toml": {"text": text}}}
