"""What is written and drawn of joints and muscles: names, units, scores, files and the sheet."""

import itertools
import json
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.transforms import Bbox

import hillobs
from few_observers import few_observers
from hillobs.model.skeleton.paths import constant_moment_arms
from hillobs.model.skeleton.tree import GROUND, PIN, SLIDER, Joint, Link, Tree
from hillobs.studies.cli.reports.estimates.estimate import score_cells
from hillobs.studies.cli.reports.estimates.estimate_page import estimate_page
from hillobs.studies.cli.reports.estimates.verdict import answer
from hillobs.studies.cli.reports.number import number
from hillobs.studies.estimate.files import save_estimates
from hillobs.studies.estimate.run import estimate
from hillobs.studies.estimate.scores import scores
from hillobs.studies.figures.estimate import estimate_sheet
from hillobs.studies.files.datasets.netcdf import save_netcdf
from hillobs.studies.files.tables import Series, write_csv
from hillobs.studies.laboratory.mechanisms.mechanism import Mechanism
from hillobs.studies.laboratory.muscles import read_muscles
from hillobs.studies.laboratory.recording import read_recording
from hillobs.studies.laboratory.subject import subject_of
from places import DATA
from shipped_recording import HINGE, MUSCLES

pytestmark = pytest.mark.numerics


@pytest.fixture(scope="module")
def mixed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Mechanism, xr.Dataset]:
    """A pendulum on a cart, and its estimates; what its recording knows beside is made up."""
    muscle = read_muscles(MUSCLES).muscle1
    tree = Tree(
        {"block": Link(10.0), "rod": Link(1.0, (0.0, -0.3, 0.0), (0.1, 0.1, 0.1, 0.0, 0.0, 0.0))},
        {
            "cart": Joint(GROUND, "block", SLIDER, (1.0, 0.0, 0.0), range=(-0.05, 0.05)),
            "pend": Joint("block", "rod", PIN, range=(-0.5, 0.5)),
        },
        (0.0, -9.81, 0.0),
    )
    length = muscle.tendon_slack_length + muscle.optimal_fibre_length
    paths = {
        # names that tables might take for all of them
        "all": constant_moment_arms(length, {"cart": 1.0}),
        "both": constant_moment_arms(length, {"pend": 0.03}),
    }
    mechanism = Mechanism(tree, dict.fromkeys(paths, muscle), paths)
    time = np.arange(0.0, 2.0, 0.005)
    wave = np.sin(2 * np.pi * time)
    known = {
        "position_cart": ("m", 0.02 * wave),
        "angle_pend": ("rad", 0.2 * wave),
        **{f"force_{name}": ("N", 200 + 50 * wave) for name in paths},
        "velocity_cart": ("m/s", 0.1 * wave),
        "angular_velocity_pend": ("rad/s", wave),
        "activation_all": ("1", 0.2 + 0 * wave),
        "activation_both": ("1", 0.4 + 0 * wave),
    }
    path = tmp_path_factory.mktemp("mixed") / "x.csv"
    write_csv(path, [Series("time", "s", time), *(Series(name, *of) for name, of in known.items())])
    with few_observers("high_gain"):
        return mechanism, estimate(read_recording(path, known=subject_of(mechanism).columns), mechanism, "high_gain")


def test_results_name_joints_and_muscles(hinge: xr.Dataset) -> None:
    assert hinge.joint.values.tolist() == ["elbow"]
    assert hinge.muscle.values.tolist() == ["TRIlat", "BRA"]
    assert {name: hinge[name].attrs["units"] for name in ("position_hat", "velocity_hat", "disturbance_hat")} == {
        "position_hat": "rad",
        "velocity_hat": "rad/s",
        "disturbance_hat": "N m",
    }
    # L_C² = (L_m − L_S)² + h²
    subject = subject_of(HINGE)
    along = subject.laws.lengths(hinge.position_hat.values) * subject.scales.length - hinge.tendon_length_hat
    np.testing.assert_allclose(
        hinge.fibre_length_hat**2 - along**2, np.broadcast_to(subject.heights**2, along.shape), atol=1e-15
    )


