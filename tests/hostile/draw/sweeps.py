"""Sweeps: axes, seeds, designs, what is scored, and what is already where the result is to go."""

from __future__ import annotations

from random import Random

from hillobs.studies.scenarios.loops import all_paths
from hillobs.studies.scenarios.paths import RUN
from hostile.case import Layer
from hostile.draw.names import odd_out
from hostile.draw.numbers import NONE, near, number, refused

_COUNTS = ("0", "-1", "1_0", "٣", "", "1.5", "999999999999", "9" * 400, "1e3", "2", "3")
# whichever is scored, a library more is compiled; so these are few
_QUANTITIES = ("x2", "a1")


def axis(random: Random) -> Layer:
    """An axis, mostly a good one."""
    paths = all_paths()
    known = {**paths.groups(), **paths.parameters}
    path = random.choice([path for path in known if path not in RUN])
    usual = known[path].default or 1.0
    match random.randrange(6):
        case 0 | 1:
            values = ",".join(number(random, usual) for _ in range(random.choice([1, 2, 3])))
        case 2:
            values = f"lin:{near(random, usual)}:{near(random, usual)}:{random.choice(('2', '3', *_COUNTS))}"
        case 3:
            values = f"log:{near(random, usual)}:{near(random, usual)}:{random.choice(('2', '3', *_COUNTS))}"
        case 4:
            values = f"{usual * 0.9!r},{usual * 1.1!r}"
        case _:
            values = random.choice(
                ("", ",", "1,,2", "lin:1:2", "log:0:1:3", "lin:2:1:3", "lin:1:2:3:4", "quad:1:2:3", ":")
            )
    return {"words": ["--over", f"{path}={values}"], **refused(values)}


def good_axis(random: Random) -> Layer:
    """An axis that is as it should be."""
    return {"words": ["--over", random.choice(("high_gain.eps_h=0.05,0.1", "plant.m=1,1.1", "noise.x1=lin:0:0.002:3"))]}


def good_option(random: Random) -> Layer:
    """Another option that is as it should be."""
    options = (
        ["--workers", "1"],
        ["--workers", "3"],
        ["--measure", "rmse"],
        ["--quantity", random.choice(_QUANTITIES)],
    )
    return {"words": random.choice(options)}


def option(random: Random) -> Layer:
    """Any other option of a sweep, good or bad."""
    words = random.choice(
        [
            ["--seeds", random.choice(_COUNTS)],
            ["--workers", random.choice(("0", "-1", "1", "3", "x", "1.5", "9" * 30))],
            ["--zip"],
            [
                "--design",
                random.choice(("latin:3", "sobol:4", "sobol:3", "latin:0", "latin:", "halton:3", "latin:1e9", ":")),
            ],
            ["--quantity", random.choice(("x9", "", "x2,a1", *NONE[:3]))],
            ["--quantity", random.choice(_QUANTITIES)],
            ["--measure", random.choice(("error", "", "rmse,peak", "\x1b"))],
            ["--target", random.choice(("nonsense", "", "arm64", "\x1b"))],
            [
                "--cluster",
                random.choice(("nonsense", "", "tls://", "tcp://127.0.0.1:1", "tcp://[", "file:///etc/passwd")),
            ],
            ["--observer", random.choice(("baseline", "high_gain", "kalman"))],
        ]
    )
    return {"words": words}


def out(random: Random) -> Layer:
    """Where the result goes, and what is there before."""
    name = random.choice(
        ("x.nc", "a/b/x.nc", "..", "", ".", "x", "x.nc/", "/", "/dev/null", "../other/x.nc", "r.nc.parts")
    )
    if random.random() < 0.5:
        return {"words": ["--out", name]}
    return {"words": ["--out", "x.nc"], **random.choice([odd_out(random, "x.nc"), parts(random)])}


def parts(random: Random) -> Layer:
    """A folder of parts that is not ours, or has things in it that are not."""
    folder = "x.nc.parts"
    files = random.choice(
        [
            {folder: {"link": "../other"}},
            {folder: {"link": "../home"}},
            {folder: {"text": "mine\n"}},
            {folder: {"pipe": True}},
            {f"{folder}/lock": {"link": "../../other/letter.txt"}},
            {f"{folder}/lock": {"hard": "../../other/letter.txt"}},
            {f"{folder}/lock": {"folder": True}},
            {f"{folder}/lock": {"pipe": True}},
            {f"{folder}/lock": {"text": "process 1 on \x1b[31m"}},
            {f"{folder}/mine.txt": {"text": "mine\n"}},
            {f"{folder}/.mine": {"text": "mine\n"}},
            {f"{folder}/mine/deep.txt": {"text": "mine\n"}},
            {f"{folder}/plan.json": {"text": "{}"}},
            {f"{folder}/plan.json": {"link": "../../other/letter.txt"}},
            {f"{folder}/plan.json": {"result": "sweep"}},
            {f"{folder}/00000000.part": {"text": "mine\n"}},
            {f"{folder}/00000000.part": {"link": "../../other/letter.txt"}},
            {f"{folder}/00000000.part": {"folder": True}},
            {f"{folder}/00000000.part": {"pipe": True}},
            {f"{folder}/00000000.part": {"result": "sweep"}},
            {folder: {"folder": True, "mode": 0o500}},
        ]
    )
    return {"files": files}
