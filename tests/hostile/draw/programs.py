"""Programs that use the façade: values of wrong types and sizes, files that are none."""

from __future__ import annotations

from random import Random

from hillobs.studies.scenarios.loops import all_paths
from hostile.case import Layer
from hostile.draw import muscles, recordings
from hostile.draw.drawings import FILE as RESULT
from hostile.draw.drawings import drawing
from hostile.draw.names import odd_kind
from hostile.draw.numbers import near

_ODD = (
    *('"0.1"', "True", "None", "[]", "{}", 'float("nan")', 'float("inf")', "10**400", "-0.0", "1j", 'b"1"', "object()"),
    *("[True]", '["0.1"]', "[[1.0]]", "(1.0, None)", "range(3)", "{1.0, 2.0}", "iter([1.0])", "lambda: 1.0", "type"),
    *(
        "np.float32(0.1)",
        "np.array([1.0, 2.0])",
        "np.array(1.0)",
        "np.array([])",
        "np.array(['0.1'])",
        "np.bool_(True)",
    ),
    *("np.datetime64('2020-01-01')", "np.array([np.datetime64('2020')])", "np.timedelta64(1)", "np.array([1j])"),
    *(
        "np.ma.masked",
        "Fraction(1, 10)",
        "Decimal('0.1')",
        "Range(0.1, 0.2, 10**9)",
        "Range(0.1, 0.2, 10**30)",
        "Range(1, 1, 3)",
    ),
    *(
        "Range('a', 'b', 3)",
        "Range(0.1, 0.2, 2.5)",
        "Range(0.1, 0.2, -1)",
        "Range(0.1, 0.2, True)",
        "Range(0.1, 0.2, None)",
    ),
    *(
        "Range(float('nan'), 1, 3)",
        "np.zeros(2_000_000)",
        "'\\x00'",
        "'\\ud800'",
        "''",
        "Path('x')",
        "[float('nan')]",
        "[1e400]",
    ),
)
_HEAD = """import numpy as np
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from hillobs import Range
S = {"duration": 0.2, "score.start": 0.04}
"""


def program(random: Random) -> Layer:
    """A call of the façade with one argument that is odd, or none."""
    odd = random.choice(_ODD)
    path = random.choice(list(all_paths().parameters))
    value = random.choice((odd, odd, near(random, all_paths().parameters[path].default)))
    calls = [
        f"hillobs.simulate('paper-noisy', changes={{**S, {path!r}: {value}}})",
        f"hillobs.simulate('paper-noisy', changes={{**S, {odd}: 1.0}})"
        if "[" not in odd and "{" not in odd
        else "None",
        f"hillobs.simulate({odd}, changes=S)",
        f"hillobs.simulate('paper-noisy', {odd}, S)",
        f"hillobs.simulate('paper-noisy', changes={odd})",
        f"hillobs.sweep('paper-noisy', {{'high_gain.eps_h': {odd}}}, 2, changes=S)",
        f"hillobs.sweep('paper-noisy', {{'plant.m': {odd}}}, 1, ['high_gain'], S)",
        f"hillobs.sweep('paper-noisy', {{{path!r}: {value}}}, 1, changes=S)",
        f"hillobs.sweep('paper-noisy', {odd}, 1, changes=S)",
        f"hillobs.sweep('paper-noisy', {{'plant.m': [1.0, 1.1]}}, {odd}, changes=S)",
        f"hillobs.sweep('paper-noisy', {{'plant.m': [1.0, 1.1]}}, [0, {odd}], changes=S)",
        f"hillobs.sweep('paper-noisy', {{'plant.m': Range(1, 2)}}, 1, changes=S, kind='latin', samples={odd})",
        f"hillobs.sweep('paper-noisy', {{'plant.m': [1.0]}}, 1, changes=S, kind={odd})",
        f"hillobs.sweep('paper-noisy', {{'plant.m': [1.0]}}, 1, changes=S, quantities={odd})",
        f"hillobs.sweep('paper-noisy', {{'plant.m': [1.0]}}, 1, changes=S, measures={odd})",
        f"hillobs.sweep('paper-noisy', {{'plant.m': [1.0]}}, 1, changes=S, workers={odd})",
        f"hillobs.sweep('paper-noisy', {{'plant.m': [1.0]}}, 1, changes=S, target={odd})",
        f"hillobs.sweep('paper-noisy', {{'plant.m': [1.0]}}, 1, changes=S, out={odd})",
        f"hillobs.observability(place={{'x3': {odd}}})",
        f"hillobs.observability(place={odd})",
        f"hillobs.observability(sensors={odd})",
        f"hillobs.observability(unknown={odd})",
        f"hillobs.observability(order={odd})",
        f"hillobs.load({odd})",
        f"hillobs.read_recording({odd})",
        f"hillobs.read_muscles({odd})",
        f"hillobs.conformance({odd})",
    ]
    return {"python": f"{_HEAD}result = {random.choice(calls)}\n"}


def reading(random: Random) -> Layer:
    """A call that reads files, which may be odd; or one with an odd argument beside good files."""
    layer = random.choice((drawing, recordings.recording, muscles.muscles))(random)
    (name, entry), *_ = layer["files"].items()
    files = {name: entry}
    if random.random() < 0.2:
        files |= odd_kind(random, name)["files"]
    if name == RESULT:
        return {"python": f"{_HEAD}result = hillobs.load({name!r})\n", "files": files}
    if name == muscles.FILE:
        return {"python": f"{_HEAD}hillobs.read_muscles({name!r})\n", "files": files}
    files |= muscles.muscles(random)["files"]
    argument = random.choice(("observers", "mapping", "corrected", "changes", "keep_every"))
    odd = random.choice(_ODD)
    call = f"hillobs.estimate({name!r}, {muscles.FILE!r}, **{{{argument!r}: {odd}}})"
    return {"python": f"{_HEAD}result = {call}\n", "files": files}
