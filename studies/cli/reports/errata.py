"""The errata study as tables for a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from rich.table import Table

from ...errata.printed import CONTROLLER, OBSERVER
from ...errata.run import Estimation, Joint, Result, Tracking
from .number import number
from .plain import plain_table


def tables(results: Sequence[Result]) -> Iterator[Table]:
    """What is printed and must be, then a table for each kind of result."""
    yield _legend()
    yield _tracking_table([row for row in results if isinstance(row, Tracking)])
    estimations = [row for row in results if isinstance(row, Estimation)]
    yield _estimation_table(estimations)
    yield _nearest_table(estimations)
    yield _joint_table([row for row in results if isinstance(row, Joint)])


def _legend() -> Table:
    rows = [(name, e.where, e.printed, e.correct) for name, e in (CONTROLLER | OBSERVER).items()]
    return plain_table("What is printed", ("", "where", "printed", "must be"), rows, words=4)


def _tracking_table(results: Sequence[Tracking]) -> Table:
    head = ("controller", "max, τ ≥ 8", "rms", "max for ever", "rms", "of r's amplitude")
    rows = []
    for r in results:
        errors = [number(value) for value in (r.largest, r.rms, r.periodic, r.periodic_rms)]
        rows.append((r.variant.name, *errors, r.failure or f"{r.periodic / r.amplitude:.2%}"))
    return plain_table("Tracking error |x₁ − r|", head, rows)


def _estimation_table(results: Sequence[Estimation]) -> Table:
    quantities = ("x2", "Delta", "u1", "u2", "a1")
    head = ("observer", "max |e₁|", *(f"rmse {name}" for name in quantities), "limits active")
    rows = [
        (
            r.variant.name,
            number(r.x1_largest),
            *(number(r.rmse[name]) for name in quantities),
            r.failure or _limits(r.guards),
        )
        for r in results
    ]
    return plain_table("Errors of the adaptive sliding mode observer (as printed: O8 read as meant)", head, rows)


def _limits(guards: Mapping[str, float]) -> str:
    return ", ".join(f"{name} {number(time)}" for name, time in guards.items())


def _nearest_table(results: Sequence[Estimation]) -> Table:
    head = ("observer", "Δ̂ is", "û₁ is", "û₂ is")
    rows = [(r.variant.name, *(f"{n.signal} ± {number(n.distance)}" for n in r.nearest.values())) for r in results]
    return plain_table("What its estimates are (± root mean square of the difference)", head, rows, words=4)


def _joint_table(results: Sequence[Joint]) -> Table:
    head = ("toe of Φ_S", "printed, exact", "meant", "rounding in double precision")
    rows = [(r.where, f"{float(r.printed):.12g}", f"{float(r.meant):g}", number(r.rounding)) for r in results]
    return plain_table("The printed decimals of Φ_S", head, rows)
