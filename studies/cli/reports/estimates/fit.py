"""What a fit has to say, and its numbers as a scenario file."""

from __future__ import annotations

from collections.abc import Iterator

from .....observers import label
from ....estimate.fit import Fitted
from ....estimate.run import KALMAN
from ....files.toml import toml_numbers
from .likelihood import orders_of_inputs

_OF_SCENARIO = "hillobs simulate THIS_FILE"
_OF_RECORDING = "hillobs estimate RECORDING --{kind} FILE.toml --observer kalman --set THIS_FILE"


def sentences(found: Fitted) -> Iterator[str]:
    """The orders and why, then the numbers."""
    yield f"{found.label}: {found.samples:,} samples"
    yield f"{label(KALMAN)}: orders by maximum likelihood: {orders_of_inputs(found.choice)}"
    numbers = (f"{path.partition('.')[2]} = {value:.3g}" for path, value in found.numbers.items())
    yield f"{label(KALMAN)}: noise from the samples, densities by maximum likelihood: {', '.join(numbers)}"


def scenario_file(found: Fitted) -> str:
    """The scenario with the numbers, or the numbers alone, as TOML that says what it is for."""
    kind = "mechanism" if "chains" in found.choice else "muscles"
    comments = [
        f"for {found.label}: the numbers of the Kalman filter for which what was measured is likeliest",
        _OF_SCENARIO if found.scenario else _OF_RECORDING.format(kind=kind),
    ]
    return toml_numbers(comments, {**found.scenario, **found.numbers})
