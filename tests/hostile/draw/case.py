"""A case from a seed and its number: a good command first, then what is wrong with it or odd about it, a layer each."""

from __future__ import annotations

from collections.abc import Callable
from random import Random

from hostile.case import FRESH, Layer
from hostile.draw import (
    drawings,
    exports,
    mechanisms,
    models,
    muscles,
    points,
    programs,
    recordings,
    samples,
    scenarios,
    searches,
    states,
    surroundings,
    sweeps,
    trials,
)
from hostile.draw.names import odd_out
from hostile.draw.numbers import refused
from places import RECORDINGS

Draw = Callable[[Random], Layer]
# a good command, and what is wrong with it
Drawn = tuple[list[Layer], list[Layer]]
# figures take seconds
_FIGURES = 0.02
# shares of the good commands, and of the others, that meet something odd around them
_AROUND_GOOD, _AROUND_OTHERS = 0.5, 0.13


def draw(seed: int, number: int) -> list[Layer]:
    """The layers of a case; the same for the same seed and number."""
    random = Random(f"{seed}, {number}")
    (kind,) = random.choices(list(_KINDS), weights=[weight for weight, _ in _KINDS.values()])
    base, mistakes = _KINDS[kind][1](random)
    good = kind in _COMMANDS and not mistakes
    around = _around(random, number % FRESH == 0, kind, _AROUND_GOOD if good else _AROUND_OTHERS)
    return [*base, *mistakes, *(around or ([{"code": 0}] if good else []))]


def _around(random: Random, fresh: bool, kind: str, share: float) -> list[Layer]:
    """Surroundings: a share of the cases meets signals, limits, odd streams; each fresh one, or an odd environment."""
    # what Python says of a signal, and libraries without memory and files, is for the caller of the façade
    if kind == "programs":
        odd = (surroundings.environment_of_programs,) if fresh else (surroundings.streams,)
    elif fresh:
        odd = (surroundings.environment, surroundings.environment, _fresh_signal, surroundings.limits)
    else:
        odd = (*[_signal] * 6, *[surroundings.limits] * 4, *[surroundings.streams] * 3)
    return [{**random.choice(odd)(random), "fresh": fresh}] if fresh or random.random() < share else []


def _signal(random: Random) -> Layer:
    return surroundings.signals(random, fresh=False)


def _fresh_signal(random: Random) -> Layer:
    return surroundings.signals(random, fresh=True)


def _some(random: Random, draws: list[Draw], most: int = 3) -> list[Layer]:
    """Some of what may be wrong; nothing in half of the cases, else one thing most often."""
    count = random.choices(range(most + 1), weights=[50, 35, 10, 5][: most + 1])[0]
    return [random.choice(draws)(random) for _ in range(count)]


def _figures(random: Random) -> list[Layer]:
    return [] if random.random() < _FIGURES else [{"words": ["--no-figures"]}]


def _out(name: str) -> Draw:
    """Something in the way of the folder `name`."""

    def drawn(random: Random) -> Layer:
        return {"words": ["--out", name], **odd_out(random, name)}

    return drawn


def _simulate(random: Random) -> Drawn:
    base: list[Layer] = [{"words": ["simulate"]}, scenarios.short_run(random), *_figures(random)]
    base += [scenarios.slight_change(random)] if random.random() < 0.5 else []
    base += [scenarios.good_observers(random)] if random.random() < 0.5 else []
    mistakes = _some(random, [scenarios.change, scenarios.change, scenarios.observers, _out("out")])
    if random.random() < 0.85:
        return [*base, scenarios.scenario(random)], mistakes
    # last, since names that begin with a dash come after `--`
    return base, [*mistakes, random.choice((scenarios.document, scenarios.document, scenarios.odd_file))(random)]


