"""The figures say what the Dataset says: the right lines in the right colours, scales, labels and files."""

import subprocess
import sys

import matplotlib
import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex

from drawn_figures import draw, legend, line, panels, shaded
from hillobs.model.symbols import QUANTITIES, SIGNALS, STATES, hat
from hillobs.observers import PAPER, label
from hillobs.studies.figures import style
from hillobs.studies.figures.run import estimates, figures, save_figures
from hillobs.studies.figures.views import series, start
from hillobs.studies.files.errors import ResultError
from hillobs.studies.files.pictures import WITH_PDF
from hillobs.studies.simulate.run import simulate
from places import contents

ROWS = {"states": STATES, "inputs": ("Delta", "u1", "u2"), "activations": ("a1", "a2")}
# long enough for a slack tendon in slack-deep (from 1.2) and slack (from 5.3)
DURATIONS = {"paper-clean": 6, "paper-noisy": 6, "challenge": 3, "slack": 8, "slack-deep": 4, "activation": 3}


@pytest.fixture(scope="module")
def clean():
    return simulate("paper-clean", changes={"duration": 6.0})


@pytest.fixture(scope="module")
def loose():
    return simulate("slack-deep", changes={"duration": 4.0})


@pytest.fixture(scope="module")
def unfeasible():
    """Long enough for a muscle that is asked for more than it can give."""
    return simulate("slack", changes={"duration": 9.0})


def failing(dataset, observer, at):
    """`dataset` with an observer that grows without bound and is NaN from `at` on."""
    growth = np.exp(np.minimum(60 * (dataset.time - at + 1).clip(min=0), 600)) - 1
    lost = {}
    for name in ("x_hat", "u_hat", "a_hat", "Delta_hat"):
        worse = (dataset[name] + growth).where(dataset.time < at)
        lost[name] = dataset[name].where(dataset.observer != observer, worse).transpose(*dataset[name].dims)
    return dataset.assign(lost)


def test_each_quantity_is_drawn_as_recorded(clean):
    drawn = figures(clean)
    assert list(drawn) == ["phi_s", "reference", *ROWS]
    for key, quantities in ROWS.items():
        for quantity in quantities:
            for axes in panels(drawn[key], quantity):
                np.testing.assert_array_equal(line(axes, "true").get_xdata(), clean.time)
                np.testing.assert_array_equal(line(axes, "true").get_ydata(), series(clean, quantity))
                assert len(axes.lines) == 1 + len(PAPER)
                for name in PAPER:
                    estimate = series(clean, hat(quantity)).sel(observer=name)
                    np.testing.assert_array_equal(line(axes, name).get_ydata(), estimate)


def test_series_names_the_arrays(clean):
    np.testing.assert_array_equal(series(clean, "x3"), clean.x[:, 2])
    np.testing.assert_array_equal(series(clean, "u2_hat"), clean.u_hat[:, :, 1])
    np.testing.assert_array_equal(series(clean, "Delta_hat"), clean.Delta_hat)
    assert all(series(clean, quantity).dims == ("time",) for quantity in QUANTITIES)


def test_labels_are_symbols_and_there_is_one_legend(clean):
    drawn = figures(clean)
    for key, quantities in ROWS.items():
        labels = [axes.get_ylabel() for axes in drawn[key].axes if axes.get_ylabel()]
        assert labels == [SIGNALS[quantity].symbol for quantity in quantities]
        assert drawn[key].axes[-1].get_xlabel() == SIGNALS["t"].symbol
        assert legend(drawn[key]) == ["true", "HGO", "SMO", "ASMO"]
    assert drawn["reference"].axes[0].get_ylabel() == "$r$, $y_1$"
    assert legend(drawn["reference"]) == ["$r$", "$y_1$ = $x_1$"]


def test_an_observer_keeps_its_colour_and_true_is_black_and_dashed(clean):
    colours = {name: set() for name in PAPER}
    for chosen in (list(PAPER), ["adaptive_sliding_mode"], ["sliding_mode", "high_gain"]):
        for figure in list(figures(clean.sel(observer=chosen)).values())[2:]:
            for axes in figure.axes:
                for name in chosen:
                    colours[name].add(line(axes, name).get_color())
                assert line(axes, "true").get_color() == "black"
                assert line(axes, "true").is_dashed()
    assert all(len(used) == 1 for used in colours.values())
    assert len(set.union(*colours.values())) == len(PAPER)


def test_own_observers_take_the_next_colours():
    known, extended = list(PAPER), style.observer_styles([*PAPER, "mine", "yours"])
    assert {name: extended[name] for name in known} == style.observer_styles(known)
    looks = [(to_hex(look["color"]), str(look["linestyle"])) for look in extended.values()]
    assert len({colour for colour, _ in looks}) == len({dashes for _, dashes in looks}) == len(looks)
    assert label("mine") == "mine"


