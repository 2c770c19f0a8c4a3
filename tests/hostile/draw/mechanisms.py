"""Mechanisms: the shipped hinge, what may be wrong with its file, and scenarios of it."""

from __future__ import annotations

import re
from random import Random

from hostile.case import Layer
from hostile.draw.names import odd_kind, odd_name
from hostile.draw.numbers import number, refused
from hostile.draw.recordings import Table, table
from places import DATA, RECORDINGS

FILE = "hinge.toml"
RECORDING = DATA / "hinge_pair_noisy.csv.gz"
# what can follow a mechanism without another library
OBSERVERS = ("high_gain", "high_gain_3", "kalman_constant", "levant", "sliding_mode", "adaptive_sliding_mode")
_SHIPPED = "hinge_pair.toml"
_TEXT = (RECORDINGS / _SHIPPED).read_text()
_NUMBER = re.compile(r"(?<=[ \[=])-?[0-9]+(?:\.[0-9]+)?(?=[,\]\n])")
# a number of the muscles that what is compiled does not know
_LIGHT = ("tendon_strain", "passive_strain")
_NAMES = ("elbow", "BRA", "TRIlat", "r_humerus", "offset", "pin", "ground", "coefficients", "F_max", "links", "joints")
_WORDS = (
    *(
        "",
        "a b",
        "é",
        "\u202ex",
        "\x1b[31m",
        "a_",
        "x" * 40,
        "1",
        "elbow",
        "BRA",
        "ground",
        "slider",
        "weld",
        "ball",
        "a.b",
    ),
    *("mass", "q_hat", "L_S", "int"),
)
_LINES = (
    *(
        "[links.x]",
        "[joints.x]\nparent = 'ground'\nchild = 'ground'",
        "x = 1",
        "paths = 'no.xml'",
        "paths = 1",
        "[points.p]",
    ),
    *("[muscles.X]\nF_max = 1", "gravity = [0, 0]", "[muscles]", "a = [", "[points.hand]\nlink = 'x'\nat = [0, 0, 0]"),
    *(
        "[links.base.base]",
        "links = 1",
        "paths = '../other/letter.txt'",
        'description = "\\u001b[31m"',
        "[muscles.BRA]",
    ),
)
_SCENARIO = "h.toml"
_GOOD_LEAVES = ("", "reference.elbow.amplitude = 0.2", "initial.elbow.q = 1.2", "noise.force.muscle = 2e-3")
_LEAVES = (
    *_GOOD_LEAVES,
    *("reference.elbow.offset = 9", "initial.muscle.a = -1", "initial.elbow.q = 1e300", "noise.position.joint = 1"),
)
_MECHANISMS = (
    *("'no.toml'", "'nothing'", "1", "true", "''", "'\\u001b[31m'", "'../other/letter.txt'", "'h.toml'", "'.'", "[]"),
    *("'my.csv'", "'x.toml'", "{ a = 1 }", "'hinge_pair.toml'", "'dgf_smooth'", "'/dev/zero'"),
)
_CHOICES = (
    *(
        "plant.drive=nothing",
        "plant.drive=",
        "plant.drive=\x1b[31m",
        "controller.tracks=nothing",
        "controller.tracks=,",
    ),
    *("muscle1.curves=thelen2003", "mechanism=1", "mechanism=no.toml", "plant.elbow=1", "high_gain.wrist.eps_h=1"),
)


def mechanism(random: Random) -> Layer:
    """The hinge."""
    return {"words": ["--mechanism", FILE], "files": {FILE: {"shipped": _SHIPPED}}}


def rows(truth: bool) -> Table:
    """Samples of the hinge."""
    return table(truth, RECORDING)


