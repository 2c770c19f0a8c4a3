"""A scenario as a page: it computes what the studies compute, whatever is moved and in whatever order."""

import re
from pathlib import Path

import casadi as ca
import pytest

from hillobs.codegen.targets import page as writer
from hillobs.model.block import Block, BlockError, symbols
from hillobs.model.curves import SIMULATED
from hillobs.observers import ESTIMATES, OBSERVERS
from hillobs.studies.export.pages import export_page, study_of
from hillobs.studies.files.errors import ResultError, ScenarioError
from hillobs.studies.scenarios.prepare import prepare
from pages import Page, asked, assert_shows
from places import OF_THE_PAIR
from tools import needs_node, needs_zig

# short, with errors that count; the grid can be taken twice as coarse
SHORT = {"duration": 2.0, "score.start": 0.4}
LARGEST = 150_000
# one after the other, each beside the scenario: gains, sensors, the plant, a number of two owners, one that an observer
# no longer shares, a tolerance, what makes an observer fail, what makes the plant fail, and nothing
MOVES = [
    {"high_gain.eps_h": 0.05},
    {"noise.x1": 0.002, "high_gain.eps_h": 0.05},
    {"plant.m": 1.2},
    {"muscle1.L_slack": 1.999},
    {"score.tolerance.x1": 1e-4},
    {"high_gain.eps_h": 1e-4},
    {"initial.x3": 20.0},
    {},
]


@pytest.fixture(params=["javascript", pytest.param("webassembly", marks=needs_zig)])
def language(request, monkeypatch):
    if request.param == "javascript":
        monkeypatch.setattr(writer, "webassembly", lambda calls: None)
    return request.param


def written(folder: Path, scenario: str = "paper-noisy", observers=None, changes=SHORT) -> Page:
    return Page(export_page(scenario, folder / "page.html", observers, changes))


@needs_node
def test_whatever_is_moved_it_shows_what_the_studies_compute(language: str, tmp_path: Path) -> None:
    page = written(tmp_path)
    assert page.language == language
    for changes, shown in zip(MOVES, page.run(*map(asked, MOVES)), strict=True):
        assert_shows(shown, prepare("paper-noisy", None, {**SHORT, **changes}))


@needs_node
def test_seeds_and_steps_are_those_of_the_studies(tmp_path: Path) -> None:
    large = 2**40 + 3
    one, other, coarse = written(tmp_path).run(asked({}, 5), asked({}, large), asked({}, 5, coarser=2))
    assert_shows(one, prepare("paper-noisy", None, {**SHORT, "seed": 5}))
    assert_shows(other, prepare("paper-noisy", None, {**SHORT, "seed": large}))
    assert_shows(coarse, prepare("paper-noisy", None, {**SHORT, "seed": 5, "step": 1e-3}))


@needs_node
@pytest.mark.chaos
def test_joints_and_muscles_are_as_those_of_the_pair(language: str, tmp_path: Path) -> None:
    changes = {"duration": 1.0, "score.start": 0.4}
    moves = [{}, {"high_gain.TRIlat.eps_L": 0.2, "high_gain.elbow.eps_h": 0.05}]
    page = written(tmp_path, "hinge", ["high_gain", "adaptive_sliding_mode"], changes)
    for move, shown in zip(moves, page.run(*map(asked, moves)), strict=True):
        assert_shows(shown, prepare("hinge", [*page.study["observers"]], {**changes, **move}))


@needs_node
@pytest.mark.chaos
@pytest.mark.parametrize("curves", SIMULATED)
def test_all_curves(language: str, curves: str, tmp_path: Path) -> None:
    changes = {**SHORT, "muscle.curves": curves}
    (shown,) = written(tmp_path, changes=changes).run(asked({}))
    assert_shows(shown, prepare("paper-noisy", None, changes))