def _sweep(random: Random) -> Drawn:
    base: list[Layer] = [
        {"words": ["sweep"]},
        scenarios.short_run(random),
        *_figures(random),
        {"words": ["--seeds", "2"]},
        scenarios.scenario(random),
    ]
    base += [sweeps.good_axis(random)] if random.random() < 0.5 else []
    base += [sweeps.good_option(random)] if random.random() < 0.5 else []
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
    return base, _some(random, odd)


def _estimate(random: Random) -> Drawn:
    base: list[Layer] = [
        {"words": ["estimate"]},
        recordings.recording(random),
        muscles.muscles(random),
        *_figures(random),
    ]
    base += [scenarios.good_observers(random)] if random.random() < 0.5 else []
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
    return base, _some(random, [*odd, gain, muscles.curves, scenarios.observers, _out("out")])


def _mechanism_estimate(random: Random) -> Drawn:
    base: list[Layer] = [
        {"words": ["estimate"]},
        recordings.recording(random, mechanisms.RECORDING),
        mechanisms.mechanism(random),
        *_figures(random),
        scenarios.named(random.sample(mechanisms.OBSERVERS, random.choice((1, 2)))),
    ]
    name = base[1]["words"][0]

    def damaged(random: Random) -> Layer:
        return recordings.damaged(random, name, mechanisms.RECORDING)

    def other(random: Random) -> Layer:
        return recordings.odd_recording(random, name)

    odd = [damaged, damaged, damaged, other, mechanisms.refused_file, mechanisms.refused_file, mechanisms.doubt]
    return base, _some(random, [*odd, mechanisms.gain, _out("out")])


def _calibrate(random: Random) -> Drawn:
    base: list[Layer] = [{"words": ["calibrate"]}, trials.trial(random)]

    def damaged(random: Random) -> Layer:
        return recordings.damaged(random, trials.RECORDING, RECORDINGS / trials.RECORDING)

    odd = [trials.changed, trials.changed, trials.changed, trials.again, trials.odd_file, damaged, _out("out.toml")]
    return base, _some(random, odd)


def _tune(random: Random) -> Drawn:
    base: list[Layer] = [{"words": ["tune", *searches.SMALL]}, searches.whose(random), scenarios.short_run(random)]
    base += [*_figures(random), *([searches.good_option(random)] if random.random() < 0.5 else [])]
    odd = [searches.option, searches.option, searches.earlier, scenarios.change, _out("out")]
    return base, _some(random, odd)


def _mechanism_run(random: Random) -> Drawn:
    base: list[Layer] = [{"words": ["simulate"]}, scenarios.short_run(random), {"words": ["--no-figures"]}]
    mistakes = _some(
        random, [mechanisms.change, mechanisms.change, mechanisms.change, scenarios.odd_observers, _out("out")]
    )
    if random.random() < 0.7:
        return [*base, mechanisms.scenario(random)], mistakes
    return base, [*mistakes, mechanisms.document(random)]


def _live(random: Random) -> Drawn:
    kind = random.choice(("learning", "learning", "gains", "state", "mechanism"))
    table = mechanisms.rows(truth=False) if kind == "mechanism" else recordings.table(random.random() < 0.3)
    base: list[Layer] = [{"words": ["live"]}, samples.samples(random, table)]
    base.append((mechanisms.mechanism if kind == "mechanism" else muscles.shipped)(random))

    def damaged(random: Random) -> Layer:
        return samples.damaged(random, table)

    odd = [damaged, damaged, damaged, damaged, samples.option, samples.unheard, states.out, recordings.mapping]
    match kind:
        case "learning":
            base += [{"words": ["--learning", "100ms"]}, scenarios.good_observers(random)]
            odd += [muscles.changed, muscles.odd_file]
        case "mechanism":
            base += [{"words": ["--learning", "100ms"]}, scenarios.named([random.choice(mechanisms.OBSERVERS)])]
            odd += [mechanisms.refused_file, mechanisms.refused_file]
        case "gains":
            base.append({**drawings.of("estimates"), "words": ["--gains", drawings.FILE]})
            odd += [drawings.damage, drawings.odd_file, muscles.changed]
        case "state":
            base.append(states.state(random))
            odd = [*[states.damaged] * 3, damaged, states.out]
    base += [states.kept(random)] if random.random() < 0.4 else []
    return base, _some(random, odd)


