"""Programs that use the façade: values of wrong types and sizes, files that are none."""

from __future__ import annotations

from random import Random

from hillobs.studies.scenarios.loops import all_paths
from hillobs.studies.scenarios.paths import RUN
from hostile.case import Layer
from hostile.draw import muscles, recordings
from hostile.draw.drawings import FILE as RESULT
from hostile.draw.drawings import damage
from hostile.draw.names import odd_kind
from hostile.draw.numbers import near

# what is no number, or none that a parameter may have
_NO_NUMBER = (
    *('"0.1"', "True", "None", "[]", "{}", 'float("nan")', 'float("inf")', "10**400", "1j", 'b"1"', "object()", "type"),
    *("np.array([1.0, 2.0])", "np.array([])", "np.array(['0.1'])", "np.bool_(True)", "np.datetime64('2020-01-01')"),
    *("np.timedelta64(1)", "np.ma.masked", "lambda: 1.0", "[1.0]", "np.float64('nan')", "np.array(1j)"),
)
# what is no list of numbers for an axis, or too long a one
_NO_AXIS = (
    *(
        '"0.1"',
        "True",
        "None",
        "[]",
        "[True]",
        '["0.1"]',
        "[[1.0]]",
        "(1.0, None)",
        "{1.0: 2.0}",
        "lambda: 1.0",
        "object()",
    ),
    *("np.array([])", "np.array(['0.1'])", "np.array([True])", "np.array([np.datetime64('2020')])", "np.array([1j])"),
    *(
        "Range(0.1, 0.2, 10**9)",
        "Range(0.1, 0.2, 10**30)",
        "Range('a', 'b', 3)",
        "Range(0.1, 0.2, 2.5)",
        "np.zeros(2_000_000)",
    ),
    *(
        "Range(0.1, 0.2, -1)",
        "Range(0.1, 0.2, True)",
        "Range(0.1, 0.2, None)",
        "Range(float('nan'), 1, 3)",
        "[float('nan')]",
    ),
    *("[1e400]", "[10**400]", "['nan']", "[None]", "np.datetime64('2020-01-01')", "[0.1, 0.1]", "Range(0.2, 0.1, 3)"),
)
# numbers of other types, which are as good as a float
_NUMBER = (
    "np.float32(0.25)",
    "np.float64(0.1)",
    "np.int8(1)",
    "Fraction(1, 4)",
    "1",
    "np.array(0.25)",
    "-0.0",
    "1e-300",
)
_NO_WHOLE = (
    '"1"',
    "True",
    "1.5",
    "-1",
    "10**30",
    "[]",
    "np.float64(2)",
    "float('nan')",
    "object()",
    "{}",
    "1j",
)
_NO_NAME = ("'nothing'", "''", "'\\x00'", "'\\ud800'", "Path('x')", "'x' * 3000", "'\\x1b[31m'")
_HEAD = """import numpy as np
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from hillobs import Range
S = {"duration": 0.2, "score.start": 0.04}
"""


_FOLLOWER = """G = {{"high_gain.eps_h": 0.2, "high_gain.eps_L": 0.05}}
F = hillobs.follow('pair.toml', 'high_gain', period=0.005, gains=G)
F.step(0.31, 380.0, 380.0)
S = F.state()
{rest}
"""
_STEP = """try:
    result = {call}
except hillobs.Error as error:
    assert F.state() == S, "a sample that is refused has changed the follower"
    raise
F = hillobs.follow('pair.toml', 'high_gain', state=F.state())
result = [result, F.step(0.31, 380.0, 380.0)]
assert F.gains == G"""


def program(random: Random) -> Layer:
    """A call of the façade with one argument that is odd, and what becomes of it where that is certain."""
    path = random.choice([path for path in all_paths().parameters if path not in RUN])
    no_number, no_axis, no_whole = random.choice(_NO_NUMBER), random.choice(_NO_AXIS), random.choice(_NO_WHOLE)
    value = random.choice((*_NUMBER, near(random, all_paths().parameters[path].default)))
    no_name = random.choice(_NO_NAME)
    seeds = random.choice(("0", "-1", "[]", "[0, 0]", "range(2)", "10**12"))
    axis = "{'plant.m': [1.0, 1.1]}"
    refused = [
        f"hillobs.simulate('paper-noisy', changes={{**S, {path!r}: {no_number}}})",
        f"hillobs.simulate({no_name}, changes=S)",
        f"hillobs.simulate('paper-noisy', [{no_name}], S)",
        f"hillobs.simulate('paper-noisy', changes={{**S, {no_name}: 1.0}})",
        f"hillobs.simulate('paper-noisy', changes={{**S, 'seed': {no_whole}}})",
        *[f"hillobs.sweep('paper-noisy', {{{path!r}: {no_axis}}}, 1, changes=S)"] * 5,
        f"hillobs.sweep('paper-noisy', {{{no_name}: [1.0]}}, 1, changes=S)",
        f"hillobs.sweep('paper-noisy', {axis}, [0, {no_whole}], changes=S)",
        f"hillobs.sweep('paper-noisy', {{'plant.m': Range(1, 2)}}, 1, changes=S, kind='latin', samples={no_whole})",
        f"hillobs.sweep('paper-noisy', {axis}, 1, changes=S, kind={no_name})",
        f"hillobs.sweep('paper-noisy', {axis}, 1, changes=S, quantities=[{no_name}])",
        f"hillobs.sweep('paper-noisy', {axis}, 1, changes=S, measures=[{no_name}])",
        f"hillobs.sweep('paper-noisy', {axis}, 1, changes=S, target={no_name})",
        f"hillobs.observability(place={{'x3': {no_number}}})",
        f"hillobs.observability(place={{{no_name}: 1.0}})",
        f"hillobs.observability(sensors=[{no_name}])",
        f"hillobs.observability(unknown={no_name})",
        f"hillobs.load({no_name})",
        f"hillobs.read_recording({no_name})",
        f"hillobs.read_muscles({no_name})",
    ]
    tried = [
        f"hillobs.simulate('paper-noisy', changes={{**S, {path!r}: {value}}})",
        f"hillobs.sweep('paper-noisy', {{{path!r}: [{value}]}}, 1, changes=S)",
        f"hillobs.sweep('paper-noisy', {axis}, {seeds}, changes=S)",
        f"hillobs.observability(place={{'x3': {value}}})",
    ]
    if random.random() < 0.5:
        return {"python": f"{_HEAD}result = {random.choice(refused)}\n", "code": 2}
    return {"python": f"{_HEAD}result = {random.choice(tried)}\n"}


