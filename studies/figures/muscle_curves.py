"""All curve sets side by side, each with its own numbers."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ...model.curves import CURVES, SIMULATED, sampled
from . import style
from .page import settings

_POINTS = 801
_HEIGHT = 4.6  # inches

# where each curve is drawn, what is on the axes, and which values are of interest
_PANELS = (
    ("Phi_S", (1.98, 2.08), r"$L_S$", r"$\Phi_S$", (-0.15, 1.5)),
    ("Phi_P", (0.5, 1.75), r"$L_C$", r"$\Phi_P$", (-0.05, 1.5)),
    ("f", (0.3, 1.9), r"$L_C$", r"$f$", (-0.05, 1.05)),
    ("g", (-1.0, 1.0), r"$u$ (shortening > 0)", r"$g$", (-0.05, 1.85)),
)


def curve_figure() -> Figure:
    """Tendon force, passive force, force-length and force-velocity factor of every set that a scenario can choose."""
    lines = style.lines(SIMULATED)
    with settings():
        figure = Figure(figsize=(style.PAGE, _HEIGHT), layout="constrained")
        for axes, (name, span, across, up, limits) in zip(figure.subplots(2, 2).flat, _PANELS, strict=True):
            x = np.linspace(*span, _POINTS)
            for key, line in lines.items():
                numbers = {path: parameter.default for path, parameter in CURVES[key].parameters.items()}
                axes.plot(x, sampled(getattr(CURVES[key], name), numbers, x), **line)
            axes.set(xlim=span, ylim=limits, xlabel=across, ylabel=up)
        figure.legend(handles=list(_legend(lines)), loc="outside upper center", ncols=len(lines))
    return figure


def _legend(lines: dict[str, style.Style]) -> Iterator[Line2D]:
    for name, line in lines.items():
        yield Line2D([], [], label=name, **line)
