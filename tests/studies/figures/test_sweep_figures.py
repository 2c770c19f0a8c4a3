"""What a sweep shows: causes of failures, optima, gain conditions, and figures that say what the Dataset says."""

import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table

from hillobs.studies.cli.reports.sweep import notes, tables
from hillobs.studies.figures.sweep.curves import curves
from hillobs.studies.figures.sweep.figures import save_sweep_figures, sweep_figures
from hillobs.studies.figures.sweep.maps import maps
from hillobs.studies.figures.sweep.panels import number
from hillobs.studies.figures.symbols import symbol
from hillobs.studies.files.netcdf import load, save_netcdf
from hillobs.studies.scenarios.prepare import prepare
from hillobs.studies.simulate.run import simulate
from hillobs.studies.sweep.axes import Axes, Range
from hillobs.studies.sweep.optimum import at_scenario, errors, failed, logarithmic, medians, optimum, violated
from hillobs.studies.sweep.region import where
from hillobs.studies.sweep.run import sweep

SHORT = {"duration": 0.2, "score.start": 0.05}
# the first two are too small for the step
EPS = [5e-5, 2e-4, 2e-2, 0.1, 0.5]


@pytest.fixture(scope="module")
def line() -> xr.Dataset:
    return sweep("paper-noisy", {"high_gain.eps_h": EPS}, 3, ["high_gain", "sliding_mode"], SHORT)


@pytest.fixture(scope="module")
def plane() -> xr.Dataset:
    over = {"high_gain.eps_h": EPS, "noise.x1": Range(0, 0.004, 5)}
    return sweep("paper-noisy", over, 3, changes=SHORT)


@pytest.fixture(scope="module")
def layer() -> xr.Dataset:
    """Over δ_s = δ_L, from where its integration condition fails: h α/δ_L < 2.5 is δ_L > 2.2e-4."""
    over = {"sliding_mode.delta_s": [1e-4, 2e-4, 1e-3, 1e-2, 1e-1]}
    return sweep("paper-noisy", over, 3, ["sliding_mode", "high_gain"], SHORT)


def cause(variable: xr.DataArray) -> str:
    return variable.attrs["flag_meanings"].split()[int(variable)]


def drawn(dataset: xr.Dataset, *quantities: str) -> tuple[dict[str, Figure], str]:
    """The figures of some quantities, drawn to the last tick but not written; warnings are errors here."""
    found, sentence = sweep_figures(dataset.sel(quantity=list(quantities)) if quantities else dataset)
    for figure in found.values():
        figure.draw_without_rendering()
    return found, sentence


def printed(table: Table) -> list[str]:
    """The lines of a table on a terminal that is wide enough."""
    console = Console(width=200)
    with console.capture() as text:
        console.print(table)
    return [line.rstrip() for line in text.get().splitlines()]


def legend(figure: Figure) -> list[str]:
    (only,) = figure.legends
    return [text.get_text() for text in only.get_texts()]


def replaced(dataset: xr.Dataset, rmse: object, lost: object) -> xr.Dataset:
    """The Dataset with these errors of every quantity, and these runs lost (…, seed, observer)."""
    result = dataset.copy(deep=True)
    result.rmse[:] = np.asarray(rmse)[..., None]
    result.failed_at[:] = np.where(lost, 0.1, np.nan)
    result.rmse[:] = result.rmse.where(result.failed_at.isnull())
    return result


# ---------------------------------------------------------------- why


def test_a_failure_has_the_cause_and_the_time_that_the_run_alone_has(line: xr.Dataset) -> None:
    for eps in EPS:
        alone = simulate("paper-noisy", "high_gain", {**SHORT, "high_gain.eps_h": eps, "seed": 2})
        point = line.sel({"high_gain.eps_h": eps, "seed": 2, "observer": "high_gain"})
        said = json.loads(alone.attrs["failures"]).get("high_gain")
        if said is None:
            assert np.isnan(point.failed_at)
            assert cause(point.failure) == "none"
        else:
            assert said.startswith(f"high_gain: {cause(point.failure)} is not a finite number")
            assert f"at τ = {float(point.failed_at):g};" in said
    assert line.failure.sel({"high_gain.eps_h": 5e-5, "observer": "high_gain"}).all()


def test_a_plant_that_fails_says_which_length_left_its_domain() -> None:
    found = sweep("paper-clean", {"initial.x1": [2.6, 5.0]}, 2, "high_gain", SHORT)
    assert [cause(one) for one in found.plant_failure.isel(seed=1)] == ["none", "L_C2"]
    assert not found.failure.any()
    assert "commonest cause: L_C2 (2 runs), at 1 of 2 points, all with initial.x1 = 5" in "\n".join(notes(found))


