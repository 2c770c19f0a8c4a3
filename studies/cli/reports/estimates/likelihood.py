"""What the likelihood of a recording has decided, in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def decisions(fit: Mapping[str, Any], settings: Mapping[str, Any]) -> Iterator[str]:
    """Orders, densities and form of a Kalman filter, and what its estimates know."""
    inputs = fit["u"]
    yield f"densities and orders by maximum likelihood: {orders(inputs, 'u')}"
    if "a" in fit:
        gain = fit["a"]["log_likelihood"] - inputs["log_likelihood"]
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
    others = [
        f"{tried} {(gain := value - choice['log_likelihood']):+,.0f}"
        + (f", not the {choice['needed'][tried]:,.0f} it must gain" if gain > 0 else "")
        for tried, value in choice["tried"].items()
        if tried != f"{D},{other}"
    ]
    return f"Δ {D}, {second} {other}" + (f" (log L of {'; '.join(others)})" if others else "")
