"""What the likelihood of a recording has decided, in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def decisions(fit: Mapping[str, Any], settings: Mapping[str, Any]) -> Iterator[str]:
    """Orders, densities and form of a Kalman filter, and what its estimates know."""
    found = orders(fit["u"], "u") if "u" in fit else of_chains(fit["chains"])
    yield f"densities and orders by maximum likelihood: {found}"
    if "a" in fit:
        gain = fit["a"]["log_likelihood"] - fit["u"]["log_likelihood"]
        taken = "taken" if fit["form"] == "a" else "not taken"
        yield f"activations as states, {taken}: {orders(fit['a'], 'a')}; log L {gain:+,.0f}"
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


def of_chains(choices: Mapping[str, Mapping[str, Any]]) -> str:
    """The same of each joint and muscle by its name."""
    return ", ".join(f"{of} {choice['orders'][0]}{_others(choice)}" for of, choice in choices.items())


def _others(choice: Mapping[str, Any]) -> str:
    taken = ",".join(map(str, choice["orders"]))
    others = [
        f"{tried} {(gain := value - choice['log_likelihood']):+,.0f}"
        + (f", not the {choice['needed'][tried]:,.0f} it must gain" if gain > 0 else "")
        for tried, value in choice["tried"].items()
        if tried != taken
    ]
    return f" (log L of {'; '.join(others)})" if others else ""