def test_an_own_observer_is_drawn(clean):
    renamed = clean.assign_coords(observer=["high_gain", "mine", "adaptive_sliding_mode"])
    figure = figures(renamed)["states"]
    assert legend(figure) == ["true", "HGO", "mine", "ASMO"]
    assert line(figure.axes[0], "mine").get_color() not in {
        look["color"] for look in style.observer_styles(list(PAPER)).values()
    }


def test_the_start_is_split_off_where_it_hides_the_rest(clean):
    end = start(clean)
    assert 0.3 < end <= 2
    first, rest = panels(figures(clean)["inputs"], "Delta")
    assert first.get_xlim() == (0, end)
    assert rest.get_xlim() == (end, 6)
    assert np.ptp(first.get_ylim()) > 5 * np.ptp(rest.get_ylim())
    late = clean.time >= end
    for values in (clean.Delta[late], *clean.Delta_hat[:, late]):
        assert rest.get_ylim()[0] < values.min()
        assert values.max() < rest.get_ylim()[1]


def test_without_a_start_there_is_one_column(clean):
    settled = clean.sel(time=slice(3, None))
    assert len(estimates(settled, STATES).axes) == len(STATES)


@pytest.mark.parametrize("factor", [0.1, 1.0, 25.0])
def test_the_start_scales_with_time(clean, factor):
    stretched = clean.assign_coords(time=clean.time * factor)
    assert 0.3 * factor < start(stretched) <= 2.5 * factor


def test_a_rare_spike_does_not_hide_the_rest(clean):
    spiked = clean.copy(deep=True)
    spiked.Delta_hat[0, 400:402] = 50
    assert panels(figures(spiked)["inputs"], "Delta")[-1].get_ylim()[1] < 1


def test_slack_is_shaded_for_its_own_muscle(loose):
    taut, time = loose.taut.sel(muscle=2).values, loose.time.values
    (begin,), (end,) = np.flatnonzero(np.diff(taut) < 0), np.flatnonzero(np.diff(taut) > 0)
    drawn = figures(loose)
    for key, quantity in (("states", "x4"), ("inputs", "u2"), ("activations", "a2")):
        for axes in panels(drawn[key], quantity):
            assert shaded(axes)[0] == pytest.approx((time[begin + 1], time[end + 1]))
        assert legend(drawn[key])[-1] == "tendon slack"
    for quantity in ("x1", "x2"):
        assert not any(axes.patches for axes in panels(drawn["states"], quantity))
    a2 = line(panels(drawn["activations"], "a2")[0], "true").get_ydata()
    np.testing.assert_array_equal(np.isnan(a2), taut == 0)


@pytest.mark.parametrize("scenario", DURATIONS)
def test_every_scenario_is_drawn_on_its_pages_without_a_warning(scenario):
    drawn = draw(simulate(scenario, changes={"duration": float(DURATIONS[scenario])}))
    assert_on_their_pages(drawn)
    assert ("tendon slack" in legend(drawn["states"])) == scenario.startswith("slack")
    assert ("$r$" in legend(drawn["reference"])) == (scenario != "activation")


@pytest.mark.parametrize(
    ("observers", "changes"),
    [
        (None, {"duration": 0.5}),
        (None, {"duration": 0.01}),
        (None, {"duration": 0.005, "record": 0.005}),
        (["sliding_mode"], {"duration": 2.0}),
        (None, {"duration": 2.0, "muscle2.k": 18.0}),
    ],
)
def test_every_shape_is_drawn_without_a_warning(observers, changes):
    assert len(draw(simulate("paper-noisy", observers, changes))) == 5


@pytest.mark.parametrize("observers", [list(PAPER), ["high_gain"]])
def test_an_observer_that_fails_is_named_and_leaves_the_others_readable(clean, observers):
    figure = draw(failing(clean.sel(observer=observers), "high_gain", 4.0))["states"]
    assert legend(figure)[1] == r"HGO (fails at $\tau$ = 4)"
    for axes in panels(figure, "x1"):
        assert 2.5 < axes.get_ylim()[0] < axes.get_ylim()[1] < 2.7


@pytest.mark.parametrize("kind", ["x_hat", "x"])
def test_nothing_but_nan_is_drawn_too(clean, kind):
    names = [name for name in clean.data_vars if kind == "x" or name.endswith("_hat")]
    lost = clean.assign({name: clean[name] * np.nan for name in names if "time" in clean[name].dims})
    assert len(draw(lost)) == 5


def test_phi_s_is_the_curve_of_the_run(clean):
    (axes,) = figures(clean)["phi_s"].axes
    lengths, forces = axes.lines[0].get_data()
    np.testing.assert_allclose(np.interp([1.99, 2.0, 2.04, 2.05], lengths, forces), [0, 0, 0.5, 0.692308], atol=1e-6)
    assert [text.get_text() for text in axes.texts] == ["slack", "toe", "linear"]
    assert [edge for span in shaded(axes) for edge in span] == pytest.approx([1.98, 2, 2, 2.04, 2.04, 2.06])


