"""Whether innovations are as large as their standard deviations say, white, and the same all the time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ...model.arrays import Array
from ..estimate.sizes.noise import even_steps
from .finding import Finding, plain
from .hanging import NO_NOISE

# innovations over their standard deviations: mean square, and correlation from sample to sample
_SIZE, _COLOUR = (0.7, 1.4), 0.25
# with this part of the steps as long as usual, noise is measured well
_EVEN = 0.9
# where they are correlated by more, slow waves make all blocks differ
_WAVES = 0.5
# samples of a block, of which so many must count; the median of its innovations over the usual one may lie between
# these: chance makes 1 ± 1.2/√200 of it
_BLOCK, _PART, _BLOCKS = 200, 0.5, (0.5, 2.0)
# what stands for none at all
_LEAST = 1e-3
# blocks of which something is usual
_FEW = 3
_OF = ("position", "force_1", "force_2")
# of more sensors the least and the largest number are told
_MANY = 3


def of_innovations(time: Array, ratios: Array, noise: float, sensors: Sequence[str] = _OF) -> Iterator[Finding]:
    """ratios: innovations over their standard deviations (n × sensors), NaN where one does not count; time: s (n).

    noise: that of the forces, in F₀.
    """
    counts = np.isfinite(ratios)
    if noise < NO_NOISE or not counts.any(axis=0).all():
        yield Finding("innovations", "there is no noise to speak of, so innovations tell nothing", noise)
        return
    size = np.array([np.mean(ratio[counted] ** 2) for ratio, counted in zip(ratios.T, counts.T, strict=True)])
    colour = np.array([_correlation(ratio, counted) for ratio, counted in zip(ratios.T, counts.T, strict=True)])
    counted = np.array(counts.all(axis=1))
    wrong = bool((size < _SIZE[0]).any() or (size > _SIZE[1]).any() or (np.abs(colour) > _COLOUR).any())
    advice = ""
    if wrong:
        uneven = even_steps(time, float(np.median(np.diff(time)))).mean() < _EVEN
        advice = (
            f": noise that is not white, a number by hand, {'uneven steps, ' * bool(uneven)}or a sensor that changes"
        )
    sentence = (
        f"innovations of {', '.join(sensors)} over their standard deviations: mean square "
        f"{_told(sensors, size)} (1 is right), correlation from sample to sample "
        f"{_told(sensors, colour)} (0 is right){advice}"
    )
    yield Finding("innovations", sentence, float(np.max(np.abs(size - 1))), wrong)
    yield from _changed(time, ratios, counted, colour, sensors)


def _told(sensors: Sequence[str], values: Array) -> str:
    if len(sensors) <= _MANY:
        return ", ".join(f"{value:z.2f}" for value in values)
    least, most = int(np.argmin(values)), int(np.argmax(values))
    return f"{values[least]:z.2f} ({sensors[least]}) to {values[most]:z.2f} ({sensors[most]})"


def _changed(
    time: Array, ratios: Array, counted: NDArray[np.bool_], colour: Array, sensors: Sequence[str]
) -> Iterator[Finding]:
    """The longest part of the recording in which innovations of a sensor are far larger or smaller than usual.

    colour: correlation from sample to sample; where that is large parts cannot be compared.
    """
    blocks = len(ratios) // _BLOCK
    seen = counted[: blocks * _BLOCK].reshape(blocks, _BLOCK)
    told = np.flatnonzero(seen.mean(axis=1) >= _PART)
    if len(told) < _FEW:
        return
    sizes = np.where(counted[:, None], np.abs(ratios), np.nan)[: blocks * _BLOCK].reshape(blocks, _BLOCK, -1)[told]
    # medians, since an excitation that jumps, or a wild sample, is no change
    size = np.nanmedian(sizes, axis=1)
    usual = np.median(size, axis=0)
    # −1: smaller, 1: larger
    kinds = np.where(size < _BLOCKS[0] * usual, -1, np.where(size > _BLOCKS[1] * usual, 1, 0)) * (
        np.abs(colour) <= _WAVES
    )
    if not kinds.any():
        return
    edges = np.flatnonzero(np.concatenate([[True], (np.diff(kinds, axis=0) != 0).any(axis=1), [True]]))
    lengths = np.where(kinds[edges[:-1]].any(axis=1), np.diff(edges), 0)
    longest = int(np.argmax(lengths))
    first, last = int(edges[longest]), int(edges[longest + 1]) - 1
    when = float(time[told[first] * _BLOCK]), float(time[(told[last] + 1) * _BLOCK - 1])
    factors = np.median(size[first : last + 1], axis=0) / usual
    named = [f"{sensors[i]} are {plain(factors[i])} times" for i in np.flatnonzero(kinds[first]).tolist()]
    more = int(kinds.any(axis=1).sum()) - (last + 1 - first)
    also = f"; in {more / len(told):.0%} of the recording there are other changes" if more else ""
    yield Finding(
        "innovations",
        f"from {when[0]:.4g} to {when[1]:.4g} s innovations of {', of '.join(named)} as large as usual: a sensor, or "
        f"its scale, that changes{also}",
        float(np.max(np.abs(np.log(np.maximum(factors, _LEAST))))),
        True,
        when,
    )


def _correlation(ratio: Array, counted: NDArray[np.bool_]) -> float:
    """From sample to sample; 1 if nothing varies."""
    both = counted[1:] & counted[:-1]
    before, after = ratio[:-1][both], ratio[1:][both]
    return float(np.corrcoef(before, after)[0, 1]) if len(before) and np.ptp(before) and np.ptp(after) else 1.0
