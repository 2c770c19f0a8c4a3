"""How the figures look: one line style per observer wherever it appears, and the settings for print."""

from __future__ import annotations

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
# where something is asked for that cannot be
INFEASIBLE: Style = {"facecolor": "none", "edgecolor": "0.6", "hatch": "////", "linewidth": 0, "zorder": 0.5}

# one width for all observers
_WIDTH = 1.1
# an observer alone needs no dashes, and noise no width
_ALONE: Style = {"linestyle": "-", "linewidth": 0.8}
# a line in a panel that is a part of a page's width
_NARROW = 0.5
# Okabe and Ito's colours, then three of Tol's; dashes keep them apart in grey too, and where lines coincide the gaps
# show those below
_OBSERVERS: tuple[Style, ...] = tuple(
    {"color": color, "linestyle": dashes, "linewidth": _WIDTH, "zorder": 3 + place / 10}
    for place, (color, dashes) in enumerate(
        (
            ("#0072B2", "-"),
            ("#E69F00", (0, (6, 2))),
            ("#009E73", (0, (4, 1.5, 1, 1.5))),
            ("#CC79A7", (0, (2.5, 1.5))),
            ("#D55E00", (0, (1, 1.5))),
            ("#56B4E9", (0, (5, 1.5, 1, 1.5, 1, 1.5))),
            ("#882255", (0, (8, 1.5, 2.5, 1.5))),
            ("#999933", (0, (2.5, 1.5, 1, 1.5, 1, 1.5))),
            ("#332288", (0, (8, 1.5, 1, 1.5, 1, 1.5))),
        )
    )
)
# of the inside of a band: six of them over each other still show what lies below
_TINT = 0.14
# in a legend: that of any observer
BAND: Style = {"label": "noise, least to largest", "facecolor": ("0.5", _TINT), "edgecolor": "0.5", "linewidth": _WIDTH}

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
    "hatch.linewidth": 0.4,
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
    alone = _ALONE if len(names) == 1 else {}
    return {name: {**_OBSERVERS[known.index(name) % len(_OBSERVERS)], **alone} for name in names}


def observer_colours(names: Sequence[str]) -> dict[str, Style]:
    """The same colours for panels in which each observer is alone: no dashes, and thin where panels are narrow."""
    narrow = {"linewidth": _NARROW} if len(names) > 1 else {}
    return {name: {**look, **_ALONE, **narrow} for name, look in observer_styles(names).items()}


def lines(names: Sequence[str]) -> dict[str, Style]:
    """A line for each of several things that are no observers."""
    return {name: _OBSERVERS[i % len(_OBSERVERS)] for i, name in enumerate(names)}


def band(style: Style) -> Style:
    """The line as the outline of a band, translucent inside."""
    about = {key: style[key] for key in ("linestyle", "linewidth", "zorder")}
    return {**about, "facecolor": (style["color"], _TINT), "edgecolor": style["color"]}


def sure(style: Style) -> Style:
    """Where an estimate may be, below all lines; without an outline, unlike noise."""
    return {"facecolor": (style["color"], _TINT), "edgecolor": "none", "linewidth": 0, "zorder": 1}
