"""`hillobs show`, `list`, `info`, `clean`: what there is."""

from __future__ import annotations

import click

from ...codegen.cache import clean_cache
from ..scenarios.show import show as as_toml
from .options import scenario_argument
from .reports.listing import information, listing, sources
from .reports.number import counted


@click.command()
@scenario_argument()
def show(scenario: str) -> None:
    """Print SCENARIO as a complete, commented TOML file to start from."""
    click.echo(as_toml(scenario), nl=False)


@click.command(name="list")
@click.argument("what", type=click.Choice(["all", "scenarios", "observers", "curves", "parameters"]), default="all")
def list_(what: str) -> None:
    """List scenarios, observers, curve sets, or parameters with default, unit and meaning."""
    for line in listing(what):
        click.echo(line)


@click.command()
@click.option("--source", is_flag=True, help="The generated C++ of each compiled library instead, the newest first.")
def info(source: bool) -> None:
    """Show versions, compiler, pages and cache."""
    for line in sources() if source else information():
        click.echo(line)


@click.command()
def clean() -> None:
    """Empty the cache of compiled libraries."""
    removed = clean_cache()
    click.echo(f"removed {counted(len(removed), 'file')}" if removed else "the cache was empty")
