"""Numbers as people and programs write them: the usual ones, those at an edge, and those that are none."""

from __future__ import annotations

from random import Random

from hostile.case import Layer

EDGES = (
    *("0", "-0", "-0.0", "1", "-1", "1e300", "-1e300", "1e-300", "1e308", "1.8e308", "1e400", "-1e400", "5e-324"),
    *("2.2250738585072014e-308", "1e-308", "1e5", "1e-5", "1e10", "1e-10", "1e16", "4294967296", "9007199254740993"),
)
NONE = (
    *("nan", "-nan", "inf", "-inf", "Infinity", "1_000", "١٢", "½", "²", "True", "true", "None", "1e", "e5", ".", ""),
    *(
        " 1",
        "1 ",
        "1,5",
        "0x10",
        "1d5",
        "1e5e5",
        "--1",
        "+-1",
        "1/3",
        "0.1.2",
        "９",
        "1\u00a0",
        "\x1b[31m1",
        "9" * 5000,
    ),
)
FACTORS = (0.0, -1.0, 0.5, 0.9, 0.999, 1.001, 1.1, 2.0, 10.0, 100.0, 1e3, 1e6, 0.1, 1e-2, 1e-3, 1e-6)


def near(random: Random, value: float) -> str:
    """A number that has to do with a usual one: a multiple, mostly; or one at an edge."""
    if random.random() < 0.25:
        return random.choice(EDGES)
    return repr((value or 1.0) * random.choice(FACTORS))


def number(random: Random, value: float) -> str:
    """The same, or now and then none at all."""
    return random.choice(NONE) if random.random() < 0.12 else near(random, value)


def refused(text: str) -> Layer:
    """What is expected if one of the numbers in `text`, as they are typed, is none."""
    return {"code": 2} if any(part in NONE for part in text.split(",")) else {}
