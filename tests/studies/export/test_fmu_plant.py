"""The plant as an FMU: what `simulate` does, alone and beside an observer in one program."""

import re
import subprocess
import sys
import textwrap
from pathlib import Path

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from exported_fmus import VERSIONS, instance, saved_fmus, this_machine_only
from exported_programs import needs_cc
from hillobs.studies.export.files import save_fmus
from hillobs.studies.export.plant import exported_plant
from hillobs.studies.export.run import export_fmu, export_plant
from hillobs.studies.simulate.run import simulate
from places import DOCS

pytestmark = [pytest.mark.chaos, needs_cc, pytest.mark.usefixtures("this_machine_only")]
__all__ = ["this_machine_only"]
# the same 40,000 steps in another order of operations, 2e-16 each, of a loop that is stable; forces are steep, 10² over
# the tendons' lengths
ROUNDING, ROUNDING_OF_FORCES = 1e-13, 1e-11
QUIET = {"noise.x1": 0.0, "noise.force": 0.0}


# one with pulses too, which start and stop at a step
@pytest.mark.parametrize("scenario", ["paper-clean", "slack", "activation"])
def test_it_moves_and_is_measured_as_in_a_simulation(scenario: str, tmp_path: Path) -> None:
    save_fmus(exported_plant(scenario), tmp_path)
    run = simulate(scenario, "high_gain", QUIET)
    names = [*map(str, run.state.values), "y1", "y2", "y3"]
    expected = np.hstack([run.x.values, run.y.values])
    record = float(run.time[1])
    for version in VERSIONS:
        assert validate_fmu(str(tmp_path / f"plant-{version}.fmu")) == []
        with instance(tmp_path, "plant", version) as plant:
            plant.begin()
            rows = [plant.get(names)]
            for k in range(len(run.time) - 1):
                plant.step(k * record, record)
                rows.append(plant.get(names))
        off = np.abs(np.array(rows) - expected).max(axis=0)
        assert (off[:-2] < ROUNDING).all()
        assert (off[-2:] < ROUNDING_OF_FORCES).all()


def test_a_mechanism_moves_as_in_a_simulation(tmp_path: Path) -> None:
    changes = {"duration": 2.0, "score.start": 1.0}
    save_fmus(exported_plant("arm", changes), tmp_path)
    run = simulate("arm", "high_gain", changes)
    names, record = [*map(str, run.state.values)], float(run.time[1])
    with instance(tmp_path, "plant", "fmi3") as plant:
        plant.begin()
        rows = [plant.get(names)]
        for k in range(len(run.time) - 1):
            plant.step(k * record, record)
            rows.append(plant.get(names))
    np.testing.assert_allclose(rows, run.x.values, rtol=0, atol=1e-10)


def distance(folder: Path, version: str, period: float) -> float:
    """How far the estimates of activations, by an observer that meets the plant each period, are from `simulate`'s."""
    other = saved_fmus(folder / str(period), "high_gain", period=period)
    run = simulate("paper-clean", "high_gain", {"record": period, "noise.period": period}, corrected=True)
    ours = run.a_hat.sel(observer="high_gain").values
    rows = []
    with instance(folder, "plant", version) as plant, instance(other, "high_gain", version) as observer:
        plant.begin()
        observer.begin()
        for k in range(len(run.time)):
            observer.set(dict(zip(("y1", "y2", "y3"), plant.get(["y1", "y2", "y3"]), strict=True)))
            observer.step(k * period, period)
            plant.step(k * period, period)
            rows.append(observer.get(["a1_hat", "a2_hat"]))
    # the simulation's observer starts elsewhere, which is forgotten like e^(−t/ε), with ε = 0.1
    late = run.time.values > 4
    return float(np.abs(np.array(rows) - ours)[late].max())


@pytest.mark.parametrize("version", VERSIONS)
def test_beside_it_an_observer_estimates_what_it_does_in_a_simulation(version: str, tmp_path: Path) -> None:
    save_fmus(exported_plant(), tmp_path)
    # a simulation shows the observer its measurements at all moments; here they go in straight lines from sample to
    # sample, off by T² y″/8 at most: half the period leaves a quarter of that
    whole, half = (distance(tmp_path, version, period) for period in (0.01, 0.005))
    assert 3.5 < whole / half < 4.5


def test_the_programs_of_the_page_meet_as_it_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    page = (DOCS / "fmu.md").read_text(encoding="utf-8")
    (script,) = re.findall(r"^```py\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    printed = re.search(r"^```py\n.*?^```\n\n(.*?)\n\n", page, re.DOTALL | re.MULTILINE)
    monkeypatch.chdir(tmp_path)
    export_plant("fmu")
    export_fmu("high_gain", 0.005, "fmu")
    (tmp_path / "meet.py").write_text(script, encoding="utf-8")
    done = subprocess.run([sys.executable, "meet.py"], capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.stdout == textwrap.dedent(printed[1]) + "\n"
