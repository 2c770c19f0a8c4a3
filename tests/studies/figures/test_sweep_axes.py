"""The axes of a sweep have symbols, the scale of their values, and numbers that are not crowded."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from hillobs.studies.figures.sweep.curves import curves
from hillobs.studies.figures.sweep.maps import maps
from hillobs.studies.figures.sweep.panels import number
from hillobs.studies.figures.symbols import symbol
from hillobs.studies.scenarios.prepare import prepare
from hillobs.studies.sweep.optimum import logarithmic


@pytest.mark.parametrize(
    ("path", "expected"),
    [
        ("high_gain.eps_h", r"$\varepsilon_{h}$"),
        ("sliding_mode.lambda11", r"$\lambda_{11}$"),
        ("adaptive_sliding_mode.a_dual", "$a$"),
        ("adaptive_sliding_mode.k_max", r"$k_{\mathrm{max}}$"),
        ("sliding_mode.delta_L", r"SMO $\delta_{L}$"),
        ("high_gain.m", "HGO $m$"),
        ("high_gain_3.eps_h", r"HGO3 $\varepsilon_{h}$"),
        ("plant.m", "$m$"),
        ("mine.gain", "mine gain"),
        ("muscle1.k", "muscle 1 $k$"),
        ("initial.x1_hat", r"initial $\hat{x}_{1}$"),
        ("noise.force", "noise force"),
        ("adaptive_sliding_mode.leak", "ASMO leak"),
        ("step", "step"),
    ],
)
def test_an_axis_has_its_symbol_and_an_owner_where_names_are_shared(path: str, expected: str) -> None:
    assert symbol(path) == expected


def test_every_parameter_has_a_symbol_that_can_be_drawn_and_is_its_own() -> None:
    parameters = prepare("paper-noisy", None, {}).paths.parameters
    symbols = {path: symbol(path) for path in parameters}
    shared = {text for text in symbols.values() if list(symbols.values()).count(text) > 1}
    assert not shared
    figure = Figure(figsize=(10, 60))
    for i, text in enumerate(symbols.values()):
        figure.text(0.1, i / len(symbols), text)
    figure.draw_without_rendering()


def test_axes_are_labelled_by_symbols(line: xr.Dataset, plane: xr.Dataset) -> None:
    assert curves(line, ["x2"]).axes[0].get_xlabel() == symbol("high_gain.eps_h")
    axes = maps(plane, "high_gain", ["x2"]).axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == (symbol("high_gain.eps_h"), symbol("noise.x1"))


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([1, 2, 4, 8], True),
        ([1, 2, 3, 4], False),
        ([0, 1, 10], False),
        ([1, 10], False),
        ([1, 1.1, 1.21], False),
        ([0.05, 0.1, 0.2, 0.5], True),
    ],
)
def test_a_scale_is_that_of_the_values(values: list[float], expected: bool) -> None:
    assert logarithmic(np.array(values, dtype=float)) is expected


@pytest.mark.parametrize("room", [3, 5, 6])
@pytest.mark.parametrize(
    ("low", "high"), [(1e-4, 0.1), (0.02, 0.5), (3.1e-3, 5.5e-3), (1.01e-3, 1.04e-3), (7e-3, 0.0161), (1e-12, 1e3)]
)
def test_an_axis_has_numbers_and_they_are_not_crowded(low: float, high: float, room: int) -> None:
    axes = Figure().subplots()
    axes.set_xscale("log")
    axes.set_xlim(low, high)
    number(axes.xaxis, low, high, room)
    inside = [tick for tick in axes.xaxis.get_majorticklocs() if low <= tick <= high]
    assert 2 <= len(inside) <= room + 1
    texts = [axes.xaxis.get_major_formatter()(tick) for tick in inside]
    assert len(set(texts)) == len(texts)
