"""The optimum of a sweep: sought over what can be chosen, and none at an edge, by luck or where a condition fails."""

import numpy as np
import pytest
import xarray as xr

from hillobs.studies.cli.reports.sweep import notes, tables
from hillobs.studies.figures.sweep.curves import curves
from hillobs.studies.sweep.optimum import at_scenario, medians, optimum
from hillobs.studies.sweep.run import sweep
from short_sweeps import EPS, LAYER, SHORT, legend, printed, replaced


def test_what_survives_by_luck_is_no_optimum(line: xr.Dataset) -> None:
    """The smallest errors belong to a point where two of three runs failed."""
    rmse = np.broadcast_to(np.array([1.0, 5, 4, 3, 6])[:, None, None], line.failed_at.shape)
    lost = np.zeros(line.failed_at.shape, dtype=bool)
    lost[0, :2], lost[3, 0] = True, True
    median = medians(replaced(line, rmse, lost)).sel(observer="high_gain", quantity="x2")
    assert np.isnan(median.values[0])
    assert optimum(line, median, "high_gain").values == {"high_gain.eps_h": 0.1}
    assert float(median[3]) == 3


def test_an_optimum_is_sought_over_what_can_be_chosen(plane: xr.Dataset) -> None:
    """ε_h, for the noise of the scenario; not the noise."""
    assert list(plane.observer.values) == ["high_gain"]
    median = medians(plane).sel(observer="high_gain", quantity="x2")
    best = optimum(plane, median, "high_gain")
    assert best.values["noise.x1"] == 0.001
    assert best.error == float(median.sel({"noise.x1": 0.001}).min())
    assert at_scenario(plane, median) == float(median.sel({"noise.x1": 0.001, "high_gain.eps_h": 0.1}))
    assert "smallest over high_gain.eps_h, at noise.x1 = 0.001, the nearest to the scenario's" in list(notes(plane))


def test_an_optimum_at_the_end_of_what_was_swept_is_an_edge(line: xr.Dataset) -> None:
    """The errors are set: with the smallest first, inside, last."""
    none_lost = np.zeros(line.failed_at.shape, dtype=bool)
    for place, edge in ((0, True), (2, False), (4, True)):
        rmse = np.full(line.failed_at.shape, 2.0)
        rmse[place] = 1.0
        dataset = replaced(line, rmse, none_lost)
        best = optimum(dataset, medians(dataset).sel(observer="high_gain", quantity="x2"), "high_gain")
        assert best.values["high_gain.eps_h"] == EPS[place]
        assert best.edges == (("high_gain.eps_h",) if edge else ())
        assert any(said.startswith("edge: ") for said in notes(dataset)) == edge


def test_an_optimum_where_a_condition_fails_says_which(layer: xr.Dataset) -> None:
    """λ₁₁ is below its bound at all points: the notes say so, and no row repeats it."""
    rmse = np.broadcast_to(np.array([9.0, 1, 2, 3, 4])[:, None, None], layer.failed_at.shape)
    dataset = replaced(layer, rmse, np.zeros(layer.failed_at.shape, dtype=bool))
    best = optimum(dataset, medians(dataset).sel(observer="sliding_mode", quantity="x2"), "sliding_mode")
    (place,) = best.violated
    assert not best.edges
    assert not best.inside
    assert dataset.condition.values[place] == LAYER
    said = list(notes(dataset))
    number = next(text for text in said if LAYER in text)
    assert number.startswith(f"gain condition ({place + 1}) of SMO: ")
    rows = [text for text in printed(tables(dataset)[0]) if text.startswith("SMO")]
    assert rows
    assert all(row.endswith(f"({place + 1}) fails") for row in rows)


def test_a_parameter_of_the_plant_has_no_optimum_but_a_spread() -> None:
    swept = sweep("paper-noisy", {"plant.m": [0.8, 1.0, 1.2]}, 3, ["high_gain", "sliding_mode"], SHORT)
    median = medians(swept).sel(observer="sliding_mode", quantity="x2")
    assert optimum(swept, median, "sliding_mode") is None
    (table,) = tables(swept)
    assert printed(table)[1].split() == ["quantity", "own", "median", "median", "change"]
    (row,) = (text.split() for text in printed(table) if text.startswith("SMO x2"))
    least, largest = float(median.min()), float(median.max())
    assert row[-2:] == [f"{100 * (largest / least - 1):.2g}", "%"]
    assert "optimum" not in legend(curves(swept, ["x2"]))


@pytest.mark.parametrize(("kind", "over"), [("zip", [0.0005, 0.002, 0.004]), ("grid", [17.0, 19.0])])
def test_what_cannot_be_held_leaves_no_optimum(kind: str, over: list[float]) -> None:
    """Points that move with the noise; a scenario whose muscles differ."""
    path = "noise.x1" if kind == "zip" else "muscle.k"
    eps = [0.05, 0.1, 0.2][: len(over)]
    changes = {**SHORT, **({} if kind == "zip" else {"muscle1.k": 18.0})}
    swept = sweep("paper-noisy", {"high_gain.eps_h": eps, path: over}, 2, "high_gain", changes, kind=kind)
    assert optimum(swept, medians(swept).sel(observer="high_gain", quantity="x2"), "high_gain") is None
    words = f"no optimum over high_gain.eps_h: {path} cannot be held at one value of the scenario's"
    assert words in list(notes(swept))


def test_the_scenarios_own_value_is_not_made_up() -> None:
    outside = sweep("paper-clean", {"high_gain.eps_h": [0.2, 0.3]}, changes=SHORT)
    assert np.isnan(at_scenario(outside, medians(outside).sel(observer="high_gain", quantity="x2")))
    untied = sweep("paper-clean", {"muscle.k": [19.0, 20.0]}, changes={**SHORT, "muscle1.k": 19.5})
    assert "scenario_value" not in untied["muscle.k"].attrs
