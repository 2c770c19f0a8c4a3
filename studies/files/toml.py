"""TOML files of others: bounded, UTF-8, and what is wrong in one sentence."""

from __future__ import annotations

import tomllib
from pathlib import Path

from .errors import TomlError
from .quote import short
from .reading import cause, read_whole

# scenarios, muscles and mappings have some hundred entries; larger files are something else
_LARGEST_FILE = 200_000


def read_toml(path: Path) -> dict[str, object]:
    """The content of a TOML file. TomlError says what is wrong, and where."""
    try:
        raw = read_whole(path, _LARGEST_FILE)
    except (OSError, ValueError) as error:
        raise TomlError(f"{path}: cannot be read: {cause(error)}") from error
    if raw.startswith(b"\xef\xbb\xbf"):
        raise TomlError(f"{path}: begins with a byte-order mark (BOM); save it as UTF-8 without one")
    try:
        return tomllib.loads(raw.decode("utf-8"))
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise TomlError(f"{path}: line {line} is not valid UTF-8") from error
    except tomllib.TOMLDecodeError as error:
        raise TomlError(f"{path}: not valid TOML: {short(str(error))}") from error
    except RecursionError as error:
        raise TomlError(f"{path}: nested too deeply to be read") from error
    except ValueError as error:
        raise TomlError(f"{path}: cannot be read: it holds a number of thousands of digits") from error
