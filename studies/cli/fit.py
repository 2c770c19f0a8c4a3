"""`hillobs fit`: the Kalman filter's densities and orders by maximum likelihood."""

from __future__ import annotations

from pathlib import Path

import click

from ..estimate.fit import fitted
from ..files.writing import refuse_overwriting, writable_folder, write_whole
from ..laboratory.mapping import read_mapping
from ..scenarios.layers import Value
from .reports.estimates.fit import scenario_file, sentences
from .reports.written import written
from .shell.options import mapping_option, set_option
from .shell.progress import bar
from .shell.subjects import subject_asked_for
from .shell.terminal import say


@click.command()
@click.argument("source", metavar="SCENARIO|RECORDING")
@click.option("--muscles", metavar="FILE.toml", help="The muscles in SI, of a RECORDING.")
@click.option("--mechanism", metavar="FILE.toml", help="Or its joints and muscles.")
@mapping_option()
@set_option("A number of the scenario, or of the filter by hand: kalman.order_u=2.")
@click.option("--out", default="results", show_default=True, metavar="DIR", help="Where the numbers are written.")
def fit(
    source: str,
    muscles: str | None,
    mechanism: str | None,
    maps: tuple[str, ...],
    changes: dict[str, Value],
    out: str,
) -> None:
    """Find the densities and orders of the Kalman filter for which what was measured is likeliest.

    Of a SCENARIO, or with --muscles or --mechanism of a RECORDING. The numbers are written as a TOML file: that of a
    scenario can be run as it is, that of a recording is given to `hillobs estimate` with --set.
    """
    folder = writable_folder(Path(out))
    subject = subject_asked_for(muscles, mechanism) if muscles or mechanism else None
    with bar("fitting") as progress:
        found = fitted(source, subject, read_mapping(maps), changes, progress)
    path = folder / f"fitted-{found.label}.toml"
    refuse_overwriting([path])
    say(*sentences(found))
    write_whole(path, scenario_file(found).encode())
    say(written([path]))
