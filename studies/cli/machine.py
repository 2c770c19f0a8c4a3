"""`hillobs info`, `clean`: what is compiled, and on which machine."""

from __future__ import annotations

import click

from ...codegen.cache import clean_cache
from .reports.machine import information, sources
from .reports.number import counted
from .shell.terminal import say


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