@needs_node
@pytest.mark.chaos
@pytest.mark.parametrize("scenario", OF_THE_PAIR)
def test_every_scenario_of_the_pair_with_all_observers(language: str, scenario: str, tmp_path: Path) -> None:
    changes = {"noise.period": 0.005}
    (shown,) = written(tmp_path, scenario, [*OBSERVERS], changes).run(asked({}))
    assert_shows(shown, prepare(scenario, [*OBSERVERS], changes))


@needs_node
@pytest.mark.chaos
def test_each_end_of_each_slider_is_what_the_studies_compute(language: str, tmp_path: Path) -> None:
    page = written(tmp_path)
    ends = [{number["path"]: end} for number in page.study["numbers"] if number["reach"] for end in number["reach"]]
    for changes, shown in zip(ends, page.run(*map(asked, ends)), strict=True):
        if "broken" in shown:
            with pytest.raises(ScenarioError, match="must be below"):
                prepare("paper-noisy", None, {**SHORT, **changes})
        else:
            assert_shows(shown, prepare("paper-noisy", None, {**SHORT, **changes}))


@needs_node
def test_without_noise_nothing_is_held(tmp_path: Path) -> None:
    changes = {**SHORT, "noise.period": 0.0}
    (shown,) = written(tmp_path, changes=changes).run(asked({}))
    assert_shows(shown, prepare("paper-noisy", None, changes))


@needs_node
def test_numbers_that_do_not_fit_together_are_named_and_nothing_runs(tmp_path: Path) -> None:
    page = written(tmp_path, changes={**SHORT, "plant.drive": "requested"})
    steep, far = page.run(asked({"muscle2.k": 40.0}), asked({"muscle1.z_max": 1.6}))
    assert steep == {"broken": "muscle2: k·toe must be below 2.5 F_toe, or the tendon force does not rise in the toe"}
    assert far == {"broken": "muscle1.z_max must be below muscle1.g_max, the pole of g⁻¹"}


def test_it_is_one_small_file_that_asks_for_nothing(tmp_path: Path) -> None:
    """Written twice it is the same; addresses are names of vocabularies, licences and authors only."""
    page, again = written(tmp_path), written(tmp_path)
    assert page.text == again.text
    assert len(page.text.encode()) <= LARGEST
    assert not re.findall(r"(?:src|href)=\"(?!data:)|url\(|@import|fetch\(|XMLHttpRequest", page.text)


def test_no_slider_goes_where_its_number_must_not_be() -> None:
    for scenario in OF_THE_PAIR:
        prepared = prepare(scenario, [*OBSERVERS], {})
        for number in study_of(prepared).numbers:
            parameter = prepared.paths.parameters[number.path]
            for end in number.reach or ():
                assert parameter.objection(end) == "", number
            if number.reach:
                low, high = number.reach
                assert low <= number.value <= high
                assert not number.logarithmic or low * high > 0


def test_an_equation_that_no_page_has_a_word_for_is_named(tmp_path: Path) -> None:
    u = symbols("y1")
    y = {estimate: ca.erf(u.y1) if estimate == "x1_hat" else ca.SX(0) for estimate in ESTIMATES}
    with pytest.raises(BlockError, match=r"^mine_out: CasADi's erf has no word in JavaScript$"):
        written(tmp_path, observers=Block("mine", u=u, y=y))
    assert not list(tmp_path.iterdir())


def test_a_run_that_no_browser_can_keep_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        ScenarioError, match=r"^a page keeps all steps of a run: 2,000,000 of them would take 1,\d\d\d MB"
    ):
        written(tmp_path, changes={"duration": 1000.0})
    assert not list(tmp_path.iterdir())


def test_a_page_is_written_over_nothing_of_the_user(tmp_path: Path) -> None:
    (tmp_path / "page.html").write_text("mine")
    with pytest.raises(ResultError, match="is there already"):
        written(tmp_path)
    assert (tmp_path / "page.html").read_text() == "mine"
