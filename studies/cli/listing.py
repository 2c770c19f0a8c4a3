"""`hillobs show`, `list`, `docs`: what there is."""

from __future__ import annotations

import click

from ..files.pages import documentation, page
from ..scenarios.show import show as as_toml
from .reports.listing import listing
from .shell.options import scenario_argument
from .shell.terminal import say


@click.command()
@scenario_argument()
def show(scenario: str) -> None:
    """Print SCENARIO as a complete, commented TOML file to start from."""
    say(*as_toml(scenario).removesuffix("\n").split("\n"))


@click.command(name="list")
@click.argument("what", type=click.Choice(["all", "scenarios", "observers", "curves", "parameters"]), default="all")
def list_(what: str) -> None:
    """List scenarios, observers, curve sets, or parameters with default, unit and meaning."""
    say(*listing(what))


@click.command()
@click.argument("name", metavar="[PAGE]", required=False)
def docs(name: str | None) -> None:
    """Say where the pages of documentation are, or one of them, such as `observers`."""
    say(str(page(name) if name else documentation()))
