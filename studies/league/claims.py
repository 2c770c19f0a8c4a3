"""What the paper says of its three observers, tried: what holds, what fails, what depends on the gains."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from ...observers import PAPER, label
from ..scenarios.layers import Value
from ..scenarios.prepare import BASELINE
from ..simulate.run import simulate
from .closed import SETTLED
from .gains import SETS
from .play import Entry

_HGO, _SMO, _ASMO = PAPER
# what the paper calls converged, and close to the reference
_CONVERGED, _CLOSE = 0.5, 1e-3
# "comparable" is taken for within this factor, "a bit worse" and "quite close" for this one
_COMPARABLE, _A_BIT = 3.0, 2.0
_STATES, _INPUTS, _ACTIVATIONS = ("x1", "x2", "x3", "x4"), ("Delta", "u1", "u2"), ("a1", "a2")


@dataclass(frozen=True)
class Claim:
    """words: the paper's, in short; verdict: holds, fails or depends; evidence: the numbers."""

    words: str
    verdict: str
    evidence: str


# (quantity → error) of each of the three observers
Errors = Mapping[str, xr.DataArray]


def claims(medians: xr.DataArray) -> Iterator[Claim]:
    """medians: (entry, quantity) of the noisy scenario, with the baseline; the noise-free one is run here."""
    clean = simulate("paper-clean").sel(estimator=list(PAPER))
    yield from _tracking()
    settled = {name: float(clean.settling.sel(estimator=name, quantity=list(_STATES)).max()) for name in PAPER}
    yield _plain(
        "without noise the estimates of x converge at about τ = 0.5",
        max(settled.values()) <= _CONVERGED,
        f"the last of x is within its tolerance at {_told(settled, '.2g')}",
    )
    peaks = {name: float(clean.peak.sel(estimator=name, quantity="x2")) for name in PAPER}
    yield _plain(
        "the estimates of the high gain observer peak during transients",
        peaks[_HGO] == max(peaks.values()),
        f"largest error of x₂ {_told(peaks, '.2g')}",
    )
    noisy = _of_set(medians, SETS[0].name)
    ratios = {name: noisy[name] / clean.rmse.sel(estimator=name, quantity=noisy[name].quantity) for name in PAPER}
    grown = {name: float(ratio.sel(quantity=list(_STATES)).max()) for name, ratio in ratios.items()}
    yield _plain(
        "with noise the estimates of x look quite close to those without",
        max(grown.values()) <= _A_BIT,
        f"errors grow up to {_told(grown, '.2g')}-fold",
    )
    worst = {name: float(ratios[name].sel(quantity=list(_INPUTS)).max()) for name in PAPER}
    constant = {name: float(noisy[name].sel(quantity="Delta") / _baseline(medians, "Delta")) for name in PAPER}
    yield _plain(
        "those of Δ, u₁, u₂ look a bit worse than without noise",
        max(worst.values()) <= _A_BIT,
        f"errors grow up to {_told(worst, '.2g')}-fold; that of Δ is {_told(constant, '.2g')} times that of a constant",
    )
    yield _by_gains(
        "with noise the adaptive observer's x₂ is slightly better than the others'",
        medians,
        lambda errors: _is_least(errors, ("x2",)),
        ("x2",),
    )
    yield _by_gains(
        "with noise the adaptive observer's activations are closest to the true ones",
        medians,
        lambda errors: _is_least(errors, _ACTIVATIONS),
        _ACTIVATIONS,
    )
    spread = dict(zip(medians.quantity.values.tolist(), _spread(noisy).values.tolist(), strict=True))
    yield _by_gains(
        f"the three are comparable (within a factor of {_COMPARABLE:g})",
        medians,
        lambda errors: float(_spread(errors).max()) <= _COMPARABLE,
        (),
        f"largest over least error {', '.join(f'{quantity} {ratio:.2g}' for quantity, ratio in spread.items())}",
    )


def _tracking() -> Iterator[Claim]:
    known: dict[str, Value] = {"uncertainty.offset": 0.0, "uncertainty.amplitude": 0.0}
    off = [_off(simulate("paper-clean", _HGO, changes)) for changes in ({}, known)]
    yield _plain(
        f"x₁ is close to the reference after τ = {SETTLED:g}",
        off[0] <= _CLOSE,
        f"x₁ − r from there on is at most {off[0]:.1e}",
    )
    yield _plain(
        "… and not before, because of the uncertainty Δ",
        off[1] < off[0] / _A_BIT,
        f"with Δ = 0 it is {off[1]:.1e}: what takes so long is the closed loop",
    )


def _off(run: xr.Dataset) -> float:
    late = run.sel(time=slice(SETTLED, None))
    return float(np.abs(late.x.sel(state="x1") - late.r).max())


def _by_gains(
    words: str, medians: xr.DataArray, holds: Callable[[Errors], bool], shown: tuple[str, ...], evidence: str = ""
) -> Claim:
    """A claim tried with each set of gains that all three play with."""
    sets = [gains.name for gains in SETS if set(PAPER) <= set(gains.observers)]
    found = {name: holds(_of_set(medians, name)) for name in sets}
    verdict = "holds" if all(found.values()) else "depends" if any(found.values()) else "fails"
    parts = [f"{name} gains: {'yes' if found[name] else 'no'}" for name in sets] if verdict == "depends" else []
    parts += [evidence] if evidence else []
    default = _of_set(medians, SETS[0].name)
    parts += [f"{q} {_told({n: float(default[n].sel(quantity=q)) for n in PAPER}, '.1e')}" for q in shown]
    return Claim(words, verdict, "; ".join(parts))


def _plain(words: str, holds: bool, evidence: str) -> Claim:
    return Claim(words, "holds" if holds else "fails", evidence)


def _of_set(medians: xr.DataArray, gains: str) -> dict[str, xr.DataArray]:
    return {name: medians.sel(entry=str(Entry(name, gains))) for name in PAPER}


def _baseline(medians: xr.DataArray, quantity: str) -> float:
    return float(medians.sel(entry=BASELINE, quantity=quantity))


def _is_least(errors: Errors, quantities: tuple[str, ...]) -> bool:
    others = [errors[name].sel(quantity=list(quantities)) for name in (_HGO, _SMO)]
    return all(bool((errors[_ASMO].sel(quantity=list(quantities)) < other).all()) for other in others)


def _spread(errors: Errors) -> xr.DataArray:
    """(quantity) the largest error of the three over the least."""
    each = xr.concat(list(errors.values()), "observer", coords="minimal", compat="override")
    return each.max("observer") / each.min("observer")


def _told(values: Mapping[str, float], form: str) -> str:
    return ", ".join(f"{value:{form}} ({label(name)})" for name, value in values.items())
