"""What can be known about joints and muscles: the registry of observers. A new one is its file and one line here."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Mapping
from dataclasses import replace

import casadi as ca

from ..model.block import Block, BlockError, Parameters, Symbols
from ..model.limits import limits
from ..model.symbols import hat
from ..model.system import PAIR as THE_PAIR
from ..model.system import System
from ..model.wiring import rename, wire
from .adaptive_sliding_mode import ADAPTIVE_SLIDING_MODE
from .baseline import baseline
from .behind.activation import activation_estimate
from .behind.spread import covariances, spread, spreads
from .high_gain import HIGH_GAIN
from .high_gain_3 import HIGH_GAIN_3
from .kalman.constant import KALMAN_CONSTANT
from .kalman.filter import KALMAN
from .levant import LEVANT
from .observer import Observer
from .ports import ESTIMATES, inputs
from .sliding_mode import SLIDING_MODE
from .slopes import slopes_of, tendon_slopes

# figures choose their lines in this order: append new ones
OBSERVERS: Mapping[str, Observer] = {
    "high_gain": HIGH_GAIN,
    "sliding_mode": SLIDING_MODE,
    "adaptive_sliding_mode": ADAPTIVE_SLIDING_MODE,
    "high_gain_3": HIGH_GAIN_3,
    "kalman": KALMAN,
    "kalman_constant": KALMAN_CONSTANT,
    "levant": LEVANT,
}
# the observers that run where none is named
PAPER = ("high_gain", "sliding_mode", "adaptive_sliding_mode")


def label(name: str) -> str:
    """What tables and figures call an observer; one that is not registered goes by its own name."""
    return OBSERVERS[name].label if name in OBSERVERS else name


def estimator(observer: Block, system: System = THE_PAIR, activations: bool = True) -> Block:
    """`observer` of a system with what it needs in front of it and what follows from its estimates behind it.

    In front are the slopes of the tendons, if it asks for them; behind are the activations, unless it estimates them
    itself, and standard deviations, if it tells covariances. Without `activations` nobody asks for what is behind.
    Refuses a Block without the observer's ports (BlockError).
    """
    _refuse_ports(observer, system)
    slopes, domain = slopes_of(system), system.length_parameters
    front = [tendon_slopes(system)] if any(name in slopes for name in observer.u) else []
    behind = _behind(observer, system) if activations else []
    for part in (*front, *behind):
        _refuse_clashes(observer, part.name, part.parameters, part.guards)
    _refuse_clashes(observer, "tendons", system.tendon_parameters)
    # what bounds the estimates of every observer
    _refuse_clashes(observer, "domain", domain)
    connections = {f"{observer.name}.{port}": f"slopes.{port}" if port in slopes else port for port in observer.u}
    connections |= {f"{part.name}.{port}": port for part in front for port in part.u}
    connections |= {f"{part.name}.{port}": f"{observer.name}.{port}" for part in behind for port in part.u}
    seen = inputs(system)
    ports = dict.fromkeys(source for source in connections.values() if source in seen)
    external = {port: "t" if port == "t" else "held" if port in observer.held else "staged" for port in ports}
    wired = wire(observer.name, [*front, observer, *behind], connections, external)
    names = [*wired.x, *wired.y, *wired.p, *wired.guards, *wired.domain]
    told = [key.partition(".")[2] for key in wired.y]
    beside = [*map(hat, system.muscle("a")), *spreads(system)] if activations else []
    outputs = [*system.estimates, *(name for name in beside if name in told)]
    whole = rename(wired, observer.name, {key: key.partition(".")[2] for key in names}, outputs)
    # its own numbers of the tendons that tell it lengths, and of the domain that its estimates lie in
    parameters = {**whole.parameters, **system.tendon_parameters, **domain}
    p = Symbols({name: whole.p.get(name, ca.SX.sym(name)) for name in parameters})
    bounds = Symbols({**limits(system, [*whole.x, *whole.y], p), **whole.limits})
    return replace(whole, parameters=parameters, p=p, limits=bounds)


def _refuse_ports(observer: Block, system: System) -> None:
    seen = inputs(system)
    if wrong := [name for name in observer.u if name not in seen]:
        raise BlockError(f"{observer.name}: an observer sees {', '.join(seen)} only, not {', '.join(wrong)}")
    if missing := [name for name in system.estimates if name not in observer.y]:
        raise BlockError(f"{observer.name}: an observer must estimate {', '.join(missing)} as well")
    if odd := [name for name in observer.x if not all(part.isidentifier() for part in name.split("."))]:
        raise BlockError(
            f"{observer.name}: the state {odd[0]!r} has no name that a result can carry; use letters, digits, _"
        )


def _behind(observer: Block, system: System) -> list[Block]:
    """What follows from the estimates of `observer`."""
    activations = [hat(name) for name in system.muscle("a")]
    estimated = [name for name in activations if name in observer.y]
    if estimated and estimated != activations:
        other = next(name for name in activations if name not in estimated)
        raise BlockError(f"{observer.name}: it estimates {estimated[0]}, so it must estimate {other} as well")
    if estimated:
        return []
    sure = all(name in observer.y for name in covariances(system))
    return [activation_estimate(system), *([spread(system)] if sure else [])]


def _refuse_clashes(observer: Block, part: str, parameters: Parameters, guards: Iterable[str] = ()) -> None:
    """A name of the observer that another part of its estimator has too must be the same shared number."""
    for name, parameter in parameters.items():
        same = observer.parameters.get(name)
        if same is not None and (not same.shared or same.shared != parameter.shared):
            raise BlockError(
                f"{observer.name}: the {part} wired to it has a parameter {name} too; give yours another name"
                + (f", or share {parameter.shared}" if parameter.shared else "")
            )
    if clashing := [name for name in guards if name in observer.guards]:
        raise BlockError(
            f"{observer.name}: the {part} wired to it has the guard {clashing[0]} too; give yours another name"
        )


# the slow part of whatever runs observers; a user's own changes while the others stay
@functools.lru_cache(maxsize=64)
def estimator_of(observer: Observer, corrected: bool, system: System = THE_PAIR, activations: bool = True) -> Block:
    """The estimator of `observer`, its layers `corrected` or not."""
    return estimator(observer.block(corrected, system), system, activations)


def baseline_estimator(system: System = THE_PAIR, activations: bool = True) -> Block:
    """The trivial baseline, wired like an observer."""
    return estimator(baseline(system), system, activations)


__all__ = [
    "ESTIMATES",
    "OBSERVERS",
    "PAPER",
    "Observer",
    "baseline_estimator",
    "estimator",
    "estimator_of",
    "hat",
    "label",
]
