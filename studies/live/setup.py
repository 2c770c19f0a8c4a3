"""Who follows whose muscles: an observer, compiled for a subject, and its gains."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import xarray as xr

from ...codegen.recordings.filters import CompiledBank, Filter
from ...model.arrays import Array
from ...model.block import Block
from ...observers import OBSERVERS, Observer
from ...observers.behind.spread import sd
from ..estimate.follow import chosen_bank, compiled_bank, lengths_block, measured_tendons, observer_paths
from ..estimate.sizes.first_pass import compile_first_pass, first_pass
from ..estimate.start import begun, gains_by_hand, gains_of_block, gains_of_rule
from ..files.errors import ScenarioError
from ..files.numbers import switch
from ..files.quote import shown, table
from ..laboratory.mechanisms.mechanism import Mechanism
from ..laboratory.muscles import MusclePair
from ..laboratory.subject import Subject, subject_of
from ..scenarios.layers import Value
from ..scenarios.observers import observers_named
from ..scenarios.paths import Paths
from .gains import gains_of_estimates


@dataclass(frozen=True, eq=False)
class Setup:
    """An observer's Block in a library, the muscles it is for, and the paths of its numbers."""

    subject: Subject
    observer: Observer
    block: Block
    compiled: CompiledBank
    paths: Paths
    corrected: bool

    @property
    def sure(self) -> bool:
        """Whether the observer tells standard deviations."""
        return sd(self.subject.system.states[0]) in self.block.y

    @functools.cached_property
    def units(self) -> list[float]:
        """Of what is measured, positions then forces, those of the paper's variables in SI."""
        s = self.subject.scales
        return [*s.coordinates.tolist(), *[float(s.force)] * len(self.subject.system.muscles)]

    def tendons(self, y: Array) -> Array:
        """Tendon lengths (n × muscles) that measurements (n × measured) tell."""
        numbers = self.paths.values(lengths_block(self.compiled.bank), self.subject.scales.numbers)
        return measured_tendons(self.compiled, np.array(numbers), y)[0]

    def filter(self, gains: Mapping[str, float], first: Sequence[float], T: float) -> tuple[Filter, dict[str, float]]:
        """The observer before its first sample, which is this one, and its numbers by name; T: period in τ."""
        seen = [*first, *self.tendons(np.array([first]))[0].tolist()]
        numbers, steps = begun(self.observer, self.subject, self.paths, self.block, gains, seen, T)
        return self.compiled.follow(self.block.name, list(numbers.values()), steps), numbers

    def refuse_too_fast(self, gains: Mapping[str, float], T: float) -> None:
        """ScenarioError if the gains are too fast for a period T in τ; of an observer that tells its rates."""
        if self.observer.rates is not None:
            system = self.subject.system
            nowhere = [0.0] * (len(system.measured) + len(system.tendons))
            begun(self.observer, self.subject, self.paths, self.block, gains, nowhere, T)

    def learnt(self, y: Array, tau: Array, T: float) -> dict[str, float]:
        """Path → value of the gains for samples at times τ (n), measurements y (n × measured), of the period T."""
        sizes = first_pass(self.subject.laws, y, self.tendons(y), T, tau)
        return gains_of_rule(self.observer, self.subject.system, self.block, sizes, T)

    def given(self, gains: Mapping[str, Value] | xr.Dataset | None) -> dict[str, float]:
        """Path → value of gains that are given by path, or are those of estimates. ScenarioError if they are none."""
        if isinstance(gains, xr.Dataset):
            gains = gains_of_estimates(gains, self.block.name)
        by_path = table("gains", {} if gains is None else gains)
        return gains_of_block(self.block, gains_by_hand(by_path, [self.block.name], self.paths))

    def missing(self, gains: Mapping[str, float]) -> list[str]:
        """Gains that the rule finds and that are not given."""
        # of no samples at all it makes gains of no use, by the same names
        system = self.subject.system
        none = np.empty((0, len(system.measured))), np.empty((0, len(system.muscles)))
        sizes = first_pass(self.subject.laws, *none, T=1.0)
        return [path for path in gains_of_rule(self.observer, system, self.block, sizes, 1.0) if path not in gains]

    def compile_learning(self) -> None:
        """Compile what gains are learnt with: it takes seconds, in which samples would be lost."""
        compile_first_pass(self.subject.system)


def setup(muscles: str | Path | MusclePair | Mechanism | Subject, observer: str | Block, corrected: bool) -> Setup:
    """The library is compiled or loaded. ScenarioError for what is wrong with the muscles or the observer."""
    if not isinstance(observer, str | Block):
        raise ScenarioError(f"an observer is a name or a Block, not {shown(observer)}")
    subject, corrected = subject_of(muscles), switch("corrected", corrected)
    ((name, chosen),) = observers_named(observer).items()
    # nothing is found by the likelihood of samples that have not come yet
    live = replace(chosen, fitted=False) if chosen.fitted else chosen
    bank = chosen_bank(subject, corrected, {name: live})
    block = next(block for block in bank.observers if block.name == name)
    paths = observer_paths(subject.system, bank, [block] if OBSERVERS.get(name, live).fitted else [])
    return Setup(subject, live, block, compiled_bank(bank), paths, corrected)
