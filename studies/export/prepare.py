"""What is exported: one observer with its numbers, for the paper's units or for those of muscles in SI."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from ...codegen.bank import Bank
from ...codegen.targets.follower import Clock, follower
from ...codegen.targets.manifest import Manifest
from ...model.block import Block
from ...model.curves.tendon import tendon
from ...model.limits import STABLE
from ...model.system import System
from ...observers import Observer, estimator_of
from ...observers.tendons import tendons
from ..estimate.start import from_first_sample, gains_by_hand, too_rare
from ..estimate.substeps import LONGEST_PERIOD, MOST_STEPS, substeps
from ..files.errors import ScenarioError
from ..files.numbers import number, whole
from ..files.versions import __version__
from ..laboratory.mechanisms.mechanism import Mechanism
from ..laboratory.muscles import MusclePair
from ..laboratory.scales import Scales
from ..laboratory.subject import Subject, subject_of
from ..scenarios.layers import Value
from ..scenarios.observers import observers_named
from ..scenarios.paths import paths_of
from ..scenarios.prepare import prepare
from . import members


@dataclass(frozen=True)
class Numbers:
    """The system, the number of each parameter of the observer's block, by name, and those given by hand, by path.

    columns: what tables call what is measured. scales: what leads to SI, if that is asked for.
    """

    system: System
    block: Block
    values: Mapping[str, float]
    given: Mapping[str, float]
    columns: tuple[str, ...]
    scales: Scales | None


def exported(
    observer: str | Block,
    period: float,
    scenario: str | Path = "paper-clean",
    muscles: str | Path | MusclePair | Mechanism | Subject | None = None,
    changes: Mapping[str, Value] | None = None,
    corrected: bool = True,
    steps: int | None = None,
) -> Manifest:
    """An observer with all that a target needs to know of it, for samples that come every `period`.

    observer: a registered name, or a Block of your own. Its numbers are those of a scenario, in the paper's units, or
    those of `muscles` (a file or what was read of one), and then inputs, estimates and `period` are in SI. changes:
    path → value, such as {"high_gain.eps_h": 0.05}. corrected: the layers of the sliding mode observers are corrected.
    steps: RK4 steps from sample to sample, by the rule of docs/gains.md if not given.
    ScenarioError or BlockError says what is wrong.
    """
    ((name, chosen),) = observers_named(observer).items()
    if muscles is None:
        found = _of_scenario(observer, name, chosen, scenario, changes or {}, corrected)
    else:
        found = _of_muscles(name, chosen, subject_of(muscles), changes or {}, corrected)
    system, scales = found.system, found.scales
    T = _period(period, scales)
    values = dict(found.values)
    if chosen.period and f"{name}.{chosen.period}" not in found.given:
        values[chosen.period] = T
    n = _steps(name, chosen, found, values, T, steps)
    block = from_first_sample(found.block, system)
    units = members.units(system, scales) if scales else {}
    bank = Bank(system.measured, tendons(system), None, (block,))
    clock, prefix = Clock(T, n, {signal: size for signal, (size, _) in units.items()}), f"hillobs_{name}"
    made = follower(bank, clock, prefix)
    return Manifest(
        name=name,
        prefix=prefix,
        label=chosen.label,
        sentence=members.sentence_of(system),
        version=__version__,
        period=float(period),
        time_unit="s" if scales else "",
        substeps=n,
        units=members.IN_SI if scales else members.ON_PAPER,
        state=members.states(made.states, system),
        params=members.numbers(made.block.parameters),
        input=members.inputs(made.inputs, system, units),
        estimate=members.estimates(made.estimates, system, units),
        guards=len(made.block.guards),
        defaults=[values[key] for key in made.block.p],
        columns=found.columns,
        functions=made.functions,
    )


def _of_scenario(
    observer: str | Block,
    name: str,
    chosen: Observer,
    scenario: str | Path,
    changes: Mapping[str, Value],
    corrected: bool,
) -> Numbers:
    prepared = prepare(scenario, observer, changes, corrected=corrected)
    system, given = prepared.system, prepared.scenario.given
    block = estimator_of(chosen, corrected, system)
    values = prepared.paths.values(block, given)
    return Numbers(system, block, dict(zip(block.p, values, strict=True)), given, system.measured, None)


def _of_muscles(
    name: str, chosen: Observer, subject: Subject, changes: Mapping[str, Value], corrected: bool
) -> Numbers:
    block = estimator_of(chosen, corrected, subject.system)
    paths = paths_of([block])
    by_hand = gains_by_hand(changes, [name], paths)
    given = {**subject.scales.numbers, **by_hand}
    values = dict(zip(block.p, paths.values(block, given), strict=True))
    return Numbers(subject.system, block, values, by_hand, subject.columns.required, subject.scales)


def _period(period: float, scales: Scales | None) -> float:
    """The period in τ. ScenarioError unless something can be followed with it."""
    if not number("the period", period) > 0:
        raise ScenarioError(f"the period must be above 0, not {period:g}")
    T = period * (scales.rate if scales else 1.0)
    if scales and (objection := too_rare(period, scales)):
        raise ScenarioError(objection)
    if T > LONGEST_PERIOD:
        raise ScenarioError(f"a sample every {period:g} is too few for the muscles; at most {LONGEST_PERIOD:g}")
    return T


def _steps(
    name: str, chosen: Observer, found: Numbers, values: Mapping[str, float], T: float, asked: int | None
) -> int:
    """RK4 steps from sample to sample. ScenarioError if those asked for are too few for stability."""
    if found.block.sampled:
        if asked is not None:
            raise ScenarioError(f"{name} moves at samples only: there are no steps in between to be chosen")
        return 0
    start = _midway(found.system, values) if chosen.rates is None else {}
    common = (chosen, found.system, found.block, values, start, T)
    if asked is None:
        return substeps(*common)
    asked, least = whole("the number of steps", asked, 1, MOST_STEPS), substeps(*common, STABLE)
    if asked < least:
        raise ScenarioError(
            f"{name} may be unstable with {asked} {'step' if asked == 1 else 'steps'} from sample to sample: "
            f"its fastest rate asks for {least} or more, docs/gains.md"
        )
    return asked


def _midway(system: System, values: Mapping[str, float]) -> dict[str, float]:
    """Inputs of a pair with the mass in the middle and both tendons at the end of their toes."""
    at = {"t": 0.0, **dict.fromkeys(system.joint("y"), values["C"] / 2)}
    for muscle, (length, force) in zip(system.muscles, system.tendons.items(), strict=True):
        here = tendon(system.curves[muscle], muscle, values)
        at |= {force: here.toe_force, length: here.edges[1]}
    return at
