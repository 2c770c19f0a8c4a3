"""`make sweep`: the trade-off that the paper describes: error over ε_h, δ_s, δ_a, and over ε_h and the noise."""

from __future__ import annotations

from pathlib import Path

from ...figures.page import write_figures
from ...figures.sweep.curves import curves
from ...figures.sweep.figures import SHOWN, sweep_figures
from ...files.netcdf import save_netcdf
from ...files.writing import writable_folder
from ...sweep.axes import Range
from ...sweep.run import sweep
from ..reports.sweep import notes, tables
from ..terminal import print_table, say, user_errors

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


def main() -> None:
    """Run the sweeps, write their results and figures, print the optima."""
    with user_errors():
        folder = writable_folder(_FOLDER)
        for path, values in _TRIO.items():
            clean = sweep("paper-clean", {path: values})
            noisy = sweep("paper-noisy", {path: values}, seeds=_SEEDS)
            name = f"sweep-{path.rpartition('.')[2]}"
            for dataset, suffix in ((clean, "clean"), (noisy, "noisy")):
                save_netcdf(dataset, folder / f"{name}-{suffix}.nc")
            write_figures({"trade-off": curves(noisy, SHOWN, clean)}, folder, name)
            say(f"{path}, {_SEEDS} seeds, with noise:")
            say(*notes(noisy))
            for table in tables(noisy):
                print_table(table)
        dataset = sweep("paper-noisy", _MAP, seeds=_MAP_SEEDS)
        save_netcdf(dataset, folder / "sweep-eps_h-noise.nc")
        write_figures(sweep_figures(dataset)[0], folder, "sweep-eps_h-noise")
        say(f"written to {folder}/")


if __name__ == "__main__":
    main()
