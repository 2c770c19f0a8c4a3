"""The sheet of estimates: one column for each observer, in which nothing hides it, and one scale for a row."""

from collections import Counter

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb

from hillobs.observers import OBSERVERS
from hillobs.studies.figures.estimate import estimate_sheet

# position and forces
MEASURED = 2
ROWS = 11


def panels(dataset: xr.Dataset) -> dict[str, list[Axes]]:
    """The panels of each observer from above, in the order of the Dataset."""
    names = dataset.observer.values.tolist()
    axes = estimate_sheet(dataset).axes[MEASURED:]
    count = len(axes) // len(names)
    return {name: axes[i * count : (i + 1) * count] for i, name in enumerate(names)}


def lines(axes: Axes) -> dict[str, np.ndarray]:
    return {str(line.get_label()): line.get_ydata() for line in axes.lines}


def without_truth(dataset: xr.Dataset) -> xr.Dataset:
    return dataset.drop_vars([name for name in dataset if str(name).startswith("true_")])


@pytest.mark.parametrize("count", [1, 2, 6])
def test_each_observer_is_alone_in_its_panels(noisy: xr.Dataset, count: int) -> None:
    chosen = noisy.isel(observer=slice(0, count))
    shown = panels(chosen)
    places = Counter()
    for name, column in shown.items():
        assert len(column) == ROWS
        assert column[0].get_title() == OBSERVERS[name].label
        for axes in column:
            assert [label for label in lines(axes) if not label.startswith("_")] == [name]
        np.testing.assert_array_equal(lines(column[0])[name], noisy.activation_hat.sel(observer=name, muscle=1).values)
        box = column[0].get_subplotspec()
        places[box.rowspan.start, box.colspan.start] += 1
    assert set(places.values()) == {1}
    colours = {to_rgb(column[0].lines[0].get_color()) for column in shown.values()}
    assert len(colours) == count
    # what was measured has no colour
    for axes in estimate_sheet(chosen).axes[:MEASURED]:
        assert all(len(set(to_rgb(line.get_color()))) == 1 for line in axes.lines)


def test_errors_are_shown_where_the_truth_is_known(noisy: xr.Dataset) -> None:
    one = noisy.isel(observer=[0])
    labels = [axes.get_ylabel() for axes in estimate_sheet(one).axes]
    errors = [label for label in labels if label.startswith("error of")]
    assert errors == ["error of\nactivation 1", "error of\nactivation 2"]
    alone = without_truth(one)
    assert [axes.get_ylabel() for axes in estimate_sheet(alone).axes] == [x for x in labels if x not in errors]
    assert "true" not in [text.get_text() for legend in estimate_sheet(alone).legends for text in legend.get_texts()]
    bridged = alone.isel(time=[0]).assign(bridged=alone.bridged.isel(time=[0]) + 1)
    assert all(axes.collections for axes in estimate_sheet(bridged).axes)


def test_a_row_has_one_scale_unless_an_observer_would_hide_the_others(noisy: xr.Dataset) -> None:
    three = noisy.isel(observer=slice(0, 3))
    same = panels(three)
    for row in zip(*same.values(), strict=True):
        assert len({axes.get_ylim() for axes in row}) == 1
        assert [axes.yaxis.get_tick_params()["labelleft"] for axes in row] == [True, False, False]
    # the innovations of the last one a hundred times as large, or without bounds before it fails
    factor = xr.where(three.observer == three.observer[-1], 100.0, 1.0)
    far = panels(three.assign(tendon_innovation=three.tendon_innovation * factor))
    first, second, third = (column[-1] for column in far.values())
    assert first.get_ylim() == second.get_ylim()
    np.testing.assert_allclose(first.get_ylim(), same["high_gain"][-1].get_ylim(), rtol=0.5)
    assert third.get_ylim()[1] > 8 * first.get_ylim()[1]
    assert third.yaxis.get_tick_params()["labelleft"]
    late = three.time > 2
    failed = three.tendon_innovation.where(~late | (factor == 1), np.nan) * xr.where(three.time > 1.9, factor, 1.0)
    for axes in (column[-1] for column in panels(three.assign(tendon_innovation=failed)).values()):
        assert axes.get_ylim() == first.get_ylim()


@pytest.mark.parametrize(("observer", "suffix"), [("kalman", "_sd"), ("high_gain", "_sd_muscle")])
def test_95_percent_of_each_observer_are_shaded(noisy: xr.Dataset, observer: str, suffix: str) -> None:
    shown = noisy.sel(observer=["high_gain", "kalman"])
    figure = estimate_sheet(shown)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["true", "95 %, without noise for HGO"]
    column = panels(shown)[observer]
    (shade,) = (one for one in column[1].collections if one.get_label() == "95 %")
    of = shown.sel(observer=observer, muscle=2)
    width = 1.96 * of[f"activation{suffix}"]
    corners = {tuple(corner) for path in shade.get_paths() for corner in path.vertices}
    for side in (of.activation_hat - width, of.activation_hat + width):
        assert set(zip(of.time.values, side.values, strict=True)) <= corners
    # nothing is known of what is shown there
    assert "95 %" not in [one.get_label() for one in column[-1].collections]
