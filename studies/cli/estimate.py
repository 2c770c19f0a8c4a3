"""`hillobs estimate`: activations and more from a recording."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import click

from ..files.quote import escaped
from .terminal import bar, complain, print_table, user_errors

_NUMERICAL = 1


@click.command()
@click.argument("recording", metavar="RECORDING")
@click.option("--muscles", required=True, metavar="FILE.toml", help="The muscles in SI, see docs/recordings.md.")
@click.option("--observer", "observers", multiple=True, metavar="NAME", help="Only this observer; may be repeated.")
@click.option("--map", "maps", multiple=True, metavar="NAME=COLUMN", help="Name a column, e.g. position=block_x[mm].")
@click.option("--set", "settings", multiple=True, metavar="PATH=VALUE", help="A gain by hand: high_gain.eps_h=0.05.")
@click.option("--uncorrected", is_flag=True, help="Leave out the correction of the sliding mode observers' layers.")
@click.option("--every", default="1", show_default=True, metavar="N", help="Keep the estimates of every Nth sample.")
@click.option("--out", default="estimates", show_default=True, metavar="DIR", help="Where estimates are written.")
@click.option("--no-figures", is_flag=True, help="Write no figures.")
def estimate(
    recording: str,
    muscles: str,
    observers: tuple[str, ...],
    maps: tuple[str, ...],
    settings: tuple[str, ...],
    uncorrected: bool,
    every: str,
    out: str,
    no_figures: bool,
) -> None:
    """Estimate velocity, lengths, activations and disturbance from RECORDING: CSV, .sto or .mot, also gzipped.

    It needs time, position and both tendon forces. If it has the truth too, the estimates are scored.
    """
    with user_errors():
        from ..estimate.files import refuse_overwriting, save_estimates
        from ..estimate.run import estimate as estimated
        from ..estimate.scores import scores
        from ..files.numbers import whole_number
        from ..files.writing import writable_folder
        from ..laboratory.mapping import read_mapping
        from ..scenarios.scenario import parse_change
        from .reports.estimate import failures, notes, score_table

        folder = writable_folder(Path(out))
        refuse_overwriting((recording, muscles), folder)
        changes = dict(parse_change(text) for text in settings)
        begun = time.monotonic()
        with bar("following") as progress:
            dataset = estimated(
                recording,
                muscles,
                observers or None,
                read_mapping(maps),
                not uncorrected,
                changes,
                whole_number("--every", every, 1),
                progress,
            )
        seconds, samples = time.monotonic() - begun, int(dataset.attrs["samples"])
        for note in notes(dataset):
            click.echo(escaped(note))
        click.echo(f"read and followed in {seconds:.2g} s, {seconds / samples * 1e6:.2g} µs a sample")
        found = scores(dataset)
        if found:
            click.echo()
            print_table(score_table(found))
        with bar("writing"):
            paths = save_estimates(dataset, found, folder)
            if not no_figures:
                from ..figures.estimate import save_sheet

                paths += save_sheet(dataset, folder, "estimates")
        click.echo(escaped(f"written to {folder}/: {', '.join(path.name for path in paths)}"))
        ended = list(failures(dataset))
    for sentence in ended:
        complain(sentence)
    if ended:
        sys.exit(_NUMERICAL)
