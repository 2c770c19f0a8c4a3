"""The error sums of one observer against the truth, taken at every grid point (docs/model.md#measures)."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from ..model.block import Block, Parameter, Symbols, symbols
from ..model.symbols import QUANTITIES, hat, kind_of, muscle_of, signal_of, taut_of

# what can be taken of a quantity
MEASURES = ("rmse", "peak", "settling", "chattering")
# the differences of these from sample to sample are the chattering
_CHATTERING = ("Delta", "u", "a")
# what counts all the time; a quantity of a muscle only while its tendon is taut
_ALWAYS = "always"


def counted_with(quantity: str) -> str:
    """Whose counts are those of `quantity`: a muscle's, or `always`."""
    return muscle_of(quantity) or _ALWAYS


def chatters(quantity: str) -> bool:
    """Whether its chattering is taken: it is an unknown input or follows from one."""
    return kind_of(quantity) in _CHATTERING


def _switch(condition: ca.SX, new: ca.SX, old: ca.SX) -> ca.SX:
    return old + condition * (new - old)


def score(quantities: Sequence[str] = QUANTITIES, measures: Sequence[str] = MEASURES) -> Block:
    """Inputs: t, the truth, the estimates; held: `window` (1 while errors count).

    States per quantity, as far as the measures need them: squares (of the window), peak, settling (over the whole
    run), and from sample to sample chatter and previous for the chattering ones. Per muscle, and for what always
    counts: count of grid points in the window, pairs of neighbouring samples, and whether the last sample counted.
    """
    owners = sorted(dict.fromkeys(map(counted_with, quantities)), key=lambda owner: owner != _ALWAYS)
    chattering = [name for name in quantities if chatters(name) and "chattering" in measures]
    truth, taut = symbols(quantities), symbols(taut_of(owner) for owner in owners if owner != _ALWAYS)
    estimate, flags = symbols(hat(name) for name in quantities), symbols("t window")
    parameters = {
        f"tolerance.{name}": Parameter(
            signal_of(name).tolerance,
            f"error of {name} that counts as settled",
            "chosen, docs/model.md#measures",
            above=0,
        )
        for name in quantities
        if "settling" in measures
    }
    p = symbols(parameters)
    x, per_step, at_sample = Symbols(), Symbols(), Symbols()

    def add(to: Symbols, prefix: str, states: Symbols, now: Symbols) -> None:
        x.update({f"{prefix}.{key}": symbol for key, symbol in states.items()})
        to.update({f"{prefix}.{key}": expression for key, expression in now.items()})

    seen, pair = {}, {}
    for name in owners:
        seen[name] = ca.SX(1) if name == _ALWAYS else taut[taut_of(name)]
        # neighbouring samples, both in the window and both taut
        counts = flags.window * seen[name]
        if "rmse" in measures:
            state = symbols("count")
            add(per_step, name, state, Symbols(count=state.count + counts))
        if name in map(counted_with, chattering):
            state = symbols("pairs counted")
            pair[name] = counts * state.counted
            add(at_sample, name, state, Symbols(pairs=state.pairs + pair[name], counted=counts))
    for name in quantities:
        counts, value = seen[counted_with(name)], estimate[hat(name)]
        error = counts * (value - truth[name])
        if "rmse" in measures:
            state = symbols("squares")
            # before the window an error whose square overflows is 0, not 0·∞
            add(per_step, name, state, Symbols(squares=state.squares + (flags.window * error) ** 2))
        if "peak" in measures:
            state = symbols("peak")
            add(per_step, name, state, Symbols(peak=ca.fmax(state.peak, ca.fabs(error))))
        if "settling" in measures:
            state = symbols("settling")
            # the last time |error| exceeds the tolerance
            late = _switch(ca.fabs(error) > p[f"tolerance.{name}"], flags.t, state.settling)
            add(per_step, name, state, Symbols(settling=late))
        if name in chattering:
            state = symbols("chatter previous")
            change = pair[counted_with(name)] * ca.fabs(value - state.previous)
            add(at_sample, name, state, Symbols(chatter=state.chatter + change, previous=value))
    return Block(
        "score",
        x=x,
        u=Symbols({**flags, **truth, **taut, **estimate}),
        p=p,
        parameters=parameters,
        per_step=per_step,
        next=at_sample,
        held=frozenset(("window",)),
    )
