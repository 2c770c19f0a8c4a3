"""What the likelihood of a recording has decided, in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

_LAW = "activations as states"


def decisions(fit: Mapping[str, Any], settings: Mapping[str, Any]) -> Iterator[str]:
    """Orders, densities and form of a Kalman filter, and what its estimates know."""
    yield f"densities and orders by maximum likelihood: {orders_of_inputs(fit)}"
    yield from _of_chains(fit["chains"]) if "chains" in fit else _of_pair(fit)
    if settings["smooth"]:
        yield "smoothed: each estimate knows all samples"
    elif fit["lag"]:
        yield f"each estimate is {_time(fit['lag'])} late, and knows the samples until then"
    elif settings["lag"]:
        yield f"a lag of {_time(settings['lag'])} is less than half a sample, so estimates know no later one"


def _time(seconds: float) -> str:
    return f"{seconds:,.4g} s" if seconds >= 1 else f"{seconds * 1e3:.4g} ms"


def orders(choice: Mapping[str, Any], second: str) -> str:
    """The orders of Δ and of the `second` input, how likely others are, and why a likelier one is not taken."""
    D, other = choice["orders"]
    return f"Δ {D}, {second} {other}{_others(choice)}"


def orders_of_inputs(fit: Mapping[str, Any]) -> str:
    """The same of the first pass, of a mechanism by the names of its joints and muscles."""
    if "chains" not in fit:
        return orders(fit["u"], "u")
    inputs = {of: chain["u"] for of, chain in fit["chains"].items()}
    return ", ".join(
        f"{of} {'Δ' if 'order_D' in u['numbers'] else 'u'} {u['orders'][0]}{_others(u)}" for of, u in inputs.items()
    )


def _of_pair(fit: Mapping[str, Any]) -> Iterator[str]:
    if "a" in fit:
        yield f"{_LAW}, {_taken(fit)}: {orders(fit['a'], 'a')}; log L {_gain(fit):+,.0f}"


def _of_chains(fits: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    law = {of: fit for of, fit in fits.items() if "a" in fit}
    for taken in ("taken", "not taken"):
        told = (
            f"{of}: a {fit['a']['orders'][0]}{_others(fit['a'])}; log L {_gain(fit):+,.0f}"
            for of, fit in law.items()
            if _taken(fit) == taken
        )
        if words := ", ".join(told):
            yield f"{_LAW}, {taken} for {words}"


def _taken(fit: Mapping[str, Any]) -> str:
    return "taken" if fit["form"] == "a" else "not taken"


def _gain(fit: Mapping[str, Any]) -> float:
    return float(fit["a"]["log_likelihood"] - fit["u"]["log_likelihood"])


def _others(choice: Mapping[str, Any]) -> str:
    taken = ",".join(map(str, choice["orders"]))
    others = [
        f"{tried} {(gain := value - choice['log_likelihood']):+,.0f}"
        + (f", not the {choice['needed'][tried]:,.0f} it must gain" if gain > 0 else "")
        for tried, value in choice["tried"].items()
        if tried != taken
    ]
    return f" (log L of {'; '.join(others)})" if others else ""