def test_what_slides_and_what_turns_have_their_own_units(mixed: tuple[Mechanism, xr.Dataset], tmp_path: Path) -> None:
    mechanism, dataset = mixed
    save_estimates(dataset, scores(dataset), tmp_path)
    head = (tmp_path / "estimates.csv").read_text().partition("\n")[0].split(",")
    units = {
        "position_cart": "m",
        "angle_pend": "rad",
        "velocity_cart": "m/s",
        "angular_velocity_pend": "rad/s",
        "disturbance_cart": "N",
        "disturbance_pend": "N m",
    }
    assert {f"{name}_hat [{unit}]" for name, unit in units.items()} <= set(head)
    mapping = {name: f"{name}_hat" for name in units if name not in ("position_cart", "angle_pend")}
    read = read_recording(tmp_path / "estimates.csv", mapping, known=subject_of(mechanism).columns)
    for quantity, names in subject_of(mechanism).names.items():
        for joint, name in zip(("cart", "pend"), names, strict=True):
            if name in mapping:
                np.testing.assert_array_equal(read.true[name], dataset[f"{quantity}_hat"].sel(joint=joint)[0])


def test_no_score_is_a_mean_of_metres_and_radians(mixed: tuple[Mechanism, xr.Dataset], hinge: xr.Dataset) -> None:
    found = scores(mixed[1])
    assert [(s.muscle, s.unit) for s in found if s.quantity == "velocity"] == [("cart", "m/s"), ("pend", "rad/s")]
    assert score_cells(found)[0] == ["", "activation"]
    assert [s.muscle for s in scores(hinge.isel(observer=[0])) if s.quantity == "velocity"] == ["all joints", "elbow"]


def test_a_muscle_may_be_called_all(mixed: tuple[Mechanism, xr.Dataset]) -> None:
    _, dataset = mixed
    found = {score.muscle: score for score in scores(dataset) if score.quantity == "activation"}
    assert list(found) == ["all muscles", "all", "both"]
    late = dataset.sel(time=slice(1.0, None))
    error = (late.activation_hat - late.true_activation)[0]
    for name, part in (("all muscles", error), ("all", error.sel(muscle="all")), ("both", error.sel(muscle="both"))):
        assert found[name].rmse == pytest.approx(float(np.sqrt((part**2).mean())))
    assert score_cells(scores(dataset))[1][1] == number(found["all muscles"].rmse)


def test_programs_are_told_what_is_a_joint(mixed: tuple[Mechanism, xr.Dataset]) -> None:
    rows = json.loads(answer(None, scores(mixed[1]), []))["scores"]
    whose = [(row["quantity"], key, row[key]) for row in rows for key in ("joint", "muscle") if key in row]
    assert whose == [
        ("velocity", "joint", "cart"),
        ("velocity", "joint", "pend"),
        ("activation", "muscle", "all muscles"),
        ("activation", "muscle", "all"),
        ("activation", "muscle", "both"),
    ]


def test_the_report_has_a_column_for_each_muscle(hinge: xr.Dataset) -> None:
    page = estimate_page(hinge, scores(hinge), [], b"").decode()
    for cell in (">TRIlat</th>", ">BRA</th>", "joints.elbow.range", "both muscles together"):
        assert cell in page


def test_results_for_opensim_have_the_names_of_the_model() -> None:
    columns = subject_of(HINGE).columns
    assert columns.opensim["angle_elbow"] == "/jointset/r_elbow/r_elbow_flex/value"
    assert columns.opensim["force_BRA"] == "/forceset/BRA|tendon_force"


def test_a_result_repeats_itself(hinge: xr.Dataset, tmp_path: Path) -> None:
    save_netcdf(hinge, tmp_path / "x.nc")
    again = hillobs.estimate(DATA / "hinge_pair_noisy.csv.gz", **hillobs.arguments(hillobs.load(tmp_path / "x.nc")))
    for name in ("activation_hat", "disturbance_hat", "position_hat"):
        np.testing.assert_array_equal(again[name], hinge[name])