def following(random: Random) -> Layer:
    """A follower and its samples, with one thing that is odd; whatever a sample is, a refused one changes nothing."""
    no_number, number = random.choice(_NO_NUMBER), random.choice((*_NUMBER, near(random, 0.3)))
    no_name, no_whole = random.choice(_NO_NAME), random.choice(_NO_WHOLE)
    odd = random.choice((no_number, number, no_name))
    no_state = random.choice((*(value for value in _NO_NUMBER if value != "None"), "S[:-1]", "bytearray(S)", "''"))
    good = "pair.toml", "'high_gain'", "period=0.005", "gains=G"
    pair, observer, period, gains = good[0], *good[1:]
    calls = [
        f"hillobs.follow({no_name}, {observer}, {period}, {gains})",
        f"hillobs.follow('{pair}', {random.choice((*_NO_NUMBER, no_name))}, {period}, {gains})",
        f"hillobs.follow('{pair}', {observer}, period={no_number}, {gains})",
        f"hillobs.follow('{pair}', {observer}, {period}, gains={{'high_gain.eps_h': {no_number}}})",
        f"hillobs.follow('{pair}', {observer}, {period}, gains={{{no_name}: 0.1}})",
        f"hillobs.follow('{pair}', {observer}, {period}, gains={random.choice(_NO_WHOLE)})",
        f"hillobs.follow('{pair}', {observer}, {period}, {gains}, corrected={no_whole})",
        f"hillobs.follow('{pair}', {observer}, {period}, {gains}, learning={no_number})",
        f"hillobs.follow('{pair}', {observer}, state={no_state})",
        f"hillobs.follow('{pair}', 'sliding_mode', state=S)",
        f"hillobs.follow('{pair}', {observer}, state=S, {period})",
    ]
    steps = [
        f"F.step({odd}, 380.0, 380.0)",
        f"F.step(0.31, 380.0, {odd})",
        f"F.step(0.31, 380.0, 380.0, time={odd})",
        f"F.step({odd})",
        "F.step()",
        f"F.step(0.31, 380.0, 380.0, {odd})",
        f"F.step([0.31], {odd})",
        f"F.step(position=0.31, force_1={odd}, force_2=380.0)",
        f"F.step(0.31, 380.0, force_2={odd})",
        f"F.step(**{{{no_name if no_name.startswith(chr(39)) else repr('x')}: {odd}}})",
    ]
    files = muscles.shipped(random)["files"]
    if random.random() < 0.5:
        text = _FOLLOWER.format(rest=f"result = {random.choice(calls)}")
        return {"python": f"{_HEAD}{text}", "files": files, "code": 2}
    return {"python": f"{_HEAD}{_FOLLOWER.format(rest=_STEP.format(call=random.choice(steps)))}", "files": files}


def reading(random: Random) -> Layer:
    """A call that reads files, which may be odd; or one with an odd argument beside good files."""
    layer = random.choice((damage, recordings.recording, muscles.muscles))(random)
    (name, entry), *_ = layer["files"].items()
    files = {name: entry}
    if random.random() < 0.2:
        files |= odd_kind(random, name)["files"]
    if name == RESULT:
        return {"python": f"{_HEAD}result = hillobs.load({name!r})\n", "files": files}
    if name == muscles.FILE:
        return {"python": f"{_HEAD}hillobs.read_muscles({name!r})\n", "files": files}
    files |= muscles.muscles(random)["files"]
    arguments = [
        ("keep_every", random.choice(_NO_WHOLE)),
        ("observers", f"[{random.choice(_NO_NAME)}]"),
        ("mapping", f"{{'position': {random.choice(_NO_NAME)}}}"),
        ("mapping", f"{{{random.choice(_NO_NAME)}: 'time'}}"),
        ("changes", f"{{'high_gain.eps_h': {random.choice(_NO_NUMBER)}}}"),
        ("changes", "{}"),
        ("corrected", "False"),
    ]
    argument, odd = random.choice(arguments)
    call = f"hillobs.estimate({name!r}, {muscles.FILE!r}, **{{{argument!r}: {odd}}})"
    return {"python": f"{_HEAD}result = {call}\n", "files": files}
