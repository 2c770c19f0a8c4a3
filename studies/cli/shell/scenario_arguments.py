"""The argument SCENARIO, and how a shell completes it: without CasADi, for commands that need none."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click
from click.shell_completion import CompletionItem

from ...scenarios.layers import shipped

Decorator = Callable[[Any], Any]

_SCENARIO = "SCENARIO|FILE.toml"


def scenario_argument(default: str | None = None) -> Decorator:
    """SCENARIO: a shipped scenario or a TOML file."""
    word = _SCENARIO if default is None else f"[{_SCENARIO}]"
    required = default is None
    return click.argument(
        "scenario", default=default, required=required, metavar=word, shell_complete=_complete_scenarios
    )


def scenarios_argument() -> Decorator:
    """Any number of them: a tuple."""
    return click.argument("scenarios", nargs=-1, metavar=f"[{_SCENARIO}]...", shell_complete=_complete_scenarios)


def _complete_scenarios(ctx: click.Context, param: click.Parameter, incomplete: str) -> list[CompletionItem]:
    names = [CompletionItem(name) for name in shipped() if name.startswith(incomplete)]
    return [*names, CompletionItem(incomplete, type="file")]
