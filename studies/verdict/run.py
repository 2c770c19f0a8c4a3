"""The verdict on a recording and its muscles: what a person can act on."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...model.arrays import Array
from ..estimate.case import Case
from ..estimate.run import recorded
from ..files.progress import Progress, unseen
from ..kalman.muscles import ACTIVATION, compiled_muscles
from ..kalman.orders import Choice
from ..kalman.record import Record, refuse_short
from ..kalman.run import ACTIVATIONS, How, causal_choices, estimated, innovations
from ..laboratory.muscles import MusclePair, read_muscles
from ..laboratory.recording import Recording, read_recording
from .checks import of_estimates, of_innovations, of_measurements
from .finding import Finding
from .likelihood import Weight, gains, weight
from .variants import Variant, variants

# of a longer recording the samples in its middle are asked
_MOST = 4_000
# log L that a variant must gain, and that of each sample: what the model leaves out is no doubt of the muscle
_GAIN, _EACH = 30.0, 0.02
# others than the best are named up to here
_NAMED = 3
# a constant error of the forces, in F_max, whose effect is told
_BIAS = 0.01


@dataclass(frozen=True)
class Verdict:
    """All findings."""

    findings: Sequence[Finding]

    @property
    def quality(self) -> str:
        """`good`, or `doubtful` if any finding is."""
        return "doubtful" if any(finding.doubtful for finding in self.findings) else "good"

    def as_dict(self) -> dict[str, Any]:
        """The same for a program, in words of JSON."""
        findings = [asdict(finding) for finding in self.findings]
        # JSON has no infinity
        findings = [{**f, "value": f["value"] if math.isfinite(f["value"]) else None} for f in findings]
        return {"quality": self.quality, "findings": findings}


def verdict(
    recording: str | Path | Recording,
    muscles: str | Path | MusclePair,
    mapping: Mapping[str, str] | None = None,
    progress: Progress | None = None,
) -> Verdict:
    """Whether a recording and the numbers of its muscles can be believed.

    recording, muscles, mapping: as `estimate` takes them. Of more than 4,000 samples those in the middle are asked.
    RecordingError, ScenarioError for what cannot be a recording of these muscles at all.
    """
    pair = muscles if isinstance(muscles, MusclePair) else read_muscles(muscles)
    read = recording if isinstance(recording, Recording) else read_recording(recording, mapping)
    refuse_short(read.source, len(read))
    return Verdict(list(_findings(_middle(read), pair, progress or unseen)))


def _findings(read: Recording, pair: MusclePair, progress: Progress) -> Iterator[Finding]:
    case, record = recorded(read, pair)
    yield from (plain := list(of_measurements(case)))
    inputs, activations = choices = causal_choices(record, {})
    form, outputs = estimated(record, How(), inputs, activations, 1, unseen)
    yield of_innovations(innovations(record, inputs), min(case.sizes.pair.sigma_F1, case.sizes.pair.sigma_F2))
    limits = [float(np.mean(outputs[f"a{j}_hat_limit"])) for j in (1, 2)]
    yield from of_estimates(case, record.columns["acc"], outputs["Delta_hat"], limits)
    yield _form(inputs, activations, form == ACTIVATIONS)
    yield _bias(case, record, outputs)
    if plain:
        # what no muscle measures needs no comparison of muscles
        return
    orders, base, tried = _orders(inputs, activations), weight(record, choices, pair), list(variants(read, pair))
    weighed = []
    for i, (variant, gain) in enumerate(gains(base, orders, iter(tried)), start=1):
        weighed.append((variant, gain))
        progress(i / len(tried))
    yield from _doubts(base, weighed, max(_GAIN, _EACH * len(read)))


def _doubts(base: Weight, weighed: Sequence[tuple[Variant, float | None]], needed: float) -> Iterator[Finding]:
    """What would make the recording likelier, best first, or that nothing does, or that nothing can be told."""
    telling = [(variant, gain) for variant, gain in weighed if gain is not None and (variant.mechanical or base.says)]
    better = sorted(((v, g) for v, g in telling if g > needed * v.caution), key=lambda pair: -pair[1])
    if better:
        named = [f"{variant.sentence} (log L {gain:+,.0f})" for variant, gain in better[:_NAMED]]
        curves = "" if better[0][0].mechanical else ", or with curves of another kind"
        yield Finding("muscles", f"the recording is likelier with {'; or '.join(named)}{curves}", better[0][1], True)
    else:
        best = max((gain for _, gain in telling), default=0.0)
        yield Finding("muscles", f"no other number tried makes the recording likelier by {needed:.0f} in log L", best)
    unknown = [name for name in dict.fromkeys(v.name for v, _ in weighed) if _is_unknown(name, base, weighed, needed)]
    if unknown:
        names = ", ".join(name.replace("_", " ") for name in unknown)
        yield Finding("untold", f"the recording cannot tell: {names}", float(len(unknown)))


def _is_unknown(name: str, base: Weight, weighed: Sequence[tuple[Variant, float | None]], needed: float) -> bool:
    """Whether other values of a number are as likely."""
    of = [(variant, gain) for variant, gain in weighed if variant.name == name]
    if not (base.says or of[0][0].mechanical):
        return True
    return all(gain is not None and abs(gain) <= needed for _, gain in of)


def _form(inputs: Choice, activations: Choice, taken: bool) -> Finding:
    gain = activations.fit.log_likelihood - inputs.fit.log_likelihood
    words = "fits, so its numbers can be weighed" if taken else "is no help: its numbers cannot be weighed"
    return Finding("form", f"the muscles' law with smooth activations {words} (log L {gain:+,.0f})", gain)


def _bias(case: Case, record: Record, outputs: Mapping[str, Array]) -> Finding:
    """What no likelihood sees."""
    force = _BIAS * case.pair.muscle1.F_max
    shift = force / case.scales.force / record.slopes
    biased = {**outputs, "x3_hat": outputs["x3_hat"] + shift[:, 0], "x4_hat": outputs["x4_hat"] + shift[:, 1]}
    changed = compiled_muscles(record.curves).outputs(ACTIVATION, record.numbers, biased)
    changes = [float(np.median(np.abs(changed[name] - outputs[name]))) for name in ("a1_hat", "a2_hat")]
    return Finding(
        "bias",
        f"a constant error of the forces cannot be seen: {force:.3g} N of both would change the activations by "
        f"{changes[0]:.2g} and {changes[1]:.2g}",
        max(changes),
    )


def _orders(inputs: Choice, activations: Choice) -> dict[str, float]:
    (order_D, order_u), (_, order_a) = inputs.orders, activations.orders
    return {"order_D": float(order_D), "order_u": float(order_u), "order_a": float(order_a)}


def _middle(read: Recording) -> Recording:
    """At most so many samples, from the middle."""
    if len(read) <= _MOST:
        return read
    start = (len(read) - _MOST) // 2
    part = slice(start, start + _MOST)
    columns = {name: getattr(read, name)[part] for name in ("time", "position", "force_1", "force_2", "rows")}
    return replace(read, **columns, true={name: values[part] for name, values in read.true.items()})
