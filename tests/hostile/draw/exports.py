"""Exports of observers: registered ones and Blocks of a user's, how often they are given samples, and numbers."""

from __future__ import annotations

from random import Random

from hostile.case import Layer
from hostile.draw.names import odd_kind, odd_name, odd_out
from hostile.draw.numbers import near, number
from hostile.draw.scenarios import gain

_OUT, _FILE, PAGE = "c", "own.py", "x.html"
OBSERVERS = (
    *("high_gain", "high_gain_3", "sliding_mode", "adaptive_sliding_mode", "kalman_constant", "kalman", "levant"),
    f"{_FILE}:block",
)
# a Block that goes to what is measured; each piece in capitals may be another one
_BLOCK = """import casadi as ca
from hillobs import Block, Parameter, Symbols, symbols

x = symbols(["x1_hat", "x2_hat", "Delta_hat", "x3_hat", "u1_hat", "x4_hat", "u2_hat", STATE])
u = symbols("y1 L_S1 L_S2")
about = {PARAMETER: Parameter(DEFAULT, SENTENCE, "a test", UNIT)}
p = symbols(about)
seen = dict(x1_hat=u.y1, x3_hat=u.L_S1, x4_hat=u.L_S2)
dx = Symbols({name: p[PARAMETER] * (seen.get(name, 0) - state) + MORE for name, state in x.items()})
block = Block(NAME, x=x, u=u, p=p, parameters=about, dx=dx, x0=START, y=OUTPUTS)
"""
_GOOD = {
    "STATE": "'inner'",
    "PARAMETER": "'rate'",
    "DEFAULT": "5.0",
    "SENTENCE": "'how fast'",
    "UNIT": "'1'",
    "MORE": "0",
    "NAME": "'own'",
    "START": "seen",
    "OUTPUTS": "x",
}
# what C, its libraries and what is exported around it call something, and what is no name at all
_NAMES = (
    *("int", "double", "class", "errno", "NULL", "NAN", "main", "state", "step", "real", "x1_hat", "a.b", "a_b", "_a"),
    *(
        "",
        "1",
        "a b",
        "a-b",
        "a;b",
        "ü",
        "\x1b",
        "*/",
        "x" * 300,
        "I",
        "casadi_real",
        "M_PI",
        "y1",
        "t",
        "h",
        "a__b",
        "a_",
    ),
)
_WORDS = (
    "*/",
    "/*",
    "*/ int x; /*",
    "\\",
    "??/",
    "\n",
    "\x1b[31m",
    "%s",
    "${name}",
    "é",
    "x" * 3000,
    "",
    "\0",
    "//",
    '"',
)
_EXPRESSIONS = (
    *(
        "float('nan')",
        "float('inf')",
        "-float('inf')",
        "1e308 * 10",
        "5e-324",
        "2**70",
        "0.1 + 1j",
        "None",
        "'1'",
        "[1, 2]",
    ),
    *("ca.log(state)", "ca.sqrt(state)", "ca.fmod(state, 2)", "ca.atan2(state, u.y1)", "ca.erf(state)", "1 / state"),
    *("ca.if_else(state > 0, 1, -1)", "state**p[next(iter(p))]", "ca.SX.sym('z')", "ca.sign(state) * ca.floor(state)"),
    *("sum(ca.sin(k * state) for k in range(300))", "ca.hypot(state, 1)", "ca.log1p(state)", "ca.copysign(1, state)"),
)
_FILES = (
    *(
        "",
        "block",
        "block = 1",
        "block = lambda: 1 / 0",
        "raise SystemExit(3)",
        "import nothing",
        "1 +",
        "\0",
        "\udcff",
    ),
    *("def block(): return block()", "raise KeyboardInterrupt", "x = " + "(" * 300, "raise Exception('\x1b[31m')"),
    *("from own import block", "block = type('Block', (), {})()", "block = float", "raise BaseException", "\ufeffx"),
)


def export(random: Random, observers: tuple[str, ...] = OBSERVERS) -> Layer:
    """An observer, as good as it comes."""
    words = ["--observer", random.choice(observers), "--period", "0.005", "--out", _OUT]
    return {"words": words, "files": {_FILE: {"text": _block({})}}}