def refused_file(random: Random) -> Layer:
    """The file with something that is refused at once, mostly; or with numbers that need no other library."""
    match random.randrange(5):
        case 0:
            key = random.choice(_LIGHT)
            line = f"{key} = {number(random, 0.05)}"
            return _file(re.sub(rf"{key} = .*", lambda _: line, _TEXT))
        case 1:
            found = random.choice(list(_NUMBER.finditer(_TEXT)))
            odd = random.choice(
                ("nan", "inf", "1e300", "-1e300", "true", "'1'", "[]", "1_0", "1" * 400, "2020-01-01", "")
            )
            return _file(_TEXT[: found.start()] + odd + _TEXT[found.end() :])
        case 2:
            return _file(_TEXT[: random.randrange(len(_TEXT) - 400)])
        case 3:
            line = random.choice(_LINES)
            return _file(random.choice((f"{line}\n{_TEXT}", f"{_TEXT}\n{line}\n")))
        case _:
            return odd_file(random)


def gain(random: Random) -> Layer:
    """A gain of an observer, by all or some of its names."""
    path = random.choice(("high_gain.eps_h", "high_gain.elbow.eps_h", "high_gain.BRA.eps_L", "high_gain.wrist.eps_h"))
    value = number(random, 0.1)
    return {"words": ["--set", f"{path}={value}"], **refused(value)}


def doubt(random: Random) -> Layer:
    """How far a number may be off."""
    name = random.choice(("F_max", "BRA.F_max", "pennation", "force_bias", "elbow.mass", "X.F_max", "mass", "\x1b"))
    return {"words": ["--doubt", f"{name}={number(random, 0.05)}{random.choice(('', '%', 'N', 'mm'))}"]}


def changed(random: Random) -> Layer:
    """The file with a number or a name that is another one, wrong or missing."""
    text = _TEXT
    match random.random():
        case share if share < 0.5:
            for _ in range(random.choice((1, 1, 2))):
                found = random.choice(list(_NUMBER.finditer(text)))
                text = text[: found.start()] + number(random, float(found[0])) + text[found.end() :]
        case share if share < 0.8:
            text = text.replace(random.choice(_NAMES), random.choice(_WORDS), random.choice((1, 1, 9)))
        case _:
            lines = text.splitlines(keepends=True)
            at = random.randrange(len(lines))
            lines[at : at + 1] = random.choice(([], [lines[at]] * 2))
            text = "".join(lines)
    return _file(text)


def odd_file(random: Random) -> Layer:
    """The file under an odd name, or something else in its place."""
    return random.choice((odd_kind, odd_name))(random, FILE)


def scenario(random: Random) -> Layer:
    """The shipped scenario of the hinge, or a file of it."""
    if random.random() < 0.6:
        return {"words": ["hinge"]}
    return _scenario(['base = "hinge"', random.choice(_GOOD_LEAVES)])


def change(random: Random) -> Layer:
    """A number of the scenario that is another one, or a choice that is none."""
    if random.random() < 0.3:
        return {"words": ["--set", random.choice(_CHOICES)]}
    path, usual = random.choice(
        (
            ("high_gain.eps_h", 0.1),
            ("high_gain.elbow.eps_h", 0.1),
            ("high_gain.BRA.eps_L", 0.1),
            ("initial.elbow.q", 1.2),
            ("initial.muscle.a", 0.2),
            ("reference.elbow.amplitude", 0.3),
            ("reference.elbow.frequency", 0.3),
            ("noise.force.muscle", 2e-3),
            ("noise.position.joint", 5e-4),
            ("uncertainty.elbow.amplitude", 0.1),
            ("controller.u_max", 0.9),
            ("BRA.F_max", 1.58),
            ("TRIlat.pennation", 0.157),
        )
    )
    value = number(random, usual)
    return {"words": ["--set", f"{path}={value}"], **refused(value)}


def document(random: Random) -> Layer:
    """A scenario of a mechanism with something wrong in it."""
    lines = ['base = "hinge"', random.choice(_LEAVES)] if random.random() < 0.5 else []
    lines.append(
        random.choice((f"mechanism = {random.choice(_MECHANISMS)}", random.choice(_LEAVES), "plant.drive = 'x'"))
    )
    return _scenario(lines)


def _scenario(lines: list[str]) -> Layer:
    text = "\n".join([*lines, "duration = 0.2", "score.start = 0.04", ""])
    return {"words": [_SCENARIO], "files": {_SCENARIO: {"text": text}}}


def _file(text: str) -> Layer:
    return {"files": {FILE: {"text": text}}}