def _export(random: Random) -> Drawn:
    target = random.choice(("c", "c", "fmu"))
    base: list[Layer] = [{"words": ["export", target]}]
    match random.choice(("paper", "muscles", "mechanism")):
        case "paper":
            base += [exports.export(random), exports.of_scenario(random)]
            odd = []
        case "muscles":
            base += [exports.export(random), muscles.shipped(random)]
            odd = [muscles.changed, muscles.odd_file]
        case _:
            base += [exports.export(random, mechanisms.OBSERVERS), mechanisms.mechanism(random)]
            odd = [mechanisms.changed] * 6
    base += [exports.good_option(random, target)] if random.random() < 0.5 else []
    odd += [exports.option, exports.option, exports.option, exports.out, exports.block, exports.block]
    return base, _some(random, odd)


def _export_whole(random: Random) -> Drawn:
    base: list[Layer] = [exports.whole(random)]
    base += [scenarios.slight_change(random)] if random.random() < 0.5 else []
    mistakes = _some(random, [scenarios.change, scenarios.change, _out(base[0]["words"][-1])])
    if random.random() < 0.8:
        return [*base, scenarios.scenario(random)], mistakes
    return base, [*mistakes, random.choice((scenarios.document, scenarios.odd_file))(random)]


def _import(random: Random) -> Drawn:
    base: list[Layer] = [{"words": ["import"]}, models.model(random)]
    odd = [models.changed, models.changed, models.changed, models.option, models.option, models.odd_file, models.out]
    return base, _some(random, odd)


def _observability(random: Random) -> Drawn:
    base: list[Layer] = [{"words": ["observability"]}, scenarios.scenario(random)]
    extent = [points.extent(random)] if random.random() < 0.1 else []
    return base, [*_some(random, [points.option, points.option, scenarios.change]), *extent]


def _drawings(random: Random) -> Drawn:
    base: list[Layer] = [{"words": ["figures"]}, {"words": ["--out", "out"]}, drawings.drawing(random)]
    damage = [drawings.damage(random)] if random.random() < 0.8 else []
    return base, [*damage, *_some(random, [drawings.odd_file, _out("out")], 1)]


def _rest(random: Random) -> Drawn:
    words = random.choice(_REST).split()
    # nobody empties the cache that all cases share, or prints what others have left there
    own = [{"environment": {"HILLOBS_CACHE": "BOX/cache"}}] if words and words[0] in ("clean", "info") else []
    return [{"words": words}, *own], []


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


def _show(random: Random) -> Drawn:
    return [
        {"words": ["show"]},
        random.choice((scenarios.document, scenarios.odd_file, scenarios.scenario))(random),
    ], []


def _program(random: Random) -> Drawn:
    return [random.choices((programs.program, programs.reading, programs.following), weights=[3, 1, 1])[0](random)], []


_KINDS: dict[str, tuple[int, Callable[[Random], Drawn]]] = {
    "simulate": (22, _simulate),
    "sweep": (24, _sweep),
    "estimate": (22, _estimate),
    "observability": (9, _observability),
    "drawings": (6, _drawings),
    "show": (3, _show),
    "rest": (4, _rest),
    "programs": (12, _program),
    "import": (6, _import),
    "live": (12, _live),
    "export": (7, _export),
    "export whole": (3, _export_whole),
    "mechanism estimate": (2, _mechanism_estimate),
    "mechanism run": (2, _mechanism_run),
    "calibrate": (6, _calibrate),
    "tune": (3, _tune),
}
# without a mistake they end well
_COMMANDS = (
    *("simulate", "sweep", "estimate", "observability", "drawings", "import", "live", "export", "export whole"),
    *("mechanism estimate", "mechanism run", "calibrate", "tune"),
)
