"""What is no readable file is one sentence for every input of every command: no traceback, no hang, nothing changed."""

import os
import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from places import contents
from written_files import WRITERS, inputs

# name → the command, and which word of it, or what a file must hold, leads to the input
COMMANDS: dict[str, list[str]] = {
    "simulate": ["simulate", "INPUT.toml"],
    "sweep": ["sweep", "INPUT.toml"],
    "observability": ["observability", "INPUT.toml"],
    "show": ["show", "INPUT.toml"],
    "figures": ["figures", "INPUT.nc"],
    "earlier result": ["sweep", "paper-clean", "--set", "duration=0.1", "--out", "INPUT.nc"],
    "recording": ["estimate", "INPUT.csv", "--muscles", "pair.toml"],
    "gzipped recording": ["estimate", "INPUT.csv.gz", "--muscles", "pair.toml"],
    "muscles": ["estimate", "short.csv", "--muscles", "INPUT.toml"],
    "mapping": ["estimate", "short.csv", "--muscles", "pair.toml", "--map", "INPUT.toml"],
    "model": ["import", "INPUT.osim", "--out", "arm.toml"],
    "mechanism": ["estimate", "short.csv", "--mechanism", "INPUT.toml"],
    "mechanism of a question": ["observability", "--mechanism", "INPUT.toml"],
    "curves": ["estimate", "short.csv", "--muscles", "curves.toml"],
}


def _socket(path: Path) -> None:
    # a socket's path may not be long
    folder = os.open(path.parent, os.O_RDONLY)
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(f"/proc/self/fd/{folder}/{path.name}")
    os.close(folder)


KINDS: dict[str, Callable[[Path], object]] = {
    "a loop of links": lambda path: path.symlink_to(path.name),
    "a longer loop": lambda path: (path.symlink_to("other"), path.with_name("other").symlink_to(path.name)),
    "a link to nothing": lambda path: path.symlink_to("nothing"),
    "below a loop": lambda path: (path.with_name("loop").symlink_to("loop"), path.symlink_to("loop/file")),
    "a pipe": os.mkfifo,
    "a device": lambda path: path.symlink_to("/dev/zero"),
    "a terminal": lambda path: path.symlink_to("/dev/ptmx"),
    "a folder": Path.mkdir,
    "a socket": _socket,
}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("of", COMMANDS)
def test_an_input_that_is_no_file_is_a_sentence(
    of: str, kind: str, command: Callable[..., tuple[int, str, str]], tmp_path: Path
) -> None:
    inputs(tmp_path)
    suffix = next((word.partition(".")[2] for word in COMMANDS[of] if word.startswith("INPUT.")), "csv")
    (tmp_path / "curves.toml").write_text('[muscle]\ncurves = "INPUT.csv"\n')
    KINDS[kind](tmp_path / f"INPUT.{suffix}")
    before = contents(tmp_path)
    code, out, err = command(*COMMANDS[of])
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("hillobs: ")
    assert "INPUT" in err
    # the folder of results may have been made
    assert {name: content for name, content in contents(tmp_path).items() if name not in ("estimates",)} == before


def test_every_command_that_reads_is_here() -> None:
    assert {words[0] for words in WRITERS.values()} - {"curves"} <= {words[0] for words in COMMANDS.values()}
