"""A case from a seed and its number: a good command first, then what is wrong with it, a layer each."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

from hostile.case import FRESH, Layer
from hostile.draw import drawings, muscles, points, programs, recordings, scenarios, surroundings, sweeps
from hostile.draw.names import odd_out
from hostile.draw.numbers import refused

Draw = Callable[[Random], Layer]
# figures take seconds
_FIGURES = 0.04


def draw(seed: int, number: int) -> list[Layer]:
    """The layers of a case; the same for the same seed and number."""
    random = Random(f"{seed}, {number}")
    (kind,) = random.choices(list(_KINDS), weights=[weight for weight, _ in _KINDS.values()])
    layers = _KINDS[kind][1](random)
    # what libraries raise in Python when they get no memory and no files is for the caller
    limits = surroundings.streams if kind == "programs" else surroundings.limits
    return [*layers, *_around(random, number % FRESH == 0, limits)]


def _around(random: Random, fresh: bool, limits: Draw) -> list[Layer]:
    """Surroundings: some cases meet signals, limits, odd streams; each fresh one those, or an odd environment."""
    if fresh:
        odd = random.choice((surroundings.environment, surroundings.environment, _fresh_signal, limits))
        return [{**odd(random), "fresh": True}]
    share = random.random()
    if share < 0.06:
        return [surroundings.signals(random, fresh=False)]
    if share < 0.1:
        return [{**limits(random), "fresh": False}]
    return [{**surroundings.streams(random), "fresh": False}] if share < 0.13 else []


def _fresh_signal(random: Random) -> Layer:
    return surroundings.signals(random, fresh=True)


def _some(random: Random, draws: list[Draw], most: int = 3) -> list[Layer]:
    """None to some of what may be wrong; one most often."""
    count = random.choices(range(most + 1), weights=[15, 50, 25, 10][: most + 1])[0]
    return [random.choice(draws)(random) for _ in range(count)]


def _figures(random: Random) -> list[Layer]:
    return [] if random.random() < _FIGURES else [{"words": ["--no-figures"]}]


def _out(name: str) -> Draw:
    """Something in the way of the folder `name`."""

    def drawn(random: Random) -> Layer:
        return {"words": ["--out", name], **odd_out(random, name)}

    return drawn


def _simulate(random: Random) -> list[Layer]:
    base: list[Layer] = [{"words": ["simulate"]}, scenarios.short_run(random), *_figures(random)]
    odd = [scenarios.change, scenarios.change, scenarios.change, scenarios.document, scenarios.observers]
    last = random.choices([scenarios.scenario, scenarios.odd_file], weights=[9, 1])[0](random)
    return [*base, *_some(random, [*odd, _out("out")]), last]


def _sweep(random: Random) -> list[Layer]:
    base: list[Layer] = [
        {"words": ["sweep"]},
        scenarios.short_run(random),
        *_figures(random),
        {"words": ["--seeds", "2"]},
    ]
    base += [sweeps.good_axis(random)] if random.random() < 0.5 else []
    base += [{"words": ["--out", "x.nc"]}] if random.random() < 0.6 else []
    odd = [
        sweeps.axis,
        sweeps.axis,
        sweeps.axis,
        scenarios.change,
        sweeps.option,
        sweeps.option,
        sweeps.out,
        sweeps.out,
    ]
    return [*base, *_some(random, odd), scenarios.scenario(random)]


def _estimate(random: Random) -> list[Layer]:
    base: list[Layer] = [
        {"words": ["estimate"]},
        recordings.recording(random),
        muscles.muscles(random),
        *_figures(random),
    ]
    name = base[1]["words"][0]

    def damaged(random: Random) -> Layer:
        return recordings.damaged(random, name)

    def other(random: Random) -> Layer:
        return recordings.odd_recording(random, name)

    def gain(random: Random) -> Layer:
        path, value = scenarios.gain(random)
        return {"words": ["--set", f"{path}={value}"], **refused(value)}

    odd = [
        damaged,
        damaged,
        damaged,
        other,
        recordings.mapping,
        muscles.changed,
        muscles.changed,
        muscles.odd_file,
        muscles.doubt,
        gain,
    ]
    return [*base, *_some(random, [*odd, gain, muscles.curves, scenarios.observers, _out("out")])]


def _observability(random: Random) -> list[Layer]:
    extent = [points.extent(random)] if random.random() < 0.1 else []
    return [
        {"words": ["observability"]},
        *_some(random, [points.option, points.option, scenarios.change]),
        *extent,
        scenarios.scenario(random),
    ]


def _drawings(random: Random) -> list[Layer]:
    out = {"words": ["--out", "out"]}
    return [{"words": ["figures"]}, out, drawings.drawing(random), *_some(random, [drawings.odd_file, _out("out")], 1)]


def _rest(random: Random) -> list[Layer]:
    words = random.choice(_REST).split()
    # nobody empties the cache that all cases share, or prints what others have left there
    own = [{"environment": {"HILLOBS_CACHE": "BOX/cache"}}] if words and words[0] in ("clean", "info") else []
    return [{"words": words}, *own]


# complete commands that read nothing of the user's, and incomplete ones
_REST = (
    *(
        "",
        "--help",
        "--version",
        "list",
        "list parameters",
        "info",
        "info --source",
        "clean",
        "curves",
        "curves --out x",
    ),
    *(
        "show slack",
        "show nothing",
        "-h x",
        "nonsense",
        "simulate --no-such",
        "estimate",
        "estimate --help",
        "sweep --over",
    ),
    *("list \x1b", "show \x1b[31m", "\udcff", "list all all", "errata x", "sweep -h", "--", "simulate --"),
)


def _show(random: Random) -> list[Layer]:
    return [{"words": ["show"]}, random.choice((scenarios.document, scenarios.odd_file, scenarios.scenario))(random)]


def _program(random: Random) -> list[Layer]:
    return [random.choices((programs.program, programs.reading), weights=[3, 1])[0](random)]


_KINDS: dict[str, tuple[int, Callable[[Random], list[Layer]]]] = {
    "simulate": (22, _simulate),
    "sweep": (24, _sweep),
    "estimate": (22, _estimate),
    "observability": (9, _observability),
    "drawings": (6, _drawings),
    "show": (3, _show),
    "rest": (4, _rest),
    "programs": (10, _program),
}
