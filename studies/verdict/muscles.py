"""What the likelihood of a recording says of its muscles: which other numbers, if any, make it likelier."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

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
from .finding import Finding, Suspect
from .likelihood import Weight, gains, weight
from .variants import Variant, called, variants

# log L that a variant must gain, and that of each sample: what the model leaves out is no doubt of the muscle
_GAIN, _EACH = 30.0, 0.02
# others than the best are named up to here
_NAMED = 3
# a constant error of the forces, in F_max, whose effect is told
_BIAS = 0.01
_CURVES = "curves of another kind"
_ORDERS = ("order_D", "order_u", "order_a")


def of_muscles(read: Recording, pair: MusclePair, fit: Mapping[str, Any], progress: Progress) -> Iterator[Finding]:
    """What the likelihood says of the muscles' numbers, with noise and densities found anew for each.

    fit: of estimates, which orders they have. Their other numbers by hand are in units of these muscles, and would be
    other ones with other muscles.
    """
    case, record = recorded(read, pair)
    inputs, activations = choices = causal_choices(record, _orders(fit))
    yield _form(inputs, activations)
    yield from bias(case, record, inputs)
    base, tried = weight(record, choices, pair), list(variants(read, pair))
    orders = {**inputs.fit.numbers, **activations.fit.numbers}
    weighed = []
    for i, found in enumerate(gains(base, {name: orders[name] for name in _ORDERS}, tried), start=1):
        weighed.append(found)
        progress(i / len(tried))
    yield from _doubts(base, weighed, max(_GAIN, _EACH * len(read)))


def _doubts(base: Weight, weighed: Sequence[tuple[Variant, float | None]], needed: float) -> Iterator[Finding]:
    """What would make the recording likelier, best first, or that nothing does, or that nothing can be told."""
    telling = [(variant, gain) for variant, gain in weighed if gain is not None and (variant.mechanical or base.says)]
    better = sorted(((v, g) for v, g in telling if g > needed * v.caution), key=lambda pair: -round(pair[1]))
    if better:
        named = "; or ".join(f"{variant.sentence} (log L {gain:+,.0f})" for variant, gain in better[:_NAMED])
        likeliest, most = better[0]
        if not likeliest.mechanical:
            # a muscle so far from the file's is less to be expected than curves that are others
            named = f"{_CURVES}, or with {named}" if likeliest.caution > 1 else f"{named}, or with {_CURVES}"
        suspects = [Suspect(variant.name, variant.factor, gain) for variant, gain in better]
        yield Finding("muscles", f"the recording is likelier with {named}", most, True, suspects=suspects)
    else:
        best = max((gain for _, gain in telling), default=0.0)
        yield Finding("muscles", f"no other number tried makes the recording likelier by {needed:.0f} in log L", best)
    unknown = [name for name in dict.fromkeys(v.name for v, _ in weighed) if _is_unknown(name, base, weighed, needed)]
    if unknown:
        names = ", ".join(map(called, unknown))
        yield Finding("untold", f"the recording cannot tell: {names}", float(len(unknown)))


def _is_unknown(name: str, base: Weight, weighed: Sequence[tuple[Variant, float | None]], needed: float) -> bool:
    """Whether other values of a number are as likely."""
    of = [(variant, gain) for variant, gain in weighed if variant.name == name]
    if not (base.says or of[0][0].mechanical):
        return True
    return all(gain is not None and abs(gain) <= needed for _, gain in of)


def _form(inputs: Choice, activations: Choice) -> Finding:
    gain = activations.fit.log_likelihood - inputs.fit.log_likelihood
    words = "fits, so its numbers can be weighed" if gain > 0 else "is no help: its numbers cannot be weighed"
    return Finding("form", f"the muscles' law with smooth activations {words} (log L {gain:+,.0f})", gain)


def bias(case: Case, record: Record, inputs: Choice) -> Iterator[Finding]:
    """What no likelihood sees; nothing where a tendon has no slope."""
    force = _BIAS * case.pair.muscle1.F_max
    told = estimates_of_inputs(record, inputs)
    estimates = dict(zip(ESTIMATES, told.T, strict=True))
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        shift = force / case.scales.force / record.slopes
        biased = {**estimates, "x3_hat": told[:, 2] + shift[:, 0], "x4_hat": told[:, 3] + shift[:, 1]}
        # activations before they are limited: at a limit they would not change
        before, after = (compiled_muscles(record.curves).outputs(LAW, record.numbers, at) for at in (estimates, biased))
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
