"""How likely a recording is with other muscles: of what was measured, in SI, so that all can be compared."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ...model.arrays import Array
from ..estimate.run import recorded
from ..files.errors import RecordingError, ScenarioError
from ..kalman.orders import Choice
from ..kalman.record import Record, settled
from ..kalman.run import causal_choices, causal_inputs
from ..laboratory.muscles import MusclePair
from ..laboratory.scales import scales
from .variants import Variant


@dataclass(frozen=True)
class Weight:
    """log L of the forces and positions measured, per newton and metre, in the first and in the second pass."""

    inputs: float
    activations: float

    @property
    def says(self) -> bool:
        """Whether the muscles' law helps at all: else their numbers are not in the likelihood."""
        return self.activations > self.inputs


def weight(record: Record, choices: tuple[Choice, Choice], pair: MusclePair) -> Weight:
    """The weight of a recording whose densities have been found."""
    first, second = (choice.fit.log_likelihood for choice in choices)
    shift = _in_si(record, pair)
    return Weight(first + shift, second + shift)


def gains(
    base: Weight, orders: Mapping[str, float], tried: Iterable[Variant], settling: float
) -> Iterator[tuple[Variant, float | None]]:
    """Each variant and how much likelier the recording is with it; None where it can be nothing at all.

    settling: s in which the filter settles: with another v_max τ is another time, and other samples would count.
    """
    for variant in tried:
        try:
            case, record = recorded(variant.recording, variant.pair)
        except (RecordingError, ScenarioError):
            yield variant, None
            continue
        record = replace(record, settling=settling * case.scales.rate)
        if variant.mechanical:
            # the muscles' law has no part in it
            found = causal_inputs(record, orders).fit.log_likelihood + _in_si(record, variant.pair)
            yield variant, found - base.inputs
        else:
            yield variant, weight(record, causal_choices(record, orders), variant.pair).activations - base.activations


def _in_si(record: Record, pair: MusclePair) -> float:
    """What makes log L of lengths one of newtons and metres."""
    counted = settled(record.table(), record.settling)[:, -1] > 0
    s = scales(pair)
    # p(F₁, F₂, position) = p(z₁, z₂, y₁)/(Φ′_S(z₁) Φ′_S(z₂) F₀² l₀)
    per_sample = 2 * np.log(s.force) + np.log(s.length)
    slopes: Array = np.log(record.slopes[counted]).sum(axis=1)
    return -float(np.sum(slopes + per_sample))
