"""A new observer is one file and one line: then simulations, sweeps, recordings, lists and conformance have it."""

import json
from collections.abc import Iterator

import numpy as np
import pytest

import hillobs
from double_pole import DOUBLE_POLE, double_pole
from few_observers import few_observers
from hillobs.model.block import symbols
from hillobs.model.system import PAIR
from hillobs.observers import OBSERVERS, PAPER, Observer
from hillobs.observers.conditions import FACTS
from hillobs.studies.cli.reports.listing import listing
from places import RECORDINGS

SHORT = {"duration": 1.0, "score.start": 0.5}
RECORDING, MUSCLES = RECORDINGS / "dgf_smooth_noisy.csv.gz", RECORDINGS / "dgf_smooth.toml"


@pytest.fixture
def registered() -> Iterator[None]:
    """A registry of one of ours, with one line more."""
    with few_observers("high_gain") as patched:
        patched.setitem(OBSERVERS, "double_pole", DOUBLE_POLE)
        yield


@pytest.mark.usefixtures("registered")
def test_a_line_in_the_registry_is_enough() -> None:
    pair = ["double_pole", "high_gain"]
    run = hillobs.simulate("paper-noisy", pair, {**SHORT, "double_pole.rate": 20, "high_gain.eps_h": 0.05})
    for name in ("x_hat", "u_hat", "a_hat", "Delta_hat"):
        mine, theirs = (run[name].sel(observer=observer).values for observer in pair)
        # equal but for roundings, which injections of r³ = 8000 raise
        np.testing.assert_allclose(mine, theirs, rtol=1e-9, atol=1e-9)
    assert "double_pole" not in json.loads(run.attrs["violated_conditions"])

    fast = hillobs.simulate("paper-noisy", "double_pole", {**SHORT, "double_pole.rate": 2000})
    assert json.loads(fast.attrs["violated_conditions"])["double_pole"] == [
        "r < 200: 2000 < 200 does not hold",
        "h r < 0.75 (integration): 1 < 0.75 does not hold",
    ]

    swept = hillobs.sweep("paper-noisy", {"double_pole.rate": [5.0, 20.0, 300.0]}, seeds=2, changes=SHORT)
    assert swept.observer.values.tolist() == ["double_pole"]
    assert np.isfinite(swept.rmse).all()
    assert "r < 200" in json.dumps(swept.attrs)

    found = hillobs.estimate(RECORDING, MUSCLES, pair)
    eps = json.loads(found.attrs["sizes"])["joints"]["mass"]["eps"]
    assert json.loads(found.attrs["gains"])["double_pole"] == {"double_pole.rate": 1 / eps}
    same = hillobs.estimate(RECORDING, MUSCLES, "high_gain", changes={"high_gain.eps_L": eps})
    np.testing.assert_allclose(found.activation_hat.sel(observer="double_pole"), same.activation_hat[0], atol=1e-9)

    assert hillobs.conformance(double_pole()) == []
    (line,) = [line for line in listing("observers") if "double_pole" in line]
    assert "2P: The high-gain observer written once more" in line


def test_each_observer_has_the_name_of_its_line_and_the_papers_are_among_them() -> None:
    assert [observer.block().name for observer in OBSERVERS.values()] == list(OBSERVERS)
    assert [observer.block(corrected=True).name for observer in OBSERVERS.values()] == list(OBSERVERS)
    assert set(PAPER) < set(OBSERVERS)
    run = hillobs.simulate("paper-noisy", changes=SHORT)
    assert run.observer.values.tolist() == list(PAPER)


@pytest.mark.parametrize("observer", OBSERVERS.values(), ids=list(OBSERVERS))
def test_only_layers_are_corrected(observer: Observer) -> None:
    plain, corrected = observer.block(False), observer.block(True)
    layered = plain.name.endswith("sliding_mode")
    assert (list(corrected.x) != list(plain.x)) == layered
    extra = set(observer.rates(corrected.p)) - set(observer.rates(plain.p))
    assert extra == ({"1/τ_c"} if layered else set())


@pytest.mark.parametrize("name", OBSERVERS)
def test_steps_are_limited_by_the_rates_that_recordings_use(name: str) -> None:
    observer = OBSERVERS[name]
    p, facts = observer.block().p, symbols(FACTS)
    conditions = [c.name for c in observer.conditions(PAIR, p, facts) if c.name.endswith("(integration)")]
    assert conditions == [f"h {rate} < {observer.limit:g} (integration)" for rate in observer.rates(p)]
