"""`make sweep`: the trade-off that the paper describes: error over ε_h, δ_s, δ_a, and over ε_h and the noise."""

from __future__ import annotations

import itertools
from pathlib import Path

from ....observers import PAPER
from ...figures.page import write_figures
from ...figures.sweep.curves import curves
from ...figures.sweep.figures import SHOWN, save_sweep_figures
from ...files.datasets.netcdf import save_netcdf
from ...files.pictures import figure_paths
from ...files.writing import refuse_overwriting, writable_folder
from ...sweep.axes import Range, axes
from ...sweep.pictures import sweep_figure_paths
from ...sweep.run import sweep
from ..reports.sweep import notes, tables
from ..shell.stopping import stoppable
from ..shell.tables import print_table
from ..shell.terminal import say, user_errors

_TRIO = {
    "high_gain.eps_h": Range(0.02, 0.5, 25, logarithmic=True),
    "sliding_mode.delta_s": Range(0.001, 0.2, 25, logarithmic=True),
    "adaptive_sliding_mode.delta_a": Range(0.006, 0.2, 25, logarithmic=True),
}
_SEEDS = 40
# how the best ε_h moves with the noise: from none to speak of to ten times the paper's
_MAP = {
    "high_gain.eps_h": Range(0.02, 0.5, 25, logarithmic=True),
    "noise.x1": Range(1e-5, 1e-2, 13, logarithmic=True),
}
_MAP_SEEDS = 8
_FOLDER = Path("results")
_TRADE_OFF, _MAP_NAME = "trade-off", "sweep-eps_h-noise"


def main() -> None:
    """Run the sweeps, write their results and figures, print the optima."""
    with user_errors():
        folder = writable_folder(_FOLDER)
        map_paths = sweep_figure_paths(axes(_MAP), PAPER, folder, _MAP_NAME)
        refuse_overwriting([*itertools.chain(*map(_paths, _TRIO)), _FOLDER / f"{_MAP_NAME}.nc", *map_paths])
        for path, values in _TRIO.items():
            clean = sweep("paper-clean", {path: values})
            noisy = sweep("paper-noisy", {path: values}, seeds=_SEEDS)
            clean_path, noisy_path, *_ = _paths(path)
            save_netcdf(clean, clean_path)
            save_netcdf(noisy, noisy_path)
            write_figures({_TRADE_OFF: curves(noisy, SHOWN, clean)}, folder, _name(path))
            say(f"{path}, {_SEEDS} seeds, with noise:")
            say(*notes(noisy))
            for table in tables(noisy):
                print_table(table)
        dataset = sweep("paper-noisy", _MAP, seeds=_MAP_SEEDS)
        save_netcdf(dataset, folder / f"{_MAP_NAME}.nc")
        save_sweep_figures(dataset, folder, _MAP_NAME)
        say(f"written to {folder}/")


def _paths(path: str) -> list[Path]:
    """The files of the sweeps over one parameter: clean, noisy, and their figure."""
    results = [_FOLDER / f"{_name(path)}-{suffix}.nc" for suffix in ("clean", "noisy")]
    return [*results, *figure_paths(_FOLDER, _name(path), [_TRADE_OFF])]


def _name(path: str) -> str:
    return f"sweep-{path.rpartition('.')[2]}"


if __name__ == "__main__":
    stoppable(main)
