"""What can be known about the pair: the registry of observers. A new one is its file and one line here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from ..model.block import Block, BlockError
from ..model.curves import NGUYEN2019, CurveSet
from ..model.symbols import hat
from ..model.wiring import rename, wire
from . import adaptive_sliding_mode, high_gain, sliding_mode
from .activation import activation_estimate
from .baseline import baseline
from .conditions import Conditions
from .ports import ESTIMATES, INPUTS


@dataclass(frozen=True)
class Observer:
    """How an observer is built, what its theorem asks, and what tables and figures call it."""

    build: Callable[[CurveSet], Block]
    conditions: Conditions
    label: str


OBSERVERS = {
    "high_gain": Observer(high_gain.high_gain, high_gain.conditions, "HGO"),
    "sliding_mode": Observer(sliding_mode.sliding_mode, sliding_mode.conditions, "SMO"),
    "adaptive_sliding_mode": Observer(
        adaptive_sliding_mode.adaptive_sliding_mode, adaptive_sliding_mode.conditions, "ASMO"
    ),
}

_ACTIVATIONS = ("a1_hat", "a2_hat")


def estimator(observer: Block, curves: CurveSet = NGUYEN2019) -> Block:
    """`observer` with the activation block behind it (unless it estimates the activations itself).

    Refuses a Block without the observer's ports (BlockError).
    """
    if wrong := [name for name in observer.u if name not in INPUTS]:
        raise BlockError(f"{observer.name}: an observer sees {', '.join(INPUTS)} only, not {', '.join(wrong)}")
    if missing := [name for name in ESTIMATES if name not in observer.y]:
        raise BlockError(f"{observer.name}: an observer must estimate {', '.join(missing)} as well")
    if all(name in observer.y for name in _ACTIVATIONS):
        return rename(observer, observer.name, {}, [*ESTIMATES, *_ACTIVATIONS])
    reconstruction = activation_estimate(curves)
    connections = {f"{observer.name}.{port}": port for port in observer.u}
    connections |= {f"activation.{name}": f"{observer.name}.{name}" for name in ESTIMATES}
    external = {port: "t" if port == "t" else "held" if port in observer.held else "staged" for port in observer.u}
    wired = wire(observer.name, [observer, reconstruction], connections, external)
    every = [*wired.x, *wired.y, *wired.p, *wired.guards, *wired.domain]
    return rename(wired, observer.name, {key: key.partition(".")[2] for key in every}, [*ESTIMATES, *_ACTIVATIONS])


def baseline_estimator(curves: CurveSet = NGUYEN2019) -> Block:
    """The trivial baseline, wired like an observer."""
    return estimator(baseline(curves), curves)


__all__ = ["ESTIMATES", "OBSERVERS", "Observer", "baseline_estimator", "estimator", "hat"]
