"""A fit of paths by OpenSim: what is said of it, by a stand-in; and by OpenSim itself where it is installed."""

import gzip
import importlib.util
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.laboratory.mechanisms.from_opensim import mechanism_from
from hillobs.studies.laboratory.opensim.model import FitRequest, read_model
from hillobs.studies.laboratory.opensim.paths import Polynomial, read_paths
from hillobs.studies.laboratory.path_fit import fit as fitting
from hillobs.studies.laboratory.path_fit import in_opensim
from hillobs.studies.laboratory.path_fit.fit import fit
from places import DATA

Command = Callable[..., tuple[int, str, str]]
HERE = importlib.util.find_spec("opensim") is not None
# an extra of its own: its wheel carries another CasADi; all else is tested with a stand-in
needs_opensim = pytest.mark.skipif(not HERE, reason="OpenSim is not installed")

REQUEST = FitRequest(
    Path("model.osim"),
    ("TRIlong", "BRA"),
    {"r_shoulder_elev": (-1.0, 0.5), "r_elbow_flex": (0.1, 2.0)},
    {"r_shoulder_elev": "r_shoulder", "r_elbow_flex": "r_elbow"},
    {},
    (),
)


@pytest.fixture
def wrapped(tmp_path: Path) -> Path:
    path = tmp_path / "arm26.osim"
    path.write_bytes(gzip.decompress((DATA / "arm26.osim.gz").read_bytes()))
    return path


@pytest.fixture
def stand_in(monkeypatch: pytest.MonkeyPatch) -> None:
    """OpenSim that gives the polynomials of the tests, of a muscle 1 mm longer that jumps by 3 mm at shoulder 0.2."""
    paths = DATA / "arm26_paths_order5.xml"

    def ask(folder: Path, request: FitRequest, order: int, points: dict[str, np.ndarray]) -> dict[str, int]:
        (folder / "paths.xml").write_bytes(paths.read_bytes())
        names, found = list(request.ranges), read_paths(paths)
        values = {
            of: [evaluated(found[name], names, points[of]) for name in request.muscles] for of in ("check", "lines")
        }
        lengths, lines = (np.array([length for length, _ in values[of]]).T for of in ("check", "lines"))
        lengths[:, 0] += 1e-3
        lines[:, 0] += 3e-3 * (points["lines"][:, 0] > 0.2)
        arms = np.array([arm for _, arm in values["check"]]).transpose(1, 0, 2)
        np.savez(folder / "samples.npz", lengths=lengths, arms=arms, lines=lines)
        return {"used": 900}

    monkeypatch.setattr(fitting.importlib.util, "find_spec", lambda name: name)
    monkeypatch.setattr(fitting, "_ask", ask)


