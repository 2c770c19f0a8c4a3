"""`hillobs errata`: what each misprint changes."""

from __future__ import annotations

import click

from ..errata.run import errata as study
from .reports.errata import tables
from .shell.progress import bar
from .shell.tables import print_table


@click.command()
def errata() -> None:
    """Run the controller and the adaptive observer as printed beside the corrected ones."""
    with bar("errata") as advance:
        results = study(advance)
    for table in tables(results):
        print_table(table)
