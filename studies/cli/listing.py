"""`hillobs show`, `list`, `docs`: what there is."""

from __future__ import annotations

import click

from ..files.kept import kept_text
from ..files.pages import documentation, page
from ..scenarios.layers import shipped
from .shell.scenario_arguments import scenario_argument
from .shell.terminal import say


@click.command()
@scenario_argument()
def show(scenario: str) -> None:
    """Print SCENARIO as a complete, commented TOML file to start from."""
    text = kept_text(f"show {scenario}", lambda: _toml(scenario)) if scenario in shipped() else _toml(scenario)
    say(*text.removesuffix("\n").split("\n"))


@click.command(name="list")
@click.argument("what", type=click.Choice(["all", "scenarios", "observers", "curves", "parameters"]), default="all")
def list_(what: str) -> None:
    """List scenarios, observers, curve sets, or parameters with default, unit and meaning."""
    say(*kept_text(f"list {what}", lambda: _listing(what)).split("\n"))


@click.command()
@click.argument("name", metavar="[PAGE]", required=False)
def docs(name: str | None) -> None:
    """Say where the pages of documentation are, or one of them, such as `observers`."""
    say(str(page(name) if name else documentation()))


# CasADi takes longer to come than a text that is kept


def _toml(scenario: str) -> str:
    from ..scenarios.show import show as as_toml

    return as_toml(scenario)


def _listing(what: str) -> str:
    from .reports.listing import listing

    return "\n".join(listing(what))
