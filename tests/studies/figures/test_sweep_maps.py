"""Maps over two parameters are the medians, with the best values, hatches and the scenario."""

import numpy as np
import xarray as xr
from matplotlib.collections import PolyCollection, QuadMesh

from hillobs.studies.figures.sweep.maps import maps
from hillobs.studies.sweep.optimum import failed, medians, violated
from hillobs.studies.sweep.run import sweep
from short_sweeps import EPS, SHORT, drawn, legend


def test_a_map_has_the_medians_the_hatches_and_the_best_values(plane: xr.Dataset) -> None:
    figure = maps(plane, "high_gain", ["x2", "a1"])
    assert legend(figure)[0] == "HGO, 3 seeds"
    assert legend(figure)[-3:] == ["scenario's values", "gain condition fails", "runs failed"]
    lost = failed(plane).sel(observer="high_gain").any("seed")
    # h h₁₁/ε_h < 2.78 fails at the first of EPS
    broken = violated(plane, "high_gain").any("condition")
    for quantity, axes in zip(("x2", "a1"), figure.axes, strict=False):
        median = medians(plane).sel(observer="high_gain", quantity=quantity)
        (mesh,) = (one for one in axes.collections if isinstance(one, QuadMesh))
        np.testing.assert_array_equal(mesh.get_array().filled(np.nan), median.values.T)
        hatched = [one for one in axes.collections if type(one) is PolyCollection]
        for each, where_ in zip(hatched, (lost, broken), strict=True):
            assert each.get_hatch()
            cells = [path.get_extents() for path in each.get_paths()]
            inside = {
                (i, j)
                for i, eps in enumerate(EPS)
                for j, noise in enumerate(plane["noise.x1"].values)
                if any(cell.contains(eps, noise) for cell in cells)
            }
            assert inside == {tuple(place) for place in np.argwhere(where_.values).tolist()} != set()
        ridge, *marks, own = axes.lines
        for mark, eps in zip(marks, median.idxmin("high_gain.eps_h").values, strict=True):
            assert mark.get_xdata() == eps
            assert (mark.get_markerfacecolor() == "none") == (eps in (EPS[0], EPS[1], EPS[-1]))
        np.testing.assert_array_equal(ridge.get_xdata(), median.idxmin("high_gain.eps_h").values)
        np.testing.assert_array_equal(ridge.get_ydata(), plane["noise.x1"].values)
        assert (list(own.get_xdata()), list(own.get_ydata())) == ([0.1], [0.001])
        assert (axes.get_xscale(), axes.get_yscale()) == ("log", "linear")


def test_two_parameters_of_one_observer_have_one_optimum() -> None:
    over = {"high_gain.eps_h": [0.05, 0.1, 0.2], "high_gain.h11": [3.0, 2.0]}
    swept = sweep("paper-noisy", over, 2, changes=SHORT)
    median = medians(swept).sel(observer="high_gain", quantity="x2")
    mark = maps(swept, "high_gain", ["x2"]).axes[0].lines[1]
    (((eps, h11),),) = (mark.get_xydata().tolist(),)
    assert float(median.sel({"high_gain.eps_h": eps, "high_gain.h11": h11})) == float(median.min())


def test_no_map_of_an_observer_that_nothing_changes() -> None:
    over = {"high_gain.eps_h": [0.05, 0.1, 0.2], "high_gain.h11": [2.0, 3.0]}
    swept = sweep("paper-noisy", over, 2, ["high_gain", "sliding_mode"], SHORT)
    figures, sentence = drawn(swept, "x2")
    assert list(figures) == ["map-high_gain"]
    assert sentence == "no map of SMO: high_gain.eps_h and high_gain.h11 do not change it"
