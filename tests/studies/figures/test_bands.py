"""Noise as bands: no observer hides another, and no value is left out."""

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

from drawn_figures import draw, legend, line, panels
from hillobs.observers import PAPER
from hillobs.studies.figures import style
from hillobs.studies.figures.run import figures
from hillobs.studies.figures.traces import traces
from hillobs.studies.figures.views import series
from hillobs.studies.simulate.run import simulate


@pytest.fixture(scope="module")
def noisy():
    return simulate("paper-noisy")


def band_of(drawn):
    """Ends of the stretches, lower and upper side of a band."""
    (path,) = drawn.get_paths()
    vertices = path.vertices[:-1]
    # up the one side and back along the other, with a corner more at each turn
    half = len(vertices) // 2
    one, other = vertices[1:half], vertices[half + 1 :][::-1]
    low, high = (one, other) if one[:, 1].sum() < other[:, 1].sum() else (other, one)
    np.testing.assert_array_equal(low[:, 0], high[:, 0])
    return low[:, 0], low[:, 1], high[:, 1]


def test_noise_hides_no_observer(noisy):
    figure = draw(noisy)["inputs"]
    axes = panels(figure, "Delta")[-1]
    dashes = set()
    for name in PAPER:
        (drawn,) = (band for band in axes.collections if band.get_label() == name)
        ((*_, tint),) = drawn.get_facecolor()
        ((*edge, opaque),) = drawn.get_edgecolor()
        assert tint < 0.2 < opaque == 1
        assert to_hex(edge) == to_hex(style.observer_styles(list(PAPER))[name]["color"])
        dashes.add(str(drawn.get_linestyle()))
    assert len(dashes) == len(PAPER)
    assert "noise, least to largest" in legend(figure)


def test_a_band_holds_every_value_and_no_more_than_its_stretch(noisy):
    axes = panels(figures(noisy)["inputs"], "Delta")[-1]
    late = noisy.time.values >= axes.get_xlim()[0]
    for name in PAPER:
        (drawn,) = (band for band in axes.collections if band.get_label() == name)
        ends, low, high = band_of(drawn)
        time, values = noisy.time.values[late], series(noisy, "Delta_hat").sel(observer=name).values[late]
        # spikes beyond one height above or below the axes are cut: they leave the panel anyway
        bottom, top = axes.get_ylim()
        values = np.clip(values, 2 * bottom - top, 2 * top - bottom)
        assert (np.interp(time, ends, low) <= values + 1e-12).all()
        assert (np.interp(time, ends, high) >= values - 1e-12).all()
        assert np.ptp(high) + np.ptp(low) < 4 * np.ptp(values)


def test_a_band_that_rises_is_as_narrow_as_its_noise():
    """Noise of ±1 on a rise of 500: each end of a stretch is off by at most what the noise is."""
    time = np.linspace(0, 1, 20_001)
    axes = Figure().subplots()
    axes.set(xlim=(0, 1), ylim=(0, 500))
    rise = 500 * time + np.resize([1.0, -1.0], time.size)
    looks = style.observer_styles(["a", "b"])
    assert traces(axes, time, {"a": rise, "b": 500 * time}, looks)
    (drawn,) = axes.collections
    _, low, high = band_of(drawn)
    # beside the noise, half a stretch of the rise at the two ends of the axes, where the middle has one side only
    stretch = 500 / 150
    assert (high - low)[2:-2].max() <= 2 * 2 + 1e-9
    assert (high - low).max() <= 2 * 2 + 2 * stretch


def test_what_is_no_number_in_noise_does_not_count():
    time = np.linspace(0, 1, 5_000)
    noise = np.resize([1.0, -1.0], time.size)
    noise[100], noise[1_000:1_200], noise[3_000] = np.inf, np.nan, -np.inf
    axes = Figure().subplots()
    axes.set(xlim=(0, 1), ylim=(-2, 2))
    assert traces(axes, time, {"a": noise, "b": 0 * time}, style.observer_styles(["a", "b"]))
    axes.figure.draw_without_rendering()


def test_an_observer_alone_is_a_line(noisy):
    figure = draw(noisy.sel(observer=["sliding_mode"]))["inputs"]
    axes = panels(figure, "Delta")[-1]
    assert not axes.collections
    np.testing.assert_array_equal(line(axes, "sliding_mode").get_ydata(), series(noisy, "Delta_hat")[1])
    assert legend(figure) == ["true", "SMO"]


def test_all_observers_are_as_wide(noisy):
    for figure in list(draw(noisy).values())[2:]:
        widths = {one.get_linewidth() for axes in figure.axes for one in axes.lines if one.get_label() != "true"}
        widths |= {float(*band.get_linewidth()) for axes in figure.axes for band in axes.collections}
        assert len(widths) == 1