def evaluated(path: Polynomial, names: list[str], points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Length and moment arms of a polynomial, term by term in NumPy."""
    place = [names.index(name) for name in path.coordinates]
    powers = np.array(
        [e for e in np.ndindex(*[path.order + 1] * len(place)) if sum(e) <= path.order]
    )  # the last one fastest
    q = points[:, place]
    terms = np.array(path.coefficients) * np.prod(q[:, None, :] ** powers, axis=2)
    arms = np.zeros((len(points), len(names)))
    for number, at in enumerate(place):
        lower = powers.copy()
        lower[:, number] = np.maximum(powers[:, number] - 1, 0)
        slopes = np.array(path.coefficients) * powers[:, number] * np.prod(q[:, None, :] ** lower, axis=2)
        arms[:, at] = -slopes.sum(axis=1)
    return terms.sum(axis=1), arms


@pytest.mark.usefixtures("stand_in")
def test_errors_jumps_and_dropped_points_of_a_fit_are_told() -> None:
    done = fit(REQUEST, 5)
    longer, equal = done.fits
    # 1 mm everywhere; all else is rounding of polynomials of order 5
    assert longer.length == pytest.approx((1e-3, 1e-3), rel=1e-9)
    assert max(equal.length) < 1e-14
    assert set(longer.arms) == {"r_shoulder_elev", "r_elbow_flex"}
    assert set(equal.arms) == {"r_elbow_flex"}
    assert max(error for fit in done.fits for arm in fit.arms.values() for error in arm) < 1e-14
    (jump,) = longer.jumps
    assert (jump.coordinate, round(jump.at, 3)) == ("r_shoulder_elev", 0.2)
    # and what the muscle lengthens in that step anyway
    assert jump.size == pytest.approx(3e-3, abs=5e-5)
    assert equal.jumps == ()
    assert (done.used, done.points) == (900, 31**2)


@pytest.mark.usefixtures("stand_in")
def test_the_command_prints_the_fit_and_takes_its_polynomials(command: Command, wrapped: Path) -> None:
    code, out, err = command("import", wrapped.name, "--fit", "--range", "shoulder=-1:0.5", "--out", "arm.toml")
    assert (code, err) == (0, "")
    assert "TRIlong  1.00 / 1.00                   0.00 / 0.00                0.00 / 0.00" in out
    assert "OpenSim has used 900 of 961 points: where one has no length it drops all later ones too" in out
    assert "TRIlong jumps by 3.0 mm at r_shoulder_elev = 0.2; no polynomial follows" in out
    code, out, err = command("import", str(DATA / "arm26_polynomial.osim"), "--fit")
    assert (code, err) == (0, "")
    assert "--fit has nothing to do: all muscles have polynomials" in out


@pytest.mark.usefixtures("stand_in")
@pytest.mark.parametrize(
    ("ranges", "sentence"),
    [
        (
            {"r_elbow_flex": None},
            "r_elbow_flex has no range over which to fit; give one with --range r_elbow_flex=LOW:HIGH",
        ),
        ({}, "no coordinate is free: there is nothing over which to fit"),
    ],
)
def test_there_must_be_a_range_over_which_to_fit(ranges: dict, sentence: str) -> None:
    with pytest.raises(ScenarioError, match=sentence):
        fit(FitRequest(Path("model.osim"), ("BRA",), ranges, REQUEST.joints, {}, ()), 5)


def test_without_opensim_the_extra_is_named(command: Command, wrapped: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(fitting.importlib.util, "find_spec", lambda _: None)
    done = command("import", wrapped.name, "--fit")
    assert done == (
        2,
        "",
        "hillobs: arm26.osim: --fit needs OpenSim, which is not installed: pip install 'hillobs[opensim]'\n",
    )
    assert (
        command("import", wrapped.name, "--fit", "--order", "12")[2]
        == "hillobs: --order must be a whole number from 2 to 9, not '12'\n"
    )


@pytest.mark.parametrize(
    ("program", "sentence"),
    [
        ("import sys; sys.exit('out of memory')", "OpenSim ended with code 1 before it had fitted: out of memory"),
        ("import os; os.abort()", "OpenSim ended with code -6 before it had fitted: "),
        ("open('answer.json', 'w').write('{\"error\": \"no such thing\"}')", "OpenSim has not fitted: no such thing"),
    ],
)
def test_a_fit_that_fails_is_a_sentence(
    program: str, sentence: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "program.py").write_text(program)
    monkeypatch.setattr(in_opensim, "__file__", str(tmp_path / "program.py"))
    monkeypatch.setattr(fitting.importlib.util, "find_spec", lambda name: name)
    with pytest.raises(ScenarioError) as caught:
        fit(REQUEST, 5)
    assert str(caught.value) == sentence


@needs_opensim
def test_opensim_fits_a_hinge_and_what_it_gives_is_as_good_as_is_said(wrapped: Path) -> None:
    done = []

    def fitted(request: FitRequest) -> dict[str, Polynomial]:
        done.append(fit(request, 5))
        return dict(done[0].polynomials)

    limits = {"elbow": (math.radians(5), math.radians(125))}
    hinge = mechanism_from(read_model(wrapped, None, {"shoulder": -0.1}, ["TRIlat", "BRA"], limits, fitted), "x")
    assert [path.joints for path in hinge.paths.values()] == [("elbow",), ("elbow",)]
    assert (done[0].used, done[0].points) == (201, 201)
    for one in done[0].fits:
        # the errors of order 5 that were measured on a grid of 1.5°: 0.07 mm, 0.15 mm, and arms of 1.4 mm
        assert one.length[0] < 1e-4
        assert one.length[1] < 2e-4
        assert one.arms["r_elbow_flex"][1] < 1.6e-3
        assert one.jumps == ()


@needs_opensim
def test_opensim_shows_where_a_wrapped_muscle_jumps(wrapped: Path) -> None:
    done = []

    def fitted(request: FitRequest) -> dict[str, Polynomial]:
        done.append(fit(request, 3))
        return dict(done[0].polynomials)

    read_model(wrapped, None, {"elbow": 1.0}, ["TRIlong", "BIClong"], {"shoulder": (-0.5, 0.6)}, fitted)
    jumps = {
        one.muscle: [(round(math.degrees(jump.at), 1), round(jump.size, 4)) for jump in one.jumps]
        for one in done[0].fits
    }
    assert jumps["TRIlong"] == [pytest.approx((-16.6, 0.0085), abs=0.1)]
    assert max(size for _, size in jumps["BIClong"]) > 0.05
