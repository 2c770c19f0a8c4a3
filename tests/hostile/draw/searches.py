"""Searches for gains: whose, for which objectives, over what, and what is already where the trials are to go."""

from __future__ import annotations

from random import Random

from hostile.case import Layer
from hostile.draw.numbers import near

# the least: one round, on few runs
SMALL = ("--trials", "50", "--seeds", "1")
_OBSERVERS = ("high_gain", "sliding_mode", "adaptive_sliding_mode", "kalman_constant")
_COUNTS = ("0", "-1", "1_0", "٣", "", "1.5", "999999999999", "9" * 400, "1e3")


def whose(random: Random) -> Layer:
    """An observer whose gains can be tuned."""
    return {"words": ["--observer", random.choice(_OBSERVERS)]}


def good_option(random: Random) -> Layer:
    """An option that is as it should be."""
    options = (
        ["--quantity", "x2"],
        ["--quantity", "x2,u1"],
        ["--quantity", "a1", "--quantity", "Delta"],
        ["--workers", "1"],
    )
    return {"words": list(random.choice(options))}


def option(random: Random) -> Layer:
    """Another option, mostly a bad one."""
    low, high = near(random, 0.1), near(random, 0.3)
    words = random.choice(
        [
            ["--quantity", random.choice(("x9", "", "x2,", "x2,x2", ",", "\x1b"))],
            ["--trials", random.choice(_COUNTS)],
            ["--seeds", random.choice((*_COUNTS, "2"))],
            ["--workers", random.choice(("0", "-1", "x", "9" * 30))],
            ["--observer", random.choice(("baseline", "nonsense", "", "own.py:block", "\x1b"))],
            ["--over", f"{random.choice(('high_gain.eps_h', 'sliding_mode.tau_s'))}=log:{low}:{high}"],
            ["--over", f"high_gain.h11=lin:{low}:{high}"],
            [
                "--over",
                random.choice(("plant.m=log:0.5:2", "high_gain.h11=1,2", "x=log:1:2", "high_gain.m=log:0.5:2:3")),
            ],
        ]
    )
    return {"words": words}


def earlier(random: Random) -> Layer:
    """Something that hillobs has not written where the trials are to go."""
    name = f"out/tuned-paper-noisy,high_gain.{random.choice(('trials', 'toml'))}"
    return {"words": ["--out", "out"], "files": {name: {"text": random.choice(("", "{}\n", "\x00", "x" * 1000))}}}
