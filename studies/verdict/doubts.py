"""What would make a recording likelier: the likeliest named first, and what the recording cannot tell."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from .finding import Finding, Suspect

# log L that another thing must gain, and that of each sample: what the model leaves out is no doubt of the muscle
_GAIN, _EACH = 30.0, 0.02
# a constant error of the forces, in F_max, whose effect is told
BIAS = 0.01
# others than the best are named up to here
_NAMED = 3


@dataclass(frozen=True)
class Weighed:
    """Another thing, how likely it makes a recording, and by how much that must be more.

    number: what is tried, which is likelier times `factor` or is no number, by its `name` in a sentence; sentence: ends
    "likelier with …"; gain: None if it can be nothing at all; telling: whether the likelihood knows of it; least: what
    it must gain; alone: whether nothing else, such as curves, could have the same effect.
    """

    number: str
    name: str
    factor: float | None
    sentence: str
    gain: float | None
    telling: bool
    least: float
    alone: bool


def needed_for(samples: int) -> float:
    """log L that another thing must gain in a recording of so many samples."""
    return max(_GAIN, _EACH * samples)


def doubts(weighed: Sequence[Weighed], needed: float) -> Iterator[Finding]:
    """What would make the recording likelier, best first, or that nothing does, or that nothing can be told."""
    telling = [(w, w.gain) for w in weighed if w.gain is not None and w.telling]
    better = sorted(((w, gain) for w, gain in telling if gain > w.least), key=lambda pair: -round(pair[1]))
    if better:
        named = "; or ".join(f"{w.sentence} (log L {gain:+,.0f})" for w, gain in better[:_NAMED])
        likeliest, most = better[0]
        if not (likeliest.alone or any(w.number == "curves" for w, _ in better)):
            named += ", or with curves of another kind"
        suspects = [Suspect(w.number, w.factor, w.sentence, gain) for w, gain in better]
        yield Finding("muscles", f"the recording is likelier with {named}", most, True, suspects=suspects)
    else:
        best = max((gain for _, gain in telling), default=0.0)
        yield Finding("muscles", f"no other number tried makes the recording likelier by {needed:.0f} in log L", best)


def unknown(weighed: Sequence[Weighed], needed: float) -> Iterator[Weighed]:
    """One of each number of which other values are as likely, or of which nothing is told."""
    for number in dict.fromkeys(w.number for w in weighed):
        of = [w for w in weighed if w.number == number]
        if not of[0].telling or all(w.gain is not None and abs(w.gain) <= needed for w in of):
            yield of[0]
