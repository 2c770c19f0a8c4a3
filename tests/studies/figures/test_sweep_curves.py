"""Curves over one parameter are the medians, with their spread, optimum and failures."""

import numpy as np
import pytest
import xarray as xr

from hillobs.studies.figures.sweep.curves import curves
from hillobs.studies.sweep.optimum import errors, failed, medians
from hillobs.studies.sweep.run import sweep
from short_sweeps import EPS, SHORT, legend, replaced


def test_curves_are_the_medians_with_their_optimum(line: xr.Dataset) -> None:
    figure = curves(line, ["x2", "a1", "u2"])
    optima = ["optimum", "smallest, no optimum"]
    assert [text for text in legend(figure) if text not in optima] == [
        "HGO", "SMO", "⅔ of the seeds", "gain condition fails", "scenario's value", "runs failed",
    ]  # fmt: skip
    for quantity, axes in zip(("x2", "a1", "u2"), figure.axes, strict=True):
        median = medians(line).sel(observer="high_gain", quantity=quantity)
        hgo, mark, crosses, smo, own = axes.lines
        np.testing.assert_array_equal(hgo.get_xydata(), np.column_stack([EPS, median.values]))
        assert mark.get_xydata().tolist() == [[float(median.idxmin()), float(median.min())]]
        assert crosses.get_xdata().tolist() == [eps for eps in EPS if failed(line).sel({"high_gain.eps_h": eps}).any()]
        # ε_h is not the other one's to choose: a line, no optimum
        assert len(set(smo.get_ydata())) == 1
        assert list(own.get_xdata()) == [0.1, 0.1]
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")


@pytest.mark.parametrize(("place", "hollow"), [(0, True), (1, True), (2, False), (4, True)])
def test_a_mark_is_hollow_at_an_edge_and_where_a_condition_fails(layer: xr.Dataset, place: int, hollow: bool) -> None:
    """The errors are set: the smallest one at each place in turn; the first two points break a condition."""
    rmse = np.full(layer.failed_at.shape, 2.0)
    rmse[place] = 1.0
    dataset = replaced(layer, rmse, np.zeros(layer.failed_at.shape, dtype=bool))
    figure = curves(dataset, ["x2"])
    (mark,) = (one for one in figure.axes[0].lines if one.get_marker() == "o")
    assert mark.get_xdata().tolist() == [dataset["sliding_mode.delta_s"].values[place]]
    assert (mark.get_markerfacecolor() == "white") == hollow
    assert ("smallest, no optimum" in legend(figure), "optimum" in legend(figure)) == (hollow, not hollow)


def test_where_a_condition_fails_is_hatched(layer: xr.Dataset) -> None:
    """λ₁₁, which is below its bound everywhere, hatches nothing."""
    (axes,) = curves(layer, ["x2"]).axes
    spans = [patch for patch in axes.patches if patch.get_hatch()]
    boxes = [span.get_window_extent().transformed(axes.transData.inverted()) for span in spans]
    hatched = [any(box.x0 <= value <= box.x1 for box in boxes) for value in layer["sliding_mode.delta_s"].values]
    assert hatched == [True, True, False, False, False]


def test_the_spread_holds_two_thirds_of_the_seeds() -> None:
    seeds = sweep("paper-noisy", {"high_gain.eps_h": [0.05, 0.1, 0.2]}, 31, changes=SHORT)
    (band,) = curves(seeds, ["x2"]).axes[0].collections
    rmse = errors(seeds).sel(observer="high_gain", quantity="x2")
    (vertices,) = (path.vertices for path in band.get_paths())
    for i, eps in enumerate((0.05, 0.1, 0.2)):
        edges = vertices[vertices[:, 0] == eps, 1]
        inside = (rmse[i] >= edges.min()) & (rmse[i] <= edges.max())
        assert 20 <= int(inside.sum()) <= 22


def test_a_sweep_without_noise_is_drawn_beside(line: xr.Dataset) -> None:
    clean = sweep("paper-clean", {"high_gain.eps_h": EPS}, 1, ["high_gain", "sliding_mode"], SHORT)
    figure = curves(line, ["x2"], clean)
    assert "without noise" in legend(figure)
    drawn_lines = [list(one.get_ydata()) for one in figure.axes[0].lines if one.get_color() == "black"]
    expected = medians(clean).sel(quantity="x2")
    np.testing.assert_array_equal(drawn_lines, expected.transpose("observer", ...).values)


def test_a_parameter_with_one_value_takes_no_room(line: xr.Dataset) -> None:
    swept = sweep("paper-noisy", {"plant.m": [1.0], "high_gain.eps_h": EPS[::-1]}, 3, "high_gain", SHORT)
    one, other = (curves(each, ["x2"]).axes[0].lines[0] for each in (swept, line))
    np.testing.assert_array_equal(one.get_xydata(), other.get_xydata())
