"""The error sums of one observer against the truth, taken at every grid point (spec §9)."""

from __future__ import annotations

import casadi as ca

from ..model.block import Block, Parameter, Symbols, symbols
from ..model.symbols import QUANTITIES, SIGNALS, hat, muscle_of

# the differences of these from sample to sample are the chattering
CHATTERING = ("Delta", "u1", "u2", "a1", "a2")
SUMS = ("squares", "count", "peak", "settling")
CHATTER_SUMS = ("chatter", "pairs", "previous", "counted")

_TAUT = {"muscle1": "taut1", "muscle2": "taut2"}


def _switch(condition: ca.SX, new: ca.SX, old: ca.SX) -> ca.SX:
    return old + condition * (new - old)


def score() -> Block:
    """Inputs: t, the truth, the estimates; held: `window` (1 while errors count), `sample` (1 at a sample instant).

    States per quantity: squares, count (of the window), peak, settling (over the whole run), and for the
    chattering ones chatter, pairs, previous, counted. A quantity counts only while its tendon is taut.
    """
    truth, taut = symbols(QUANTITIES), symbols(_TAUT.values())
    estimate = symbols(hat(name) for name in QUANTITIES)
    flags = symbols("t window sample")
    parameters = {
        f"tolerance.{name}": Parameter(
            SIGNALS[name].tolerance, f"error of {name} that counts as settled", "spec §9", above=0
        )
        for name in QUANTITIES
    }
    p = symbols(parameters)
    x, per_step = Symbols(), Symbols()
    for name in QUANTITIES:
        state = symbols([*SUMS, *(CHATTER_SUMS if name in CHATTERING else ())])
        muscle = muscle_of(name)
        counts = taut[_TAUT[muscle]] if muscle else ca.SX(1)
        value = estimate[hat(name)]
        error = value - truth[name]
        now = Symbols(
            squares=state.squares + flags.window * counts * error**2,
            count=state.count + flags.window * counts,
            peak=ca.fmax(state.peak, counts * ca.fabs(error)),
            # the last time |error| exceeds the tolerance
            settling=_switch(counts * ca.fabs(error) > p[f"tolerance.{name}"], flags.t, state.settling),
        )
        if name in CHATTERING:
            # a pair of neighbouring samples, both in the window and both taut
            pair = flags.sample * flags.window * counts * state.counted
            now["chatter"] = state.chatter + pair * ca.fabs(value - state.previous)
            now["pairs"] = state.pairs + pair
            now["previous"] = _switch(flags.sample, value, state.previous)
            now["counted"] = _switch(flags.sample, flags.window * counts, state.counted)
        x |= {f"{name}.{key}": symbol for key, symbol in state.items()}
        per_step |= {f"{name}.{key}": expression for key, expression in now.items()}
    return Block(
        "score",
        x=x,
        u=Symbols({**flags, **truth, **taut, **estimate}),
        p=p,
        parameters=parameters,
        per_step=per_step,
        held=frozenset(("window", "sample")),
    )