def good_option(random: Random, target: str) -> Layer:
    """Another option that is as it should be."""
    real = ["--float"] if target == "c" else []
    return {"words": random.choice((real, ["--uncorrected"], ["--period", "0.004"], ["--period", "1e-3"]))}


def whole(random: Random) -> Layer:
    """A scenario as a page, or its plant alone."""
    return {"words": random.choice((["export", "page", "--out", PAGE], ["export", "plant", "--out", _OUT]))}


def of_scenario(random: Random) -> Layer:
    """Numbers of a scenario."""
    return {"words": random.choice(([], ["--scenario", "paper-noisy"], ["--scenario", "slack"]))}


def option(random: Random) -> Layer:
    """Any option, good or bad."""
    path, value = gain(random)
    words = random.choice(
        [
            ["--set", f"{path}={value}"],
            ["--set", f"{path}={value}", "--float"],
            ["--set", random.choice(("", "=", "x", "=1", "high_gain=1", "no.toml", "my.csv", "\x1b=1"))],
            ["--period", number(random, 0.005)],
            ["--period", number(random, 0.005)],
            ["--substeps", random.choice(("0", "-1", "1", "2", "5", "50", "1e3", "x", "999999999", "1_0", "9" * 400))],
            ["--scenario", random.choice(("nothing", "hinge", "", "my.csv", ".", "no.toml", "\x1b"))],
            [
                "--observer",
                random.choice(("baseline", "truth", "", "nothing", "\x1b[31m", "own.py:", ":x", "own.py:nothing")),
            ],
        ]
    )
    return {"words": words}


def out(random: Random) -> Layer:
    """Where the files go, and what is there before."""
    match random.randrange(3):
        case 0:
            return odd_out(random, _OUT)
        case 1:
            layer = odd_out(random, name := f"{_OUT}/{random.choice(('main.c', 'README.md', 'high_gain.h'))}")
            return layer if "link" in layer["files"][name] else {"files": {name: {"text": "mine\n"}}}
        case _:
            names = (
                "a/b/c",
                "..",
                "",
                ".",
                "/",
                "/dev/null",
                "../other",
                "my.csv",
                "\x1b[31m",
                "n" * 300,
                "$(touch made)",
            )
            return {"words": ["--out", random.choice(names)]}


def block(random: Random) -> Layer:
    """A Block with something odd in it, or a file that has none."""
    if random.random() < 0.3:
        text = random.choice(_FILES)
    else:
        piece = random.choice(list(_GOOD))
        text = _block({piece: _odd(random, piece)})
    words = ["--observer", f"{_FILE}:block"]
    if random.random() < 0.1:
        return {"words": words, **random.choice((odd_kind, odd_name))(random, _FILE)}
    return {"words": words, "files": {_FILE: {"text": text}}}


def _odd(random: Random, piece: str) -> str:
    match piece:
        case "NAME" | "STATE" | "PARAMETER":
            return repr(random.choice(_NAMES))
        case "SENTENCE" | "UNIT":
            return repr(random.choice(_WORDS))
        case "MORE":
            return random.choice(_EXPRESSIONS)
        case "DEFAULT":
            return random.choice(
                (near(random, 5.0), "1e39", "1e-46", "1e400", "float('nan')", "10**400", "True", "'5'")
            )
        case "START":
            return random.choice(
                ("{}", "None", "{'x1_hat': 1}", "{'x9': 1}", "{'x1_hat': float('nan')}", "{'x1_hat': x.x2_hat}")
            )
        case _:
            odd = (
                "{}",
                "Symbols(x1_hat=1.0)",
                "{**x, 'a.b': 1, 'a_b': 2}",
                "{**x, 'y1': x.x1_hat}",
                "{**x, 'x1_hat': 1e300}",
            )
            return random.choice(odd)


def _block(pieces: dict[str, str]) -> str:
    text = _BLOCK
    for piece, good in _GOOD.items():
        text = text.replace(piece, pieces.get(piece, good))
    return text
