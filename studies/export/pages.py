"""A scenario as a page of its own, in which its numbers can be moved."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import casadi as ca

from ...codegen.stepper import STAGES
from ...codegen.targets.page import page
from ...codegen.targets.study import Number, Shown, Study
from ...model.block import Parameter, Symbols
from ...model.symbols import kind_of, signal_of
from ..files.errors import ScenarioError
from ..files.versions import __version__
from ..files.writing import refuse_overwriting, writable_folder, write_whole
from ..scenarios.layers import Value
from ..scenarios.observers import Observers
from ..scenarios.paths import block_paths
from ..scenarios.prepare import Prepared, prepare
from ..scenarios.rules import Rule
from ..scenarios.world import FEEDBACK, STATES
from ..simulate.measures import SENTENCES, measures_of
from .reach import FAR, NEAR, reach

# bytes of a run: what a phone's browser may have
_LARGEST = 500_000_000
# one of each of these is shown at first
_FIRST = ("dq", "Delta", "u", "a")
_BELOW = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
_LETTERS = {"Delta": "Δ", "dq": "q̇"}


def export_page(
    scenario: str | Path,
    path: str | Path,
    observers: Observers = None,
    changes: Mapping[str, Value] | None = None,
    corrected: bool = False,
) -> Path:
    """Write a scenario as one HTML file, in which its numbers can be moved; its path.

    path: the file. The other arguments are those of `simulate`. ScenarioError says what is wrong with them, BlockError
    what cannot be expressed on a page, ResultError why nothing can be written; BuildError if the compiler of the extra
    fails.

    >>> hillobs.export_page("paper-clean", "page.html").name
    'page.html'
    """
    prepared = prepare(scenario, observers, changes or {}, corrected=corrected)
    _refuse_feedback(prepared)
    _refuse_too_long(prepared)
    text = page(study_of(prepared))
    file = Path(path)
    written = writable_folder(file.parent) / file.name
    refuse_overwriting([written])
    write_whole(written, text.encode())
    return written


def _refuse_feedback(prepared: Prepared) -> None:
    if prepared.loop.noisy:
        raise ScenarioError(f"a page computes one plant for all seeds, so {FEEDBACK} must be {STATES}")


def _refuse_too_long(prepared: Prepared) -> None:
    """ScenarioError if a browser would have to keep more of a run than it may."""
    loop, steps = prepared.loop, prepared.grid.steps
    staged = len(loop.bank.measured) + len(loop.bank.front.y)
    size = 8 * steps * (STAGES * (len(loop.seen) + staged * (1 + len(prepared.observers))) + len(loop.truth.y))
    if size > _LARGEST:
        raise ScenarioError(
            f"a page keeps all steps of a run: {steps:,} of them would take {size / 1e6:,.0f} MB, "
            f"{_LARGEST / 1e6:,.0f} MB at most; make duration shorter or step larger"
        )


def study_of(prepared: Prepared) -> Study:
    """A scenario that `prepare` has checked, as targets take it."""
    scenario, paths, loop = prepared.scenario, prepared.paths, prepared.loop
    used = [block for block in loop.blocks if block not in loop.observers or block.name in prepared.observers]
    of = {block.name: block_paths(block) for block in used}
    of_truth = of[loop.truth.name]
    every = dict.fromkeys(path for block in of.values() for path in block)
    own = dict.fromkeys(paths.origin(path, scenario.given) for path in every)
    first = {kind_of(name): name for name in reversed(prepared.quantities) if kind_of(name) in _FIRST}
    rules = [rule for rule in prepared.rules if all(path in every for path in rule.paths.values())]
    ruled, sides = _ruled(rules)
    return Study(
        name=prepared.label,
        sentence=scenario.description,
        version=__version__,
        loop=loop,
        grid=prepared.grid,
        seed=scenario.seed,
        observers={name: observer.label for name, observer in prepared.chosen.items()},
        quantities=[Shown(name, _symbol(name), signal_of(name).sentence) for name in prepared.quantities],
        first=[*first.values()],
        numbers=[
            _number(path, paths.parameters[path], prepared.value(path), NEAR if path in of_truth else FAR)
            for path in own
        ],
        paths=of,
        shared=dict(_shared(every, paths.parameters)),
        given={path: value for path, value in scenario.given.items() if path in every or path in own},
        measures=SENTENCES,
        formulas=measures_of(tuple(loop.score.x), prepared.quantities, tuple(SENTENCES)),
        rules=[str(rule) for rule in rules],
        ruled=ruled,
        sides=sides,
    )


def _ruled(rules: Sequence[Rule]) -> tuple[list[str], ca.Function]:
    """The paths that the rules are about, and both sides of each."""
    paths = [*dict.fromkeys(path for rule in rules for path in rule.paths.values())]
    column = ca.SX.sym("numbers", len(paths))
    at = dict(zip(paths, ca.vertsplit(column), strict=True))
    given = (Symbols({name: at[path] for name, path in rule.paths.items()}) for rule in rules)
    sides = [side for rule, numbers in zip(rules, given, strict=True) for side in rule.below.sides(numbers)]
    both = ca.densify(ca.vertcat(*sides)) if sides else ca.SX(0, 1)
    return paths, ca.Function("sides", [column], [both], ["numbers"], ["both"])


def _shared(every: Mapping[str, None], parameters: Mapping[str, Parameter]) -> Iterator[tuple[str, str]]:
    """The paths that take the number of another one, and which."""
    for path in every:
        shared = parameters[path].shared
        if shared and shared != path:
            yield path, shared


def _number(path: str, about: Parameter, value: float, times: float) -> Number:
    ends, logarithmic = reach(path, about, value, times)
    return Number(
        path=path,
        sentence=about.sentence,
        unit=about.unit,
        value=value,
        above=_finite(about.above),
        least=_finite(about.least),
        below=_finite(about.below),
        most=_finite(about.most),
        whole=about.whole,
        reach=ends,
        logarithmic=logarithmic,
    )


def _finite(bound: float) -> float | None:
    return bound if math.isfinite(bound) else None


def _symbol(name: str) -> str:
    """A quantity's name in letters of its own: x₁, Δ."""
    return re.sub(r"\d+", lambda digits: digits[0].translate(_BELOW), _LETTERS.get(name, name))
