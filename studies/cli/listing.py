"""`hillobs show`, `list`, `docs`, `info`, `clean`: what there is."""

from __future__ import annotations

import click

from ...codegen.cache import clean_cache
from ..files.pages import documentation, page
from ..scenarios.show import show as as_toml
from .reports.listing import information, listing, sources
from .reports.number import counted
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


@click.command()
@click.option("--source", is_flag=True, help="The generated C++ of each compiled library instead, the newest first.")
def info(source: bool) -> None:
    """Show versions, compiler, pages and cache."""
    say(*(sources() if source else information()))


@click.command()
def clean() -> None:
    """Empty the cache of compiled libraries."""
    removed = clean_cache()
    say(f"removed {counted(len(removed), 'file')}" if removed else "the cache was empty")
