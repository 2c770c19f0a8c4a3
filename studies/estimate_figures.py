"""A sheet of what was measured, what was estimated, and what the measurements still disagree with."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from ..observers import label
from . import style
from .figures import settings

# points of a line that a page can show
_MOST_POINTS = 4000
_ROW = 1.15  # inches
# what is drawn, its unit on paper, and the factor to it
_ROWS: Sequence[tuple[str, str, float]] = (
    ("activation_1", "activation 1", 1.0),
    ("activation_2", "activation 2", 1.0),
    ("velocity", "velocity\nmm/s", 1e3),
    ("fibre_length_1", "fibre 1\nmm", 1e3),
    ("fibre_length_2", "fibre 2\nmm", 1e3),
    ("disturbance", "disturbance\nN", 1.0),
)


def estimate_sheet(dataset: xr.Dataset) -> Figure:
    """Position and forces; estimates of each observer beside the truth, if it is known; innovations."""
    thin = dataset.isel(time=slice(None, None, -(-dataset.sizes["time"] // _MOST_POINTS)))
    looks = style.observer_styles(dataset.observer.values.tolist())
    t = thin.time.values
    with settings():
        rows = len(_ROWS) + 4
        figure = Figure(figsize=(style.PAGE, _ROW * rows), layout="constrained")
        axes = list(figure.subplots(rows, 1, sharex=True))
        axes[0].plot(t, thin.position.values * 1e3, color="black", linewidth=0.8)
        axes[0].set_ylabel("position\nmm")
        for j, look in zip((1, 2), style.lines(["1", "2"]).values(), strict=True):
            axes[1].plot(t, thin.force.sel(muscle=j).values, **{**look, "linewidth": 0.9}, label=f"tendon {j}")
        axes[1].set_ylabel("force\nN")
        axes[1].legend(loc="lower right", ncols=2)
        for panel, (name, words, factor) in zip(axes[2:], _ROWS, strict=False):
            _estimates(panel, thin, looks, name, factor)
            panel.set_ylabel(words)
        for name, look in looks.items():
            of = thin.sel(observer=name)
            axes[-2].plot(t, of.position_innovation.values * 1e3, **{**look, "linewidth": 0.6})
            for j in (1, 2):
                axes[-1].plot(t, of.tendon_innovation.sel(muscle=j).values * 1e3, **{**look, "linewidth": 0.6})
        axes[-2].set_ylabel("innovation of\nposition, mm")
        axes[-1].set_ylabel("of tendon\nlengths, mm")
        axes[-1].set_xlabel("time, s")
        _mark(axes, thin)
        handles = [Line2D([], [], label=label(name), **look) for name, look in looks.items()]
        if any(f"true_{name.rstrip('_12')}" in dataset for name, _, _ in _ROWS):
            handles.append(Line2D([], [], label="true", **style.TRUE))
        figure.legend(handles=handles, loc="outside upper center", ncols=len(handles))
    return figure


def _estimates(axes: Axes, thin: xr.Dataset, looks: dict[str, style.Style], name: str, factor: float) -> None:
    base, _, muscle = name.rpartition("_") if name[-1] in "12" else (name, "", "")

    def of(variable: str) -> xr.DataArray:
        found = thin[variable]
        return found.sel(muscle=int(muscle)) if muscle else found

    estimates = of(f"{base}_hat")
    for observer, look in looks.items():
        axes.plot(thin.time.values, estimates.sel(observer=observer).values * factor, **look)
    shown = [estimates]
    if f"true_{base}" in thin:
        shown.append(of(f"true_{base}"))
        axes.plot(thin.time.values, shown[-1].values * factor, **style.TRUE)
    if base == "activation":
        axes.set_ylim(-0.03, 1.03)
    else:
        # the first moments may be wild
        late = np.concatenate([a.isel(time=slice(thin.sizes["time"] // 50, None)).values.ravel() for a in shown])
        late = late[np.isfinite(late)] * factor
        if late.size and late.max() > late.min():
            margin = 0.08 * (late.max() - late.min())
            axes.set_ylim(late.min() - margin, late.max() + margin)


def _mark(axes: Sequence[Axes], thin: xr.Dataset) -> None:
    """Slack tendons and bridged gaps as grey bands."""
    grey = (thin.slack.values > 0).any(axis=1) | (thin.bridged.values > 0)
    if grey.any():
        for panel in axes:
            panel.fill_between(thin.time.values, 0, 1, where=grey, transform=panel.get_xaxis_transform(), **style.SLACK)
