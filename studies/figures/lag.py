"""How good estimates are over the delay that they may have."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator, ScalarFormatter

from ...model.arrays import Array
from . import style
from .page import above, settings


def lag_figure(lags: Array, panels: Mapping[str, Mapping[str, tuple[Sequence[float], float]]]) -> Figure:
    """Panels by label, and in each the RMSE over the lags in s, and with all samples (dotted), by the line's name."""
    names = list(next(iter(panels.values())))
    looks = style.lines(names)
    with settings():
        figure = Figure(figsize=(style.PAGE, 2.6), layout="constrained")
        for axes, (label, rmse) in zip(figure.subplots(1, len(panels)), panels.items(), strict=True):
            for name, (late, all_known) in rmse.items():
                axes.plot(1e3 * lags, late, label=name, marker="o", markersize=2.5, **looks[name])
                axes.axhline(all_known, **{**looks[name], "linestyle": ":"})
            axes.set_xscale("symlog", linthresh=1e3 * lags[1], linscale=0.3)
            axes.set_xticks(1e3 * lags)
            axes.xaxis.set_major_formatter(ScalarFormatter())
            axes.xaxis.set_minor_locator(NullLocator())
            axes.set_xlim(-0.2e3 * lags[1], 1.2e3 * lags[-1])
            axes.set_ylim(bottom=0)
            axes.set_xlabel("lag in ms")
            axes.set_ylabel(label)
        above(figure, figure.axes[0].get_legend_handles_labels()[0])
        return figure
