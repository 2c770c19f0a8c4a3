"""A controller that knows no state: it sees what is measured through an observer, within what it may believe."""

from __future__ import annotations

from dataclasses import replace

from ..model.block import Block, Parameter, Symbols, symbols
from ..model.dialect import clamp, outside
from ..model.sensors import NOISE_CHANNELS, SENSED, sensors
from ..model.symbols import STATES, hat
from ..model.wiring import rename, wire

_CHOSEN = "chosen, docs/model.md#feedback"
PARAMETERS = {
    "x2_max": Parameter(0.2, "largest |x̂₂| that the controller believes", _CHOSEN, above=0),
    "Delta_max": Parameter(0.2, "largest |Δ̂| that the controller believes", _CHOSEN, above=0),
}
# of Δ̂, where an observer has one
RATE = hat("dDelta")
# what peaks while an observer settles, and what bounds it
_BOUNDED = ("x2", "Delta")


def saturation() -> Block:
    """The estimates as the controller takes them: beyond where the plant can be, they are peaks of the observer."""
    names = [hat(name) for name in (*STATES, "Delta")]
    u, p = symbols(names), symbols(PARAMETERS)
    y, guards = Symbols(u), Symbols()
    for name in _BOUNDED:
        estimate, most = u[hat(name)], p[f"{name}_max"]
        y[hat(name)] = clamp(estimate, -most, most)
        guards[f"{name}_limit"] = outside(estimate, -most, most)
    return Block("feedback", u=u, p=p, parameters=PARAMETERS, y=y, guards=guards)


def eyes(estimator: Block, lengths: Block) -> Block:
    """From what sensors look at, and their held noise, to the estimates that a controller takes for the truth.

    estimator: of an observer of the pair; its numbers keep its name, `high_gain.eps_h`. Where Δ̂ has a rate among its
    states, that is told too. lengths: what tells the lengths of the tendons.
    """
    told = [RATE] if RATE in estimator.x else []
    estimator = replace(estimator, y=Symbols({**estimator.y, **estimator.x.only(told)}))
    look, limit = sensors(), saturation()
    measured = {port: f"{look.name}.{port}" for port in look.y} | {port: f"{lengths.name}.{port}" for port in lengths.y}
    connections = {
        **{f"{look.name}.{port}": port for port in look.u},
        **{f"{lengths.name}.{port}": measured[port] for port in lengths.u},
        **{f"{estimator.name}.{port}": measured.get(port, port) for port in estimator.u},
        **{f"{limit.name}.{port}": f"{estimator.name}.{port}" for port in limit.u},
    }
    external = {"t": "t", **dict.fromkeys(SENSED, "staged"), **dict.fromkeys(NOISE_CHANNELS, "held")}
    wired = wire("eyes", [look, lengths, estimator, limit], connections, external)
    # the observer's own numbers of the tendons
    names = {f"{lengths.name}.{key}": f"{estimator.name}.{key}" for key in lengths.p}
    names |= {f"{limit.name}.{port}": port for port in limit.y}
    names |= {f"{estimator.name}.{name}": name for name in told}
    return rename(wired, "eyes", names, [*limit.y, *told])
