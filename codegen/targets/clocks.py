"""What an observer asks of time: how long ago its last sample was, or how much has gone by since the first one."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca

from ...model.block import Block, BlockError, Symbols


def without_clocks(block: Block) -> tuple[Block, bool]:
    """The observer with time counted from the last sample, without the states that remember when that was.

    And whether time must be counted from the first sample on: if it asks for more than differences.
    """
    if "t" not in block.u:
        return block, False
    t = block.u["t"]
    # CasADi makes e of (o + e) − o, and nothing is left of o where differences alone count
    clocks = [n for n, e in block.next.items() if ca.is_equal(e, t) and ca.is_equal(block.x0.get(n, ca.SX(0)), t)]
    origin, elapsed = ca.SX.sym("origin"), ca.SX.sym("elapsed")

    def at(clock: ca.SX) -> Callable[[Symbols], Symbols]:
        """With time from the origin on, and clocks that show a time."""
        old = ca.vertcat(t, *(block.x[name] for name in clocks))
        new = ca.vertcat(origin + elapsed, *[clock] * len(clocks))

        def changed(entries: Symbols) -> Symbols:
            kept = entries.only(name for name in entries if name not in clocks)
            return (
                Symbols(zip(kept, ca.vertsplit(ca.substitute(kept.vector(), old, new)), strict=True)) if kept else kept
            )

        return changed

    # what is told is told at a sample, after all clocks were set
    told = {group: at(origin + elapsed)(getattr(block, group)) for group in ("y", "guards", "domain")}
    u = Symbols({**block.u, "t": elapsed})
    try:
        x = block.x.only(name for name in block.x if name not in clocks)
        return block.rewritten(at(origin), x=x, u=u, **told), False
    except BlockError:  # the origin is still there
        return block, True
