"""A user's own observer in a scenario: its name, states, outputs and domain; held inputs, samples and steps."""

import json
from dataclasses import replace
from pathlib import Path

import pytest
import xarray as xr

from documents import refusal
from hillobs.model.block import Block, BlockError, Parameter, Symbols, symbols
from hillobs.observers.ports import ESTIMATES
from hillobs.studies.files.errors import ScenarioError
from hillobs.studies.simulate.files import save
from hillobs.studies.simulate.run import simulate


def own_observer(name: str = "mine", default: float = 20.0, state: str = "", **outputs: float) -> Block:
    """A user's observer that stands still, with one parameter and perhaps a state of its own."""
    x = symbols([*ESTIMATES, *([state] if state else [])])
    parameters = {"gain": Parameter(default, "a gain", "this test", above=0)}
    p, u = symbols(parameters), symbols("y1")
    dx = Symbols(dict.fromkeys(x, 0.0))
    dx["x1_hat"] = p.gain * (u.y1 - x.x1_hat)
    start = Symbols(dict.fromkeys(x, 2.0))
    y = Symbols({**{name: x[name] for name in ESTIMATES}, **outputs})
    return Block(name, x=x, u=u, p=p, parameters=parameters, dx=dx, x0=start, y=y)


BRIEF = {"duration": 0.05, "score.start": 0.0}


@pytest.mark.parametrize("name", ["a__b", "a_", "seed", "activation", "baseline", "plant", "muscle"])
def test_a_name_that_cannot_be_is_a_sentence(name: str) -> None:
    """A block whose name the code generator or the table of paths cannot take is refused, or it runs."""
    if sentence := refusal(lambda: simulate("paper-clean", [own_observer(name)], BRIEF)):
        assert name in sentence
        return
    run = simulate("paper-clean", [own_observer(name)], BRIEF)
    assert json.loads(run.attrs["parameters"])[f"{name}.gain"] == 20.0


@pytest.mark.parametrize(("name", "state"), [("x", "hat"), ("mine", "a/b"), ("mine", "a\0b")])
def test_a_state_of_ones_own_hides_nothing_and_can_be_written(name: str, state: str, tmp_path: Path) -> None:
    if sentence := refusal(lambda: save(simulate("paper-clean", [own_observer(name, state=state)], BRIEF), tmp_path)):
        assert repr(state)[1:-1] in sentence
        return
    run = simulate("paper-clean", [own_observer(name, state=state)], BRIEF)
    assert run.x_hat.dims == ("observer", "time", "state")
    assert run.u_hat.dims == ("observer", "time", "muscle")


def test_two_states_of_two_observers_do_not_share_a_variable() -> None:
    two = [own_observer("a", state="b_c"), own_observer("a_b", state="c")]
    if sentence := refusal(lambda: simulate("paper-clean", two, BRIEF)):
        assert "a_b" in sentence
        return
    run = simulate("paper-clean", two, BRIEF)
    assert {v.attrs["observer"] for v in run.data_vars.values() if "state" in v.attrs} == {"a", "a_b"}


def test_one_activation_of_ones_own_is_kept_or_refused() -> None:
    if sentence := refusal(lambda: simulate("paper-clean", [own_observer(a1_hat=0.123)], BRIEF)):
        assert "a2_hat" in sentence
        return
    run = simulate("paper-clean", [own_observer(a1_hat=0.123)], BRIEF)
    assert (run.a_hat.sel(muscle=1) == 0.123).all()


@pytest.mark.parametrize("default", [float("nan"), -1.0])
def test_a_default_out_of_its_own_bounds_is_refused(default: float) -> None:
    with pytest.raises((ScenarioError, BlockError), match="gain"):
        simulate("paper-clean", [own_observer(default=default)], BRIEF)


def sampled(way: str) -> Block:
    """Counts samples or steps in a state n."""
    x = symbols([*ESTIMATES, "n"])
    still = Symbols(dict.fromkeys(ESTIMATES, 0.0))
    y = Symbols({name: x[name] for name in ESTIMATES})
    return Block(
        f"counter_{way}", x=x, dx=still, y=y, x0=Symbols(dict.fromkeys(ESTIMATES, 2.0)), **{way: Symbols(n=x.n + 1)}
    )


@pytest.fixture(scope="module")
def several() -> xr.Dataset:
    """A run of observers of many kinds, for which one library is enough."""
    mine = own_observer()
    kinds = [
        mine,
        replace(mine, name="holding", held=frozenset(["y1"])),
        replace(mine, name="leaving", domain=Symbols(room=2.2 - mine.x.x1_hat)),
        sampled("next"),
        sampled("per_step"),
    ]
    gains = {"mine.gain": 200.0, "holding.gain": 200.0}
    return simulate("paper-clean", kinds, {**BRIEF, "step": 5e-4, "noise.period": 5e-3, **gains})


def test_an_observer_that_leaves_its_own_domain_is_named(several: xr.Dataset) -> None:
    (failure,) = json.loads(several.attrs["failures"]).items()
    assert failure[0] == "leaving"
    assert failure[1].startswith("leaving: room, which must stay positive, is not at τ = ")


def test_a_held_input_is_held(several: xr.Dataset) -> None:
    """The same observer with y1 held over a step must not be the one that sees it move."""
    x1 = several.x_hat.sel(state="x1")
    assert 0 < abs(x1.sel(observer="mine") - x1.sel(observer="holding")).max() < 1e-4


def test_states_move_at_samples_and_at_steps(several: xr.Dataset) -> None:
    assert several.counter_next_n.values.tolist() == [1, 3, 5, 7, 9, 11]
    assert several.counter_per_step_n.values.tolist() == [1, 21, 41, 61, 81, 101]


def test_a_sampled_observer_without_samples_is_said() -> None:
    """noise.period = 0 switches the samples off too: an observer that moves at samples stands still."""
    with pytest.raises((ScenarioError, BlockError), match=r"counter|sample"):
        simulate("paper-noisy", [sampled("next")], {**BRIEF, "noise.period": 0.0})


def test_an_observer_with_other_ports_is_refused_by_name() -> None:
    x, u = symbols(ESTIMATES), symbols("y1 y4")
    y, dx = Symbols(x), Symbols(dict.fromkeys(x, 0.0))
    with pytest.raises(BlockError, match=r"w: an observer sees t, y1, y2, y3\b.* only, not y4"):
        simulate("paper-clean", [Block("w", x=x, u=u, dx=dx, y=y)], BRIEF)
    del y["u2_hat"]
    with pytest.raises(BlockError, match="w: an observer must estimate u2_hat as well"):
        simulate("paper-clean", [Block("w", x=x, dx=dx, y=y)], BRIEF)