def test_causes_are_kept_in_a_file(line: xr.Dataset, tmp_path: Path) -> None:
    save_netcdf(line, tmp_path / "x.nc")
    xr.testing.assert_identical(line, load(tmp_path / "x.nc"))
    flags = line.failure.attrs
    assert len(flags["flag_values"]) == len(flags["flag_meanings"].split())


def test_the_report_names_the_commonest_cause(line: xr.Dataset) -> None:
    of = line.sel(observer="high_gain")
    lost = int(of.failed_at.notnull().sum())
    every = [cause(one) for one in of.failure.stack(run=of.failure.dims)]
    names, counts = np.unique([name for name in every if name != "none"], return_counts=True)
    said = "\n".join(notes(line))
    assert f"HGO failed in {lost} of them" in said
    assert any(f"commonest cause: {name} ({counts.max()} runs), at " in said for name in names[counts == counts.max()])


@pytest.mark.parametrize(
    ("chosen", "words"),
    [
        ([0, 1, 2], "at 3 of 6 points, all with a = 1"),
        ([0, 3], "at 2 of 6 points, all with b = 10"),
        ([1, 2], "at 2 of 6 points, all with a = 1, b ≥ 20"),
        ([0, 1, 3, 4], "at 4 of 6 points, all with b ≤ 20"),
        ([0, 5], "at 2 of 6 points"),
        ([0, 1, 2, 3, 4, 5], "at every point"),
    ],
)
def test_a_region_is_said_by_its_ends(chosen: list[int], words: str) -> None:
    mask = np.zeros(6, dtype=bool)
    mask[chosen] = True
    assert where(Axes("grid", ("a", "b"), (np.array([1.0, 2.0]), np.array([10.0, 20.0, 30.0]))), mask) == words


def test_gain_conditions_are_those_of_each_point() -> None:
    """What `simulate` says of every point alone, and nothing else."""
    over = {"high_gain.eps_h": [2e-4, 8e-4, 0.1], "step": [5e-4, 1e-3]}
    found = sweep("paper-clean", over, observers=["high_gain", "sliding_mode"], changes=SHORT)
    broken: dict[str, int] = {}
    for eps in over["high_gain.eps_h"]:
        for step in over["step"]:
            alone = simulate("paper-clean", None, {**SHORT, "high_gain.eps_h": eps, "step": step})
            for sentence in json.loads(alone.attrs["violated_conditions"]).get("high_gain", []):
                name = sentence.rpartition(": ")[0]
                broken[name] = broken.get(name, 0) + 1
    said = json.loads(found.attrs["violated_conditions"])
    # ε_L follows ε_h
    assert broken == {f"h ρ/{eps} < 0.75 (integration)": 3 for eps in ("ε_h", "ε_L")}
    assert said["high_gain"] == [
        f"{name} does not hold at 3 of 6 points, all with high_gain.eps_h ≤ 0.0008" for name in broken
    ]
    assert said["sliding_mode"][0].endswith("does not hold at every point")


# ---------------------------------------------------------------- where


def test_what_survives_by_luck_is_no_optimum(line: xr.Dataset) -> None:
    """The smallest errors belong to a point where two of three runs failed."""
    rmse = np.broadcast_to(np.array([1.0, 5, 4, 3, 6])[:, None, None], line.failed_at.shape)
    lost = np.zeros(line.failed_at.shape, dtype=bool)
    lost[0, :2], lost[3, 0] = True, True
    found = medians(replaced(line, rmse, lost)).sel(observer="high_gain", quantity="x2")
    assert np.isnan(found.values[0])
    assert optimum(line, found, "high_gain").values == {"high_gain.eps_h": 0.1}
    assert float(found[3]) == 3


def test_an_optimum_is_sought_over_what_can_be_chosen(plane: xr.Dataset) -> None:
    """ε_h, for the noise of the scenario; not the noise."""
    assert list(plane.observer.values) == ["high_gain"]
    median = medians(plane).sel(observer="high_gain", quantity="x2")
    found = optimum(plane, median, "high_gain")
    assert found.values["noise.x1"] == 0.001
    assert found.error == float(median.sel({"noise.x1": 0.001}).min())
    assert at_scenario(plane, median) == float(median.sel({"noise.x1": 0.001, "high_gain.eps_h": 0.1}))
    assert "smallest over high_gain.eps_h, at noise.x1 = 0.001, the nearest to the scenario's" in list(notes(plane))


