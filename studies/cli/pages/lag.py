"""`make lag`: the figure of docs/kalman.md, how much better estimates become the later they may be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import xarray as xr

from ... import laboratory
from ...estimate.run import estimate
from ...estimate.scores import scores
from ...figures.lag import lag_figure
from ...figures.page import content
from ...files.writing import write_whole
from ...laboratory.recording import read_recording
from ..shell.stopping import stoppable
from ..shell.terminal import say

_RECORDINGS = Path(laboratory.__path__[0]) / "recordings"
_LAGS = np.array([0, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2])  # s
_PASSES = {"first pass, inputs as states": "u", "second pass, activations as states": "a"}
# label, its quantity, and in how many of the label's units one of the Dataset is
_PANELS = {
    "RMSE of the activations": ("activation", 1.0),
    "RMSE of the velocity in mm/s": ("velocity", 1e3),
}
_FIGURE = Path("docs") / "kalman-lag.png"


def main() -> None:
    """Follow the shipped recording once for each lag and pass, and draw the errors."""
    recording = read_recording(_RECORDINGS / "dgf_smooth_noisy.csv.gz")
    muscles = _RECORDINGS / "dgf_smooth.toml"

    def run(form: str, lag: float = 0.0, smooth: bool = False) -> xr.Dataset:
        return estimate(recording, muscles, "kalman", form=form, lag=lag, smooth=smooth, usual_doubt=False)

    late = {name: [run(form, lag=lag) for lag in _LAGS.tolist()] for name, form in _PASSES.items()}
    whole = {name: run(form, smooth=True) for name, form in _PASSES.items()}
    panels = {
        label: {
            name: ([unit * _rmse(one, quantity) for one in late[name]], unit * _rmse(whole[name], quantity))
            for name in _PASSES
        }
        for label, (quantity, unit) in _PANELS.items()
    }
    write_whole(_FIGURE, content(lag_figure(_LAGS, panels), "png"))
    say(f"written to {_FIGURE}")


def _rmse(dataset: xr.Dataset, quantity: str) -> float:
    return next(score.rmse for score in scores(dataset) if score.quantity == quantity and score.together)


if __name__ == "__main__":
    stoppable(main)
