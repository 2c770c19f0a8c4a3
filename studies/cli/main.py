"""`hillobs`: the commands, each in a file of its own, and how they end."""

from __future__ import annotations

import contextlib
import difflib
import importlib
import logging
import os
import sys
import warnings
from collections.abc import Mapping
from typing import TextIO

import click

from ..files.quote import short, shown
from ..files.reading import remembered_reading
from .shell.terminal import USAGE, complain, say, user_errors

_READER_GONE = 141

# command → its module here, and what it does: modules wait until their command is asked for
_COMMANDS: Mapping[str, tuple[str, str]] = {
    "simulate": ("simulate", "Simulate scenarios: measures, results, figures."),
    "sweep": ("sweep", "Run a scenario over parameters and seeds."),
    "tune": ("tune", "Find gains of an observer by trial."),
    "estimate": ("estimate", "Estimate activations and more from a recording."),
    "calibrate": ("calibrate", "Find muscles' numbers by trials of known activation."),
    "live": ("live", "Estimate from samples as they come, line by line."),
    "import": ("importing", "Make a mechanism file of an OpenSim model."),
    "fit": ("fit", "Find the Kalman filter's densities by likelihood."),
    "export": ("export", "Write an observer as C, FMUs or a page for other programs."),
    "observability": ("observability", "Say what some sensors determine at a point."),
    "figures": ("figures", "Draw the figures of a result again."),
    "curves": ("figures", "Draw the muscle's curves of every publication."),
    "errata": ("errata", "Run the paper's printed forms beside the corrected ones."),
    "show": ("listing", "Print a scenario as a TOML file to start from."),
    "list": ("listing", "List scenarios, observers, curves, parameters."),
    "docs": ("listing", "Say where the pages of documentation are."),
    "info": ("machine", "Show versions, compiler, pages and cache."),
    "clean": ("machine", "Empty the cache of compiled libraries."),
}
# words of Python, whose functions end with an underscore
_TAKEN = ("import", "list")


class _Commands(click.Group):
    """Imports the module of a command when it is asked for: CasADi and xarray take a second."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        return list(_COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        if cmd_name not in _COMMANDS:
            return None
        module = importlib.import_module(f".{_COMMANDS[cmd_name][0]}", __package__)
        command: click.Command = getattr(module, f"{cmd_name}_" if cmd_name in _TAKEN else cmd_name)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        with formatter.section("Commands"):
            formatter.write_dl([(name, sentence) for name, (_, sentence) in _COMMANDS.items()])

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args and args[0] not in _COMMANDS and (near := difflib.get_close_matches(short(args[0]), _COMMANDS)):
            ctx.fail(f"there is no command {shown(args[0])}; the nearest are {', '.join(near)}")
        return super().resolve_command(ctx, args)

    def invoke(self, ctx: click.Context) -> object:
        with remembered_reading(), user_errors():
            return super().invoke(ctx)


@click.group(cls=_Commands, invoke_without_command=True, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="hillobs", prog_name="hillobs")
@click.pass_context
def commands(ctx: click.Context) -> None:
    """Observers for a pair of Hill muscles: states, unknown inputs and activations."""
    if ctx.invoked_subcommand is None:
        say(*ctx.get_help().split("\n"))


def main() -> None:
    """Run the command line and exit: 0 done, 1 numbers failed or rank deficient, 2 wrong input."""
    # a closed stream is None; what it is given goes nowhere
    sys.stdout, sys.stderr = (stream or os.fdopen(_nowhere(), "w") for stream in (sys.stdout, sys.stderr))
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    warnings.showwarning = _show_warning
    # for loggers without a handler: dask has its own, which we silence
    logging.lastResort = _Log(logging.WARNING)
    stdout = sys.stdout
    try:
        commands(standalone_mode=False)
    except click.ClickException as error:
        complain(error.format_message())
        sys.exit(USAGE)
    except OSError as error:
        _drop_output()
        complain(f"{error.filename or 'standard output'}: {error.strerror}")
        sys.exit(USAGE)
    except SystemExit:
        if sys.stdout is stdout:
            raise
        _drop_output()  # click has put it aside: its reader is gone
        sys.exit(_READER_GONE)


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    complain(f"warning: {message}")


class _Log(logging.Handler):
    """What a library writes to a log, such as matplotlib of its cache, is said as we say things."""

    def emit(self, record: logging.LogRecord) -> None:
        complain(f"warning: {record.getMessage()}")


def _drop_output() -> None:
    """What is left in the buffer of standard output goes nowhere."""
    with contextlib.suppress(OSError):  # where no file can be opened, it goes where it was meant to go
        os.dup2(_nowhere(), sys.stdout.fileno())


def _nowhere() -> int:
    return os.open(os.devnull, os.O_WRONLY)
