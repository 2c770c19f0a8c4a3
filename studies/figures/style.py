"""How the figures look: one line style per observer wherever it appears, and the settings for print."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from ...observers import OBSERVERS

Style = dict[str, Any]

COLUMN = 3.4  # inches, one column of a two-column page
PAGE = 7.0

TRUE: Style = {"color": "black", "linestyle": (0, (4, 3)), "linewidth": 0.8, "zorder": 5}
REFERENCE: Style = {"color": "#AA4499", "linestyle": "-", "linewidth": 1.8, "zorder": 3}
MEASURED: Style = {"color": "0.72", "linestyle": "-", "linewidth": 0.5, "zorder": 2}
SLACK: Style = {"facecolor": "0.9", "edgecolor": "none", "zorder": 0}

# Okabe and Ito's colours; widths, dashes and lightness keep them apart in grey too.
# Wide lines lie below, dashed ones on top, so that each shows what it covers.
_OBSERVERS: tuple[Style, ...] = (
    {"color": "#0072B2", "linestyle": "-", "linewidth": 1.1, "zorder": 3.2},
    {"color": "#E69F00", "linestyle": "-", "linewidth": 2.2, "zorder": 3.0},
    {"color": "#009E73", "linestyle": (0, (6, 1.5, 1.2, 1.5)), "linewidth": 1.0, "zorder": 3.4},
    {"color": "#CC79A7", "linestyle": (0, (3, 1)), "linewidth": 1.5, "zorder": 3.3},
    {"color": "#D55E00", "linestyle": (0, (1, 1)), "linewidth": 1.3, "zorder": 3.5},
    {"color": "#56B4E9", "linestyle": "-", "linewidth": 1.7, "zorder": 3.1},
)
# a line that travels up and down more panel heights than this would become a solid area
_CALM = 15.0

RC: dict[Any, Any] = {
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "font.size": 9,
    "axes.labelsize": 9,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "legend.handlelength": 2.8,
    "axes.linewidth": 0.6,
    "axes.formatter.useoffset": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "0.85",
    "grid.linewidth": 0.4,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "lines.solid_joinstyle": "round",
    "lines.dash_joinstyle": "round",
    "lines.dash_capstyle": "butt",
    "savefig.dpi": 300,
    "pdf.fonttype": 42,  # TrueType: journals refuse Type 3
}


def observer_styles(names: Sequence[str]) -> dict[str, Style]:
    """The line of each observer: by its place in the registry; others follow in the order given."""
    known = [*OBSERVERS, *(name for name in names if name not in OBSERVERS)]
    return {name: _OBSERVERS[known.index(name) % len(_OBSERVERS)] for name in names}


def lines(names: Sequence[str]) -> dict[str, Style]:
    """A line for each of several things that are no observers."""
    return {name: _OBSERVERS[i % len(_OBSERVERS)] for i, name in enumerate(names)}


def thinned(style: Style, travel: float) -> Style:
    """The line as it is drawn where it moves up and down by `travel` panel heights: noise is thin and lies below."""
    if travel <= _CALM:
        return style
    share = math.sqrt(_CALM / travel)
    return {**style, "linestyle": "-", "linewidth": max(0.35, 1.1 * share), "zorder": 2 + share}