def test_a_joint_beyond_the_range_of_its_paths_is_told(hinge: xr.Dataset, tmp_path: Path) -> None:
    assert json.loads(hinge.attrs["notes"]) == []
    text = HINGE.read_text()
    assert text.count("range = [0.0872") == 1
    least, most = 0.5, 1.5
    (tmp_path / "narrow.toml").write_text(
        "".join(
            f"range = [{least}, {most}]\n" if line.startswith("range = [0.0872") else line
            for line in text.splitlines(keepends=True)
        )
    )
    recording = read_recording(DATA / "hinge_pair_noisy.csv.gz", known=subject_of(HINGE).columns).part(slice(400))
    position = recording["angle_elbow"]
    outside = int(np.sum((position < least - 0.01) | (position > most + 0.01)))
    assert 0 < outside < 400
    with few_observers("high_gain"):
        (note,) = json.loads(estimate(recording, tmp_path / "narrow.toml", "high_gain").attrs["notes"])
    assert note.startswith(f"angle_elbow is beyond 0.5 to 1.5 rad in {outside} of 400 rows, by at most ")


def inside(outer: Bbox, inner: Bbox) -> bool:
    return outer.x0 <= inner.x0 and inner.x1 <= outer.x1 and outer.y0 <= inner.y0 and inner.y1 <= outer.y1


@pytest.mark.parametrize("count", [1, 2, 6, 12])
def test_long_names_stay_on_the_sheet_and_hide_nothing(hinge: xr.Dataset, count: int) -> None:
    names = [f"muscle_with_a_long_name_{i}" for i in range(count)]
    shown = hinge.isel(observer=[0], muscle=np.arange(count) % 2).assign_coords(muscle=names)
    figure = estimate_sheet(shown)
    figure.draw_without_rendering()
    panels = [axes.get_window_extent() for axes in figure.axes]
    labels = [axes.yaxis.label.get_window_extent() for axes in figure.axes]
    assert all(inside(figure.bbox, label) for label in labels)
    assert not any(one.overlaps(other) for one, other in itertools.pairwise(labels))
    assert all(panel.width > figure.bbox.width / 2 and panel.height > figure.dpi / 2 for panel in panels)
    forces = figure.axes[1]
    if count > 1:
        named = forces.get_legend()
        assert [text.get_text() for text in named.get_texts()] == names
        assert inside(figure.bbox, named.get_window_extent())
        assert not named.get_window_extent().overlaps(panels[0])


def test_lines_of_many_muscles_differ_without_colour(hinge: xr.Dataset) -> None:
    count = 12
    shown = hinge.isel(observer=[0], muscle=np.arange(count) % 2).assign_coords(muscle=[f"m{i}" for i in range(count)])
    drawn = estimate_sheet(shown).axes[1].lines
    looks = {(line.get_color(), str(line._unscaled_dash_pattern)) for line in drawn}
    assert len(looks) == count
    assert len({color for color, _ in looks}) == 2


def test_a_joint_in_a_figure_has_its_own_unit(mixed: tuple[Mechanism, xr.Dataset]) -> None:
    figure = estimate_sheet(mixed[1])
    labels = [axes.get_ylabel().split("\n") for axes in figure.axes]
    assert [text.get_text() for text in figure.axes[0].get_legend().get_texts()] == ["cart, m", "pend, rad"]
    units = {(words[0], words[1]): words[-1] for words in labels if words[1:2] in (["cart"], ["pend"])}
    assert units == {
        ("velocity", "cart"): "mm/s",
        ("velocity", "pend"): "rad/s",
        ("external", "cart"): "N",
        ("external", "pend"): "N m",
        ("innovation", "cart"): "mm",
        ("innovation", "pend"): "rad",
    }
