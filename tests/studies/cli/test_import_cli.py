"""`hillobs import`: tables of what was taken, notes, the file, and a sentence for each mistake."""

import gzip
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

from hillobs.studies.laboratory.mechanisms.reading import read_mechanism
from places import DATA

Command = Callable[..., tuple[int, str, str]]
MODEL = str(DATA / "arm26_polynomial.osim")


@pytest.fixture
def wrapped(tmp_path: Path) -> Path:
    path = tmp_path / "arm26.osim"
    path.write_bytes(gzip.decompress((DATA / "arm26.osim.gz").read_bytes()))
    return path


def test_it_prints_what_was_taken_and_writes_it(command: Command, tmp_path: Path) -> None:
    code, out, err = command("import", MODEL, "--out", "arm.toml")
    assert (code, err) == (0, "")
    assert "shoulder pin  base → r_humerus               r_shoulder_elev -1.57 … 3.14 rad (-90 … 180°)" in out
    assert "TRIlong  DeGrooteFregly2016Muscle shoulder, elbow   798.52       134        143           12" in out
    assert out.endswith("written to ./: arm.toml\n")
    arm = read_mechanism(tmp_path / "arm.toml")
    assert arm.tree.coordinates == ("shoulder", "elbow")
    assert arm.tree.joints["elbow"].opensim == "r_elbow"
    assert "Creative Commons (CCBY 3.0)" in arm.description


def test_without_a_place_it_only_prints(command: Command, tmp_path: Path) -> None:
    code, out, err = command("import", MODEL)
    assert (code, err) == (0, "")
    assert "r_elbow_flex" in out
    assert list(tmp_path.iterdir()) == []


def test_paths_locks_ranges_and_muscles_are_heard(command: Command, tmp_path: Path, wrapped: Path) -> None:
    paths = str(DATA / "arm26_paths_order5.xml")
    options = [
        "--lock",
        "shoulder=-0.1",
        "--muscles",
        "TRIlat, BRA",
        "--range",
        "elbow=0.1:2.1",
        "--out",
        "new/arm.toml",
    ]
    code, out, err = command("import", wrapped.name, "--paths", paths, *options)
    assert (code, err) == (0, "")
    assert "pin, locked at -0.1 rad" in out
    arm = read_mechanism(tmp_path / "new" / "arm.toml")
    assert (arm.tree.coordinates, list(arm.muscles)) == (("elbow",), ["TRIlat", "BRA"])
    assert arm.tree.joints["elbow"].range == (0.1, 2.1)
    content = tomllib.loads((tmp_path / "new" / "arm.toml").read_text())
    assert content["muscle"]["curves"] == "thelen2003"


def test_a_joint_that_no_muscle_moves_is_told(command: Command) -> None:
    code, out, err = command("import", MODEL, "--muscles", "BRA")
    assert (code, err) == (0, "")
    assert "no muscle crosses shoulder: lock what does not move, --lock shoulder=…\n" in out
    code, out, err = command("import", str(DATA / "joints.osim"))
    assert (code, err) == (0, "")
    assert "no muscle crosses slide, custom, rail, universal, gimbal, planar, free: lock what" in out
    assert "held in the frames of their joints: universal_1 = 0.35, gimbal_1 = -0.2, gimbal_3 = 0.4, " in out


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--lock", "shoulder"], "--lock must be such as shoulder=-0.1, not 'shoulder'"),
        (["--lock", "shoulder=-6deg"], "--lock shoulder must be a number, not '-6deg'"),
        (
            ["--lock", "wrist=1"],
            f"{MODEL}: 'wrist' is no joint and no coordinate; there are r_shoulder_elev, r_elbow_flex",
        ),
        (["--lock", "elbow=1", "--lock", "elbow=2"], "--lock elbow is given twice"),
        (
            ["--lock", "elbow=1", "--lock", "r_elbow_flex=2"],
            f"{MODEL}: 'elbow' and 'r_elbow_flex' are one coordinate, r_elbow_flex; it can be given once",
        ),
        (
            ["--range", "r_elbow=0:1", "--range", "elbow=0:2"],
            f"{MODEL}: 'r_elbow' and 'elbow' are one coordinate, r_elbow_flex; it can be given once",
        ),
        (
            ["--range", "elbow=5:125"],
            f"{MODEL}: joints.elbow.range[1] must be at most 12, not 125 (rad; is it in degrees?)",
        ),
        (
            ["--lock", "shoulder=-30"],
            f"{MODEL}: joints.shoulder.locked must be at least -12, not -30 (rad; is it in degrees?)",
        ),
        (["--order", "3"], "--order is that of --fit, which is not asked for"),
        (["--range", "elbow=1"], "--range elbow must be LOW:HIGH, not '1'"),
        (["--range", "elbow=1:x"], "--range elbow must be a number, not 'x'"),
        (["--muscles", ","], "--muscles must be names with commas between"),
        (["--paths", "none.xml"], "none.xml: cannot be read: No such file or directory"),
        (["--out", "arm.osim"], "--out must be a .toml file, not 'arm.osim'"),
        (["--out", MODEL], f"--out must be a .toml file, not {MODEL!r}"),
    ],
)
def test_a_mistake_is_a_sentence(options: list[str], sentence: str, command: Command, tmp_path: Path) -> None:
    assert command("import", MODEL, *options) == (2, "", f"hillobs: {sentence}\n")
    assert list(tmp_path.iterdir()) == []