def test_an_optimum_at_the_end_of_what_was_swept_is_an_edge(line: xr.Dataset) -> None:
    """The errors are set: with the smallest first, inside, last."""
    none_lost = np.zeros(line.failed_at.shape, dtype=bool)
    for place, edge in ((0, True), (2, False), (4, True)):
        rmse = np.full(line.failed_at.shape, 2.0)
        rmse[place] = 1.0
        dataset = replaced(line, rmse, none_lost)
        found = optimum(dataset, medians(dataset).sel(observer="high_gain", quantity="x2"), "high_gain")
        assert found.values["high_gain.eps_h"] == EPS[place]
        assert found.edges == (("high_gain.eps_h",) if edge else ())
        assert any(said.startswith("edge: ") for said in notes(dataset)) == edge


# what the step asks of the layers of the tendons, and the numbers of the paper's scenario in it
LAYER = "h α/δ_L < 2.5 (integration)"
STEP, ALPHA = 5e-4, 1.1


def test_a_condition_is_known_at_each_point(layer: xr.Dataset) -> None:
    at = layer.condition_violated.set_index(condition="condition").sel(condition=LAYER)
    assert str(at.condition_observer.values) == "sliding_mode"
    for value, broken in zip(layer["sliding_mode.delta_s"].values, at.values, strict=True):
        alone = simulate("paper-noisy", "sliding_mode", {**SHORT, "sliding_mode.delta_s": float(value)})
        said = json.loads(alone.attrs["violated_conditions"])["sliding_mode"]
        assert any(sentence.startswith(LAYER) for sentence in said) == broken == (value < STEP * ALPHA / 2.5)


def test_conditions_are_kept_in_a_file_and_are_not_there_where_all_hold(layer: xr.Dataset, tmp_path: Path) -> None:
    save_netcdf(layer, tmp_path / "x.nc")
    xr.testing.assert_identical(layer, load(tmp_path / "x.nc"))
    said = [text for texts in json.loads(layer.attrs["violated_conditions"]).values() for text in texts]
    names = layer.condition.values.tolist()
    assert len(said) == len(names)
    assert all(text.startswith(name) for text, name in zip(said, names, strict=True))
    assert "condition_violated" not in sweep("paper-clean", {"high_gain.eps_h": [0.1, 0.2]}, changes=SHORT)


def test_an_optimum_where_a_condition_fails_says_which(layer: xr.Dataset) -> None:
    """λ₁₁ is below its bound at all points: the notes say so, and no row repeats it."""
    rmse = np.broadcast_to(np.array([9.0, 1, 2, 3, 4])[:, None, None], layer.failed_at.shape)
    dataset = replaced(layer, rmse, np.zeros(layer.failed_at.shape, dtype=bool))
    found = optimum(dataset, medians(dataset).sel(observer="sliding_mode", quantity="x2"), "sliding_mode")
    (place,) = found.violated
    assert not found.edges
    assert not found.inside
    assert dataset.condition.values[place] == LAYER
    said = list(notes(dataset))
    number = next(text for text in said if LAYER in text)
    assert number.startswith(f"gain condition ({place + 1}) of SMO: ")
    rows = [text for text in printed(tables(dataset)[0]) if text.startswith("SMO")]
    assert rows
    assert all(row.endswith(f"({place + 1}) fails") for row in rows)


def test_a_parameter_of_the_plant_has_no_optimum_but_a_spread() -> None:
    found = sweep("paper-noisy", {"plant.m": [0.8, 1.0, 1.2]}, 3, ["high_gain", "sliding_mode"], SHORT)
    median = medians(found).sel(observer="sliding_mode", quantity="x2")
    assert optimum(found, median, "sliding_mode") is None
    (table,) = tables(found)
    assert printed(table)[1].split() == ["quantity", "own", "median", "median", "change"]
    (row,) = (text.split() for text in printed(table) if text.startswith("SMO x2"))
    least, largest = float(median.min()), float(median.max())
    assert row[-2:] == [f"{100 * (largest / least - 1):.2g}", "%"]
    assert "optimum" not in legend(curves(found, ["x2"]))


def test_who_is_not_changed_is_said_to_be_so(line: xr.Dataset) -> None:
    optima, spreads = tables(line)
    assert all(text.startswith("HGO") for text in printed(optima)[2:] if text)
    rows = [text for text in printed(spreads) if text.startswith("SMO")]
    assert rows
    assert all(row.endswith("none") for row in rows)


