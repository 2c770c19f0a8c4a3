"""Markers of a model are points of the mechanism."""

from pathlib import Path

import pytest

from hillobs.model.skeleton.points import Point
from hillobs.studies.laboratory.mechanisms.from_opensim import mechanism_from
from hillobs.studies.laboratory.opensim.model import read_model
from places import DATA

MODEL = (DATA / "arm26_polynomial.osim").read_text(encoding="utf-8")
STYLOID = Point("r_ulna_radius_hand", (-0.0011, -0.23559, 0.0943))


def points(tmp_path: Path, text: str) -> dict[str, Point]:
    """Those of the mechanism of a model."""
    path = tmp_path / "model.osim"
    path.write_text(text, encoding="utf-8")
    return dict(mechanism_from(read_model(path), path.name).points)


def test_markers_on_bodies_are_points(tmp_path: Path) -> None:
    found = points(tmp_path, MODEL)
    assert list(found) == ["r_acromion", "r_humerus_epicondyle", "r_radius_styloid"]
    assert found["r_radius_styloid"] == STYLOID


@pytest.mark.parametrize("name", ["1st", "BRA", "elbow", "a" * 31, "§"])
def test_a_marker_without_a_name_of_its_own_is_left_out(name: str, tmp_path: Path) -> None:
    assert list(points(tmp_path, MODEL.replace('"r_acromion"', f'"{name}"'))) == [
        "r_humerus_epicondyle",
        "r_radius_styloid",
    ]


def test_a_marker_on_the_ground_is_left_out(tmp_path: Path) -> None:
    moved = MODEL.replace(
        "<socket_parent_frame>/bodyset/base</socket_parent_frame>", "<socket_parent_frame>/ground</socket_parent_frame>"
    )
    assert "r_acromion" not in points(tmp_path, moved)


def test_the_body_of_older_versions_is_read(tmp_path: Path) -> None:
    tag = "socket_parent_frame>/bodyset/r_ulna_radius_hand</socket_parent_frame"
    older = MODEL.replace('<Marker name="r_radius_styloid">', '<Marker name="hand">').replace(
        f"<{tag}>", "<body>r_ulna_radius_hand</body>"
    )
    assert points(tmp_path, older)["hand"] == STYLOID
