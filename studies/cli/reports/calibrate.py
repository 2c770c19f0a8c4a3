"""What a calibration has to say: numbers before and after, trials, and what these cannot tell."""

from __future__ import annotations

from collections.abc import Iterator

from rich.table import Table

from ...calibrate.fit import OUTLIER
from ...calibrate.result import Calibration, Misfit, Number
from ...calibrate.told import Direction
from .number import counted, number, percent
from .plain import plain_table

# standard deviations of what was known before from which on a number or a level is worth a word
_FAR = 3.0
# a part that is rounded to all of it
_ALL = 0.995
# outliers named one by one
_FEW = 3


def number_table(found: Calibration) -> Table:
    """Each number before and after, and what of its standard deviation is left."""
    return plain_table(
        "Numbers of the muscles, with standard deviations",
        ("muscle", "number", "unit", "before", "±", "calibrated", "±", "left of ±"),
        [
            (
                of.muscle,
                of.name,
                of.unit,
                f"{of.before:.4g}",
                percent(of.before_sd / of.before),
                f"{of.value:.5g}",
                percent(of.sd / of.value),
                f"{100 * of.left:.2g} %" if of.left < _ALL else "all",
            )
            for of in found.numbers
        ],
        words=3,
    )


def trial_table(found: Calibration) -> Table:
    """What each trial leaves unexplained."""
    return plain_table(
        "Forces that are left, in their standard deviations",
        ("trial", "muscle", "forces", "one every, s", "rms", "by chance at most"),
        [
            (of.source, of.muscle, f"{of.samples:,}", f"{of.spacing:.2g}", number(of.rms), number(of.limit))
            for of in found.misfits
        ],
        words=2,
    )


def notes(found: Calibration) -> Iterator[str]:
    """Sentences: what does not fit, what is far from what was known before, what trials cannot tell."""
    for misfit in found.misfits:
        yield from _of_trial(misfit)
    for of in found.numbers:
        yield from _of_number(of)
    for direction in found.untold:
        yield _of_direction(direction)


def _of_trial(misfit: Misfit) -> Iterator[str]:
    where = f"{misfit.source}, {misfit.muscle}"
    if not misfit.fits:
        yield (
            f"{where}: the curves do not fit, whatever their numbers: forces are off by {number(misfit.rms)} standard "
            f"deviations, and chance makes at most {number(misfit.limit)}; numbers are less sure than their ± says; "
            "try another curve set or check the activation"
        )
    if times := misfit.outliers:
        shown = ", ".join(f"{time:.3g}" for time in times[:_FEW])
        more = f" and {counted(len(times) - _FEW, 'time')} more" if len(times) > _FEW else ""
        yield (
            f"{where}: {counted(len(times), 'force')} beyond {OUTLIER:g} standard deviations, at {shown} s{more}; "
            "outliers count less"
        )
    if abs(misfit.level) > _FAR:
        yield (
            f"{where}: the activation seems to be {'above' if misfit.level > 0 else 'below'} what the trial says by "
            f"{number(abs(misfit.level))} of its standard deviations"
        )


def _of_number(of: Number) -> Iterator[str]:
    if abs(of.moved) > _FAR:
        yield (
            f"{of.muscle}.{of.name} is {number(abs(of.moved))} standard deviations from what was known before: that is "
            "of another muscle or in another unit, or the curves are another muscle's"
        )


def _of_direction(direction: Direction) -> str:
    names = ", ".join(direction.parts)
    sizes = ", ".join(f"{100 * part:+.2g} %" for part in direction.parts.values())
    told = (
        f"do not tell {names}, of which ± {percent(abs(next(iter(direction.parts.values()))))} are left"
        if len(direction.parts) == 1
        else f"tell {names} only together, and cannot tell {sizes} from none"
    )
    cure = f"; {direction.cure} would" if direction.cure else ""
    return f"{direction.muscle}: these trials {told}{cure}"
