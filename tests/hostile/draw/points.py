"""Questions of `hillobs observability`."""

from __future__ import annotations

from random import Random

from hostile.case import Layer
from hostile.draw.numbers import number

_USUAL = {"x1": 2.77, "x2": 0.0, "x3": 2.02, "x4": 2.02, "Delta": 0.0, "u1": 0.0, "x9": 1.0, "": 1.0, "a1": 0.35}


def option(random: Random) -> Layer:
    """An option of the command, good or bad."""
    name = random.choice(list(_USUAL))
    place = ",".join(
        f"{key}={number(random, _USUAL[key])}" for key in random.sample(list(_USUAL)[:4], random.choice((1, 2)))
    )
    words = random.choice(
        [
            ["--at", place],
            ["--at", place],
            ["--at", f"{name}={number(random, _USUAL[name])}"],
            [
                "--outputs",
                random.choice(("x1,F1", "x1", "y9", "", ",", "x1,x1", "L_C1", "x1,F1,F2,x2,L_C1,L_C2", "\x1b")),
            ],
            [
                "--parameters",
                random.choice(("muscle1.k", "muscle1.k,muscle2.L_slack", "muscle3", "x3", "", ",", "\x1b")),
            ],
            ["--unknown", random.choice(("none", "u", "a", "z", "", "\x1b"))],
            ["--signals", random.choice(("0", "1", "-1", "9", "x", "1e3"))],
            ["--order", random.choice(("0", "1", "2", "3", "-1", "x", "1.5", "99999"))],
            ["--tolerance", number(random, 1e-8)],
            ["--json"],
        ]
    )
    return {"words": words}


def extent(random: Random) -> Layer:
    """A rank along a run, or over a map: slow, so rarely."""
    axes = random.choice(("x3,x4", "x1,tension", "x3", "x3,q", "x3,x3", "", ",", "x3,x4,x1", "tension,x1", "\x1b,x3"))
    return {"words": random.choice([["--map", axes], ["--map", axes], ["--along", "--set", "duration=0.1"]])}
