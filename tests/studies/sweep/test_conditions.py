"""The gain conditions of a sweep are those of its points."""

import json
from pathlib import Path

import xarray as xr

from hillobs.studies.files.datasets.netcdf import load, save_netcdf
from hillobs.studies.simulate.run import simulate
from hillobs.studies.sweep.run import sweep
from short_sweeps import LAYER, SHORT

# of the paper's scenario
STEP, ALPHA = 5e-4, 1.1


def test_gain_conditions_are_those_of_each_point() -> None:
    """What `simulate` says of every point alone, and nothing else."""
    over = {"high_gain.eps_h": [2e-4, 8e-4, 0.1], "step": [5e-4, 1e-3]}
    swept = sweep("paper-clean", over, observers=["high_gain", "sliding_mode"], changes=SHORT)
    broken: dict[str, int] = {}
    for eps in over["high_gain.eps_h"]:
        for step in over["step"]:
            alone = simulate("paper-clean", None, {**SHORT, "high_gain.eps_h": eps, "step": step})
            for sentence in json.loads(alone.attrs["violated_conditions"]).get("high_gain", []):
                name = sentence.rpartition(": ")[0]
                broken[name] = broken.get(name, 0) + 1
    said = json.loads(swept.attrs["violated_conditions"])
    # ε_L follows ε_h
    assert broken == {f"h ρ/{eps} < 0.75 (integration)": 3 for eps in ("ε_h", "ε_L")}
    assert said["high_gain"] == [
        f"{name} does not hold at 3 of 6 points, all with high_gain.eps_h ≤ 0.0008" for name in broken
    ]
    assert said["sliding_mode"][0].endswith("does not hold at every point")


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
