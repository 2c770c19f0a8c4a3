"""Every sweep has the figures of its kind, and the same sweep the same files."""

from pathlib import Path

import numpy as np
import xarray as xr

from hillobs.studies.figures.sweep.figures import save_sweep_figures
from hillobs.studies.files.pictures import WITH_PDF
from hillobs.studies.sweep.run import sweep
from places import contents
from short_sweeps import SHORT, drawn, legend, replaced


def test_every_kind_of_sweep_has_its_figure(line: xr.Dataset, plane: xr.Dataset) -> None:
    for dataset, name in ((line, "curves"), (plane, "map-high_gain")):
        figures, sentence = drawn(dataset, "x2")
        assert (list(figures), sentence) == ([name], "")
    three = {"high_gain.eps_h": [0.1, 0.2], "high_gain.h11": [3.0, 4.0], "noise.x1": [0.0, 0.001]}
    for kind, words in (("grid", "more than two parameters"), ("zip", "points that are no grid")):
        swept = sweep("paper-noisy", three, 2, changes=SHORT, kind=kind)
        figures, sentence = drawn(swept, "x2", "a1")
        assert words in sentence
        axes = figures["points"].axes
        assert len(axes) == 2 * len(three)
        assert all(len(one.lines[0].get_xdata()) == swept.failure.isel(seed=0).size for one in axes)
    assert drawn(sweep("paper-clean", changes=SHORT)) == ({}, "no figure: no parameter has more than one value")


def test_a_sweep_without_a_single_number_is_drawn(line: xr.Dataset, plane: xr.Dataset) -> None:
    for dataset in (line, plane):
        figures, _ = drawn(replaced(dataset, np.nan, True), "x2")
        (figure,) = figures.values()
        assert "runs failed" in legend(figure)
        assert [text.get_text() for text in figure.axes[0].texts] == ["no numbers"]


def test_the_same_sweep_gives_the_same_files(layer: xr.Dataset, plane: xr.Dataset, tmp_path: Path) -> None:
    """With hatches, hollow marks and bands."""
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        for stem, dataset in (("layer", layer), ("plane", plane)):
            save_sweep_figures(dataset.sel(quantity=["x2", "a1"]), tmp_path / name, stem, WITH_PDF)
    first, second = (contents(tmp_path / name) for name in ("one", "two"))
    assert first == second
    assert len(first) == 4
