"""Names of files, and kinds of things that may be found where a file is expected."""

from __future__ import annotations

import os
from random import Random

from hostile.case import Layer

ODD = (
    *(
        "a[/x]",
        "run[bold]",
        "-dash",
        "sp ace",
        "$(touch made)",
        "`touch made`",
        "ü😀",
        "...",
        "=1+1",
        "a;b",
        "a'b",
        'a"b',
    ),
    *(
        "red\x1b[31m",
        "bell\a",
        "back\r",
        "new\nline",
        "\x9b31m",
        "\u202egpj",
        "\u2066x",
        "zero\u200bwidth",
        "tab\t",
        "%s%n",
    ),
    *(
        os.fsdecode(b"\xff"),
        os.fsdecode(b"a\xc3"),
        "e\u0301",
        "{x}",
        "*",
        "?",
        "~",
        "a\\b",
        "n" * 200,
        "ß" * 120,
        "CON",
    ),
)


def odd_name(random: Random, name: str) -> Layer:
    """The file `name` under an odd name, with the same ending."""
    _, dot, ending = name.partition(".")
    return {"names": {name: random.choice(ODD) + dot + ending}}


def odd_kind(random: Random, name: str) -> Layer:
    """Something else than a file at `name`."""
    entry = random.choice(
        [
            {"link": name},
            {"link": "nowhere"},
            {"link": "../other/letter.txt"},
            {"link": "/dev/zero"},
            {"link": "/dev/stdin"},
            {"link": "/proc/self/mem"},
            {"link": "."},
            {"folder": True},
            {"pipe": True},
            {"text": "", "mode": 0},
            {"text": ""},
            {"text": "\0" * 100},
            {"text": "\udcff\udcfe"},
            {"text": "x" * 300_000},
            {"text": "\ufeff"},
            {"gzip": "x"},
        ]
    )
    return {"files": {name: entry}}


def odd_out(random: Random, out: str) -> Layer:
    """Something that is already where results are to go."""
    entry = random.choice(
        [
            {"link": "../other"},
            {"link": out},
            {"link": "nowhere"},
            {"link": "../other/letter.txt"},
            {"pipe": True},
            {"text": "mine\n"},
            {"folder": True, "mode": 0o500},
            {"folder": True},
            {"result": "run"},
        ]
    )
    return {"files": {out: entry}}
