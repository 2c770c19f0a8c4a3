"""Muscle files and tables of curves: good ones, and what may be wrong with them."""

from __future__ import annotations

from random import Random

from hostile.case import Layer
from hostile.draw.names import odd_kind, odd_name
from hostile.draw.numbers import number

FILE = "pair.toml"
_PAIR = {"mass": "20.0", "C": "0.62"}
_MUSCLE = {
    "curves": '"degroote_fregly2016"',
    "F_max": "1000.0",
    "optimal_fibre_length": "0.1",
    "tendon_slack_length": "0.2",
    "v_max": "10.0",
    "tendon_strain": "0.049",
    "passive_strain": "0.6",
    "damping": "0.0",
}
_OTHER = (
    '"nothing"',
    '"curves.csv"',
    '"estimates.csv"',
    '"../other/letter.txt"',
    "1",
    "true",
    '"a\\u001b[31m"',
    '"no.csv"',
)
_UNITS = ("", "", "%", "%", " N", "mm", "furlong")
_LINES = (
    *('description = "x\\u0000y"', 'description = "\\u001b[31m"', "description = 1", "x = 1", "[muscle3]\nF_max = 1"),
    *(
        "[muscle1]\nF_max = 900.0",
        "[muscle2]\nv_max = 8.0",
        "[muscle1]",
        "muscle1 = 1",
        "[muscle]",
        "a = [",
        "mass = 1",
    ),
)
_CURVES = """curve,x,y
tendon_force_length,1.0,0.0
tendon_force_length,1.01,0.05
tendon_force_length,1.03,0.5
tendon_force_length,1.05,1.2
passive_force_length,0.5,0.0
passive_force_length,1.0,0.0
passive_force_length,1.3,0.2
passive_force_length,1.7,1.2
active_force_length,0.5,0.1
active_force_length,0.8,0.8
active_force_length,1.0,1.0
active_force_length,1.2,0.8
active_force_length,1.6,0.1
force_velocity,-1.0,0.0
force_velocity,-0.5,0.3
force_velocity,0.0,1.0
force_velocity,0.5,1.3
force_velocity,1.0,1.4
"""


def muscles(random: Random) -> Layer:
    """A good file of two muscles."""
    return {"words": ["--muscles", FILE], "files": {FILE: {"text": _text(_PAIR, _MUSCLE)}}}


def shipped(random: Random) -> Layer:
    """The file of the shipped recording's two muscles."""
    return {"words": ["--muscles", FILE], "files": {FILE: {"shipped": "dgf_smooth.toml"}}}


def _text(pair: dict[str, str], muscle: dict[str, str], more: tuple[str, ...] = ()) -> str:
    lines = [f"{key} = {value}" for key, value in pair.items()]
    lines += ["[muscle]", *(f"{key} = {value}" for key, value in muscle.items())]
    return "\n".join([*more[:1], *lines, *more[1:]]) + "\n"


def changed(random: Random) -> Layer:
    """The file with numbers that are wrong, missing, or at an edge."""
    pair, muscle, given = dict(_PAIR), dict(_MUSCLE), {**_PAIR, **_MUSCLE}
    more: tuple[str, ...] = ()
    for _ in range(random.choice((1, 1, 2))):
        part = pair if random.random() < 0.3 else muscle
        key = random.choice(list(part))
        match random.random():
            case share if share < 0.1:
                del part[key]
            case share if share < 0.25:
                more = ("", random.choice(_LINES)) if random.random() < 0.5 else (random.choice(_LINES),)
            case _ if key == "curves":
                part[key] = random.choice(_OTHER)
            case share if share < 0.4:
                part[key] = f"{{ value = {given[key]}, sd = {_deviation(random, float(given[key]))} }}"
            case _:
                part[key] = number(random, float(given[key]))
    files = {FILE: {"text": _text(pair, muscle, more)}}
    if "estimates.csv" in muscle.get("curves", ""):
        # the user keeps curves where estimates are written, under a name that these have
        return {"words": ["--out", "."], "files": {**files, "estimates.csv": {"text": _CURVES}}}
    return {"files": files}


def doubt(random: Random) -> Layer:
    """How far a number may be off: some number, of some size, in some unit."""
    known = {**_PAIR, **{key: value for key, value in _MUSCLE.items() if key != "curves"}, "force_bias": "100"}
    name, value = random.choice(list(known.items()))
    prefix = random.choice(("", "", "muscle1.", "muscle3."))
    return {"words": ["--doubt", f"{prefix}{name}={number(random, 0.1 * float(value))}{random.choice(_UNITS)}"]}


def _deviation(random: Random, value: float) -> str:
    typed = number(random, 0.1 * value)
    return typed if random.random() < 0.5 else f'"{typed}{random.choice(_UNITS)}"'


def curves(random: Random) -> Layer:
    """Curves as a table, with something wrong in it now and then."""
    lines = _CURVES.splitlines()
    if random.random() < 0.9:
        at = random.randrange(1, len(lines))
        name, x, y = lines[at].split(",")
        lines[at] = random.choice(
            [
                f"{name},{number(random, float(x))},{y}",
                f"{name},{x},{number(random, float(y))}",
                "",
                f"{name},{x}",
                "#",
                "a,b,c",
            ]
        )
    muscle = {key: value for key, value in _MUSCLE.items() if "strain" not in key} | {"curves": '"curves.csv"'}
    return {"files": {FILE: {"text": _text(_PAIR, muscle)}, "curves.csv": {"text": "\n".join(lines) + "\n"}}}


def odd_file(random: Random) -> Layer:
    """The file under an odd name, or something else in its place."""
    return odd_name(random, FILE) if random.random() < 0.5 else odd_kind(random, FILE)