def test_phi_s_has_a_panel_for_each_tendon_that_differs():
    dataset = simulate("paper-clean", ["high_gain"], {"duration": 0.1, "muscle2.L_slack": 1.9})
    labels = [axes.get_xlabel() for axes in figures(dataset)["phi_s"].axes]
    assert labels == ["$L_{S1}$", "$L_{S2}$"]


def test_a_very_long_line_keeps_its_extremes():
    dataset = simulate("paper-noisy", ["sliding_mode"], {"duration": 10.0, "record": 5e-4})
    axes = panels(figures(dataset)["inputs"], "Delta")[-1]
    recorded, drawn = dataset.Delta_hat[0].values, line(axes, "sliding_mode").get_ydata()
    assert len(drawn) <= 6000 < len(recorded)
    assert (drawn.min(), drawn.max()) == (recorded.min(), recorded.max())


def test_an_activation_above_1_is_cut_and_said_to_be_infeasible(unfeasible):
    figure = draw(unfeasible)["activations"]
    (axes,) = panels(figure, "a1")
    needed = unfeasible.a.sel(muscle=1).where(unfeasible.taut.sel(muscle=1) == 1)
    assert float(needed.max()) > 1.5
    np.testing.assert_array_equal(line(axes, "true").get_ydata(), np.minimum(needed, 1))
    assert axes.get_ylim()[1] < 1.2
    hatched = [patch for patch in axes.patches if patch.get_hatch()]
    begins = [patch.get_window_extent().transformed(axes.transData.inverted()).x0 for patch in hatched]
    assert begins[0] == pytest.approx(float(unfeasible.time[needed > 1][0]))
    assert legend(figure)[-1] == f"infeasible: needs $a$ up to {float(needed.max()):.2g}"
    assert not any(patch.get_hatch() for axes in draw(unfeasible)["inputs"].axes for patch in axes.patches)


def test_all_words_stay_on_the_page_with_much_noise():
    assert_on_their_pages(draw(simulate("slack", changes={"noise.x1": 0.005, "noise.force": 0.005})))


def assert_on_their_pages(drawn):
    for figure in drawn.values():
        boxes = [one.get_window_extent() for one in figure.legends]
        boxes += [axis.label.get_window_extent() for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
        for box in boxes:
            assert figure.bbox.x0 <= box.x0 <= box.x1 <= figure.bbox.x1
            assert figure.bbox.y0 <= box.y0 <= box.y1 <= figure.bbox.y1


def test_the_same_run_gives_the_same_files(clean, tmp_path):
    clean.to_netcdf(tmp_path / "run.nc", engine="h5netcdf")
    again = xr.load_dataset(tmp_path / "run.nc", engine="h5netcdf")
    for name, dataset in (("one", clean), ("two", again)):
        (tmp_path / name).mkdir()
        written = save_figures(dataset, tmp_path / name, "run", WITH_PDF)
        assert sorted(path.name for path in written) == sorted(contents(tmp_path / name))
    assert {path.name for path in written} == {
        f"run-{key}.{kind}" for key in ("phi_s", "reference", *ROWS) for kind in ("png", "pdf")
    }
    for path in written:
        content = path.read_bytes()
        assert content == (tmp_path / "one" / path.name).read_bytes()
        assert content.startswith(b"\x89PNG" if path.suffix == ".png" else b"%PDF")
        assert len(content) < 1_000_000
        if path.suffix == ".pdf":
            assert b"/Type3" not in content
            assert b"CreationDate" not in content


def test_a_file_that_cannot_be_written_leaves_nothing(clean, tmp_path):
    (tmp_path / "run-phi_s.png").mkdir()
    with pytest.raises(ResultError, match=r"run-phi_s\.png"):
        save_figures(clean, tmp_path, "run")
    assert [path.name for path in tmp_path.iterdir()] == ["run-phi_s.png"]


def test_the_users_settings_neither_matter_nor_change(clean, tmp_path, monkeypatch):
    monkeypatch.setattr("hillobs.studies.figures.run.figures", lambda dataset: {"inputs": figures(dataset)["inputs"]})
    save_figures(clean, tmp_path, "plain")
    with matplotlib.rc_context({"font.size": 20, "axes.facecolor": "yellow", "lines.linewidth": 7}):
        before = dict(matplotlib.rcParams)
        save_figures(clean, tmp_path, "odd")
        assert dict(matplotlib.rcParams) == before
    assert (tmp_path / "odd-inputs.png").read_bytes() == (tmp_path / "plain-inputs.png").read_bytes()


def test_pyplot_is_not_imported():
    code = "import sys, hillobs.studies.figures.run; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
