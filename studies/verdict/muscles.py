"""What the likelihood of a recording says of its muscles: which other numbers, if any, make it likelier."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ...model.system import pair_system
from ...observers.ports import ESTIMATES
from ..estimate.case import Case
from ..estimate.run import recorded
from ..files.progress import Progress
from ..kalman.muscles import LAW, compiled_muscles
from ..kalman.orders import Choice
from ..kalman.record import Record
from ..kalman.run import causal_choices, estimates_of_inputs
from ..laboratory.muscles import MusclePair
from ..laboratory.recording import Recording
from .doubts import BIAS, Weighed, doubts, needed_for, unknown
from .finding import Finding
from .likelihood import Weight, gains, weight
from .variants import Variant, called, variants

# an order of u below this is that of activations that jump: then F_max, lengths and curves other than the right ones
# are likelier as often as not, v_max is not, by so many times what is usual
SMOOTH, WHERE_ROUGH, ROUGH = 3, "v_max", 1.5
_ORDERS = ("order_D", "order_u", "order_a")


def of_muscles(read: Recording, pair: MusclePair, fit: Mapping[str, Any], progress: Progress) -> Iterator[Finding]:
    """What the likelihood says of the muscles' numbers, with noise and densities found anew for each.

    fit: of estimates, which orders they have. Their other numbers by hand are in units of these muscles, and would be
    other ones with other muscles.
    """
    case, record = recorded(read, pair)
    inputs, activations = choices = causal_choices(record, _orders(fit))
    rough = inputs.orders[1] < SMOOTH
    yield _form(inputs, activations, rough)
    yield from bias(case, record, inputs)
    base, tried = weight(record, choices, pair), list(variants(read, pair))
    orders = {**inputs.fit.numbers, **activations.fit.numbers}
    needed, weighed = needed_for(len(read)), []
    settling = record.settling / case.scales.rate
    for i, (variant, gain) in enumerate(
        gains(base, {name: orders[name] for name in _ORDERS}, tried, settling), start=1
    ):
        least = needed * variant.caution * (ROUGH if rough and not variant.mechanical else 1.0)
        telling, alone = _tells(variant, base, rough), variant.mechanical
        weighed.append(
            Weighed(variant.name, called(variant.name), variant.factor, variant.sentence, gain, telling, least, alone)
        )
        progress(i / len(tried))
    yield from doubts(weighed, needed)
    if names := ", ".join(w.name for w in unknown(weighed, needed)):
        yield Finding("untold", f"the recording cannot tell: {names}", float(names.count(", ") + 1))


def _tells(variant: Variant, base: Weight, rough: bool) -> bool:
    """Whether the likelihood tells of a variant: by the muscles' law, if activations are as smooth as it takes them."""
    return variant.mechanical or (base.says and (not rough or variant.name == WHERE_ROUGH))


def _form(inputs: Choice, activations: Choice, rough: bool) -> Finding:
    gain = activations.fit.log_likelihood - inputs.fit.log_likelihood
    words = "is no help: its numbers cannot be weighed"
    if gain > 0:
        words = "fits, so its numbers can be weighed"
        if rough:
            words = f"fits, but activations jump: of its numbers {WHERE_ROUGH} alone can be weighed"
    return Finding("form", f"the muscles' law with smooth activations {words} (log L {gain:+,.0f})", gain)


def bias(case: Case, record: Record, inputs: Choice) -> Iterator[Finding]:
    """What no likelihood sees; nothing where a tendon has no slope."""
    force = BIAS * case.pair.muscle1.F_max
    told = estimates_of_inputs(record, inputs)
    estimates = dict(zip(ESTIMATES, told.T, strict=True))
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        shift = force / case.scales.force / record.slopes
        biased = {**estimates, "x3_hat": told[:, 2] + shift[:, 0], "x4_hat": told[:, 3] + shift[:, 1]}
        # activations before they are limited: at a limit they would not change
        before, after = (
            compiled_muscles(pair_system(record.curves)).outputs(LAW, record.numbers, at) for at in (estimates, biased)
        )
        changes = [float(np.median(np.abs(after[name] - before[name]))) for name in ("a1_hat", "a2_hat")]
    if np.isfinite(changes).all():
        sentence = (
            f"a constant error of the forces cannot be seen: {force:.3g} N of both would change the activations by "
            f"{changes[0]:.2g} and {changes[1]:.2g}"
        )
        yield Finding("bias", sentence, max(changes))


def _orders(fit: Mapping[str, Any]) -> dict[str, float]:
    """The orders of some estimates, as far as they are known: without a second pass that of the activations is not."""
    numbers = {**fit["u"]["numbers"], **fit.get("a", fit["u"])["numbers"]}
    return {name: numbers[name] for name in _ORDERS if name in numbers}