@pytest.mark.parametrize(("kind", "over"), [("zip", [0.0005, 0.002, 0.004]), ("grid", [17.0, 19.0])])
def test_what_cannot_be_held_leaves_no_optimum(kind: str, over: list[float]) -> None:
    """Points that move with the noise; a scenario whose muscles differ."""
    path = "noise.x1" if kind == "zip" else "muscle.k"
    eps = [0.05, 0.1, 0.2][: len(over)]
    changes = {**SHORT, **({} if kind == "zip" else {"muscle1.k": 18.0})}
    found = sweep("paper-noisy", {"high_gain.eps_h": eps, path: over}, 2, "high_gain", changes, kind=kind)
    assert optimum(found, medians(found).sel(observer="high_gain", quantity="x2"), "high_gain") is None
    words = f"no optimum over high_gain.eps_h: {path} cannot be held at one value of the scenario's"
    assert words in list(notes(found))


@pytest.mark.parametrize("path", ["high_gain.eps_h", "sliding_mode.delta_s", "adaptive_sliding_mode.delta_a"])
def test_a_table_of_one_parameter_fits_a_terminal(path: str) -> None:
    found = sweep("paper-noisy", {path: [1e-4, 0.1]}, changes=SHORT)
    for table in tables(found):
        assert max(map(len, printed(table))) <= 80


def test_the_scenarios_own_value_is_not_made_up() -> None:
    outside = sweep("paper-clean", {"high_gain.eps_h": [0.2, 0.3]}, changes=SHORT)
    assert np.isnan(at_scenario(outside, medians(outside).sel(observer="high_gain", quantity="x2")))
    untied = sweep("paper-clean", {"muscle.k": [19.0, 20.0]}, changes={**SHORT, "muscle1.k": 19.5})
    assert "scenario_value" not in untied["muscle.k"].attrs


def test_the_table_has_the_quantities_asked_for(line: xr.Dataset) -> None:
    table, spreads = tables(line.sel(quantity=["x1", "a2"]))
    headings = [str(column.header).replace("\n", " ") for column in table.columns]
    assert headings == ["", "quantity", "high_gain. eps_h", "median RMSE", "scenario's own", ""]
    for each in (table, spreads):
        assert list(each.columns[1].cells) == ["x1", "a2"]


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


# ---------------------------------------------------------------- figures


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


def test_no_map_of_an_observer_that_nothing_changes() -> None:
    over = {"high_gain.eps_h": [0.05, 0.1, 0.2], "high_gain.h11": [2.0, 3.0]}
    found = sweep("paper-noisy", over, 2, ["high_gain", "sliding_mode"], SHORT)
    figures, sentence = drawn(found, "x2")
    assert list(figures) == ["map-high_gain"]
    assert sentence == "no map of SMO: high_gain.eps_h and high_gain.h11 do not change it"


def test_the_spread_holds_two_thirds_of_the_seeds() -> None:
    seeds = sweep("paper-noisy", {"high_gain.eps_h": [0.05, 0.1, 0.2]}, 31, changes=SHORT)
    (band,) = curves(seeds, ["x2"]).axes[0].collections
    every = errors(seeds).sel(observer="high_gain", quantity="x2")
    (vertices,) = (path.vertices for path in band.get_paths())
    for i, eps in enumerate((0.05, 0.1, 0.2)):
        edges = vertices[vertices[:, 0] == eps, 1]
        inside = (every[i] >= edges.min()) & (every[i] <= edges.max())
        assert 20 <= int(inside.sum()) <= 22


def test_a_sweep_without_noise_is_drawn_beside(line: xr.Dataset) -> None:
    clean = sweep("paper-clean", {"high_gain.eps_h": EPS}, 1, ["high_gain", "sliding_mode"], SHORT)
    figure = curves(line, ["x2"], clean)
    assert "without noise" in legend(figure)
    drawn_lines = [list(one.get_ydata()) for one in figure.axes[0].lines if one.get_color() == "black"]
    wanted = medians(clean).sel(quantity="x2")
    np.testing.assert_array_equal(drawn_lines, wanted.transpose("observer", ...).values)


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
    found = sweep("paper-noisy", over, 2, changes=SHORT)
    median = medians(found).sel(observer="high_gain", quantity="x2")
    mark = maps(found, "high_gain", ["x2"]).axes[0].lines[1]
    (((eps, h11),),) = (mark.get_xydata().tolist(),)
    assert float(median.sel({"high_gain.eps_h": eps, "high_gain.h11": h11})) == float(median.min())


