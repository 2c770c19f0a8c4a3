"""`make sweep`: the trade-off that the paper describes, as curves: error over ε_h, δ_s, δ_a, with and without noise."""

from __future__ import annotations

from pathlib import Path

import click

from .axes import Range
from .figures import write_figures
from .files import save_netcdf, writable_folder
from .sweep import sweep
from .sweep_figures import trade_off
from .terminal import print_table, user_errors

_TRIO = {
    "high_gain.eps_h": Range(0.02, 0.5, 25, logarithmic=True),
    "sliding_mode.delta_s": Range(0.001, 0.2, 25, logarithmic=True),
    "adaptive_sliding_mode.delta_a": Range(0.006, 0.2, 25, logarithmic=True),
}
_SEEDS = 40
_FOLDER = Path("results")


def main() -> None:
    """Run the three sweeps, write their results and figures, print the optima."""
    from .sweep_report import optimum

    with user_errors():
        folder = writable_folder(_FOLDER)
        for path, values in _TRIO.items():
            clean = sweep("paper-clean", {path: values})
            noisy = sweep("paper-noisy", {path: values}, seeds=_SEEDS)
            name = f"sweep-{path.rpartition('.')[2]}"
            for dataset, suffix in ((clean, "clean"), (noisy, "noisy")):
                save_netcdf(dataset, folder / f"{name}-{suffix}.nc")
            write_figures({"trade-off": trade_off(clean, noisy)}, folder, name)
            click.echo(f"{path}, {_SEEDS} seeds, with noise:")
            print_table(optimum(noisy))
        click.echo(f"written to {folder}/")


if __name__ == "__main__":
    main()
