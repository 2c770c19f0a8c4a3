"""What can be known about the pair: the registry of observers. A new one is its file and one line here."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import casadi as ca

from ..model.block import Block, BlockError, Symbols
from ..model.curves import NGUYEN2019, Curves, tendon_parameters
from ..model.limits import limits
from ..model.skeleton import LENGTH
from ..model.symbols import hat
from ..model.wiring import rename, wire
from .activation import activation_estimate
from .adaptive_sliding_mode import ADAPTIVE_SLIDING_MODE
from .baseline import baseline
from .high_gain import HIGH_GAIN
from .high_gain_3 import HIGH_GAIN_3
from .observer import Observer
from .ports import ESTIMATES, INPUTS
from .sliding_mode import SLIDING_MODE
from .tendons import tendons

# figures choose their lines in this order: append new ones
OBSERVERS: Mapping[str, Observer] = {
    "high_gain": HIGH_GAIN,
    "sliding_mode": SLIDING_MODE,
    "adaptive_sliding_mode": ADAPTIVE_SLIDING_MODE,
    "high_gain_3": HIGH_GAIN_3,
}
# the observers that run where none is named
PAPER = ("high_gain", "sliding_mode", "adaptive_sliding_mode")


def label(name: str) -> str:
    """What tables and figures call an observer; one that is not registered goes by its own name."""
    return OBSERVERS[name].label if name in OBSERVERS else name


_ACTIVATIONS = ("a1_hat", "a2_hat")


def estimator(observer: Block, curves: Curves = NGUYEN2019, activations: bool = True) -> Block:
    """`observer` with the activation block behind it (unless it estimates the activations itself).

    Without `activations` nobody asks for them. Refuses a Block without the observer's ports (BlockError).
    """
    if wrong := [name for name in observer.u if name not in INPUTS]:
        raise BlockError(f"{observer.name}: an observer sees {', '.join(INPUTS)} only, not {', '.join(wrong)}")
    if missing := [name for name in ESTIMATES if name not in observer.y]:
        raise BlockError(f"{observer.name}: an observer must estimate {', '.join(missing)} as well")
    if odd := [name for name in observer.x if not name.isidentifier()]:
        raise BlockError(
            f"{observer.name}: the state {odd[0]!r} has no name that a result can carry; use letters, digits, _"
        )
    estimated = [name for name in _ACTIVATIONS if name in observer.y]
    if len(estimated) == 1:
        other = next(name for name in _ACTIVATIONS if name not in estimated)
        raise BlockError(f"{observer.name}: it estimates {estimated[0]}, so it must estimate {other} as well")
    behind = [] if estimated or not activations else [activation_estimate(curves)]
    for part in (*behind, tendons(curves)):
        _refuse_clashes(observer, part)
    connections = {f"{observer.name}.{port}": port for port in observer.u}
    connections |= {f"{part.name}.{name}": f"{observer.name}.{name}" for part in behind for name in ESTIMATES}
    external = {port: "t" if port == "t" else "held" if port in observer.held else "staged" for port in observer.u}
    wired = wire(observer.name, [observer, *behind], connections, external)
    names = [*wired.x, *wired.y, *wired.p, *wired.guards, *wired.domain]
    outputs = [*ESTIMATES, *(_ACTIVATIONS if activations else ())]
    whole = rename(wired, observer.name, {key: key.partition(".")[2] for key in names}, outputs)
    # its own numbers of the tendons that tell it L_S1 and L_S2, and of the domain that its estimates lie in
    parameters = {**whole.parameters, **tendon_parameters(curves), "C": LENGTH}
    p = Symbols({name: whole.p.get(name, ca.SX.sym(name)) for name in parameters})
    return replace(
        whole, parameters=parameters, p=p, limits=Symbols({**limits([*whole.x, *whole.y], p.C), **whole.limits})
    )


def _refuse_clashes(observer: Block, part: Block) -> None:
    """A name of the observer that another part of its estimator has too must be the same shared number."""
    for name, parameter in part.parameters.items():
        same = observer.parameters.get(name)
        if same is not None and (not same.shared or same.shared != parameter.shared):
            raise BlockError(
                f"{observer.name}: the {part.name} wired to it has a parameter {name} too; give yours another name"
                + (f", or share {parameter.shared}" if parameter.shared else "")
            )
    if guards := [name for name in part.guards if name in observer.guards]:
        raise BlockError(
            f"{observer.name}: the {part.name} wired to it has the guard {guards[0]} too; give yours another name"
        )


def baseline_estimator(curves: Curves = NGUYEN2019, activations: bool = True) -> Block:
    """The trivial baseline, wired like an observer."""
    return estimator(baseline(), curves, activations)


__all__ = ["ESTIMATES", "OBSERVERS", "PAPER", "Observer", "baseline_estimator", "estimator", "hat", "label"]