def test_every_kind_of_sweep_has_its_figure(line: xr.Dataset, plane: xr.Dataset) -> None:
    for dataset, name in ((line, "curves"), (plane, "map-high_gain")):
        figures, sentence = drawn(dataset, "x2")
        assert (list(figures), sentence) == ([name], "")
    three = {"high_gain.eps_h": [0.1, 0.2], "high_gain.h11": [3.0, 4.0], "noise.x1": [0.0, 0.001]}
    for kind, words in (("grid", "more than two parameters"), ("zip", "points that are no grid")):
        found = sweep("paper-noisy", three, 2, changes=SHORT, kind=kind)
        figures, sentence = drawn(found, "x2", "a1")
        assert words in sentence
        axes = figures["points"].axes
        assert len(axes) == 2 * len(three)
        assert all(len(one.lines[0].get_xdata()) == found.failure.isel(seed=0).size for one in axes)
    assert drawn(sweep("paper-clean", changes=SHORT)) == ({}, "no figure: no parameter has more than one value")


def test_a_parameter_with_one_value_takes_no_room(line: xr.Dataset) -> None:
    found = sweep("paper-noisy", {"plant.m": [1.0], "high_gain.eps_h": EPS[::-1]}, 3, "high_gain", SHORT)
    one, other = (curves(each, ["x2"]).axes[0].lines[0] for each in (found, line))
    np.testing.assert_array_equal(one.get_xydata(), other.get_xydata())


def test_a_sweep_without_a_single_number_is_drawn(line: xr.Dataset, plane: xr.Dataset) -> None:
    for dataset in (line, plane):
        figures, _ = drawn(replaced(dataset, np.nan, True), "x2")
        (figure,) = figures.values()
        assert "runs failed" in legend(figure)
        assert [text.get_text() for text in figure.axes[0].texts] == ["no numbers"]


# ---------------------------------------------------------------- the command


SWEEP = ["sweep", "paper-noisy", "--set", "duration=0.2", "--set", "score.start=0.05", "--seeds", "2"]


def test_figures_lie_beside_the_result_and_are_drawn_again(command, tmp_path: Path) -> None:
    code, out, err = command(*SWEEP, "--over", "high_gain.eps_h=0.05,0.1,0.2", "--out", "here/eps.nc")
    assert (code, err) == (0, "")
    assert "computed 6 runs in " in out
    assert out.endswith("written to here/eps.nc, eps-curves.png and .pdf\n")
    first = {path.name: path.read_bytes() for path in (tmp_path / "here").glob("*.p*")}
    assert sorted(first) == ["eps-curves.pdf", "eps-curves.png"]
    assert command("figures", "here/eps.nc", "--out", "again")[:2] == (
        0,
        "written to again/: 1 figure as PNG and PDF\n",
    )
    assert {path.name: path.read_bytes() for path in (tmp_path / "again").iterdir()} == first


def test_the_same_sweep_gives_the_same_files(layer: xr.Dataset, plane: xr.Dataset, tmp_path: Path) -> None:
    """With hatches, hollow marks and bands."""
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        for stem, dataset in (("layer", layer), ("plane", plane)):
            save_sweep_figures(dataset.sel(quantity=["x2", "a1"]), tmp_path / name, stem)
    first, second = ({path.name: path.read_bytes() for path in (tmp_path / name).iterdir()} for name in ("one", "two"))
    assert first == second
    assert len(first) == 4


def test_a_sweep_without_figures(command, tmp_path: Path) -> None:
    code, out, _ = command(*SWEEP, "--over", "plant.m=1,1.1", "--out", "m.nc", "--no-figures", "--quantity", "x1")
    assert (code, [path.name for path in tmp_path.iterdir()]) == (0, ["m.nc"])
    assert "x1" in out
    assert "Delta" not in out


def test_what_cannot_be_shown_is_said(command, tmp_path: Path) -> None:
    assert "unknown quantity 'x9'; there are x1, x2" in command(*SWEEP, "--quantity", "x9")[2]
    assert "unknown measure 'error'; there are rmse, peak" in command(*SWEEP, "--measure", "error")[2]
    save_netcdf(xr.Dataset({"rank": ("t", [4.0])}), tmp_path / "x.nc")
    code, _, err = command("figures", "x.nc")
    assert (code, err) == (2, "hillobs: x.nc cannot be drawn: it is no run, no sweep and no estimates\n")
