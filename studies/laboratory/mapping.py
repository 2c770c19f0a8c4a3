"""Which column of a file is which signal, as typed or as a TOML file."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path

from ..files.errors import RecordingError, TomlError
from ..files.quote import shown
from ..files.toml import read_toml

_EXAMPLE = "such as position=block_x[mm]"


def read_mapping(texts: Iterable[str]) -> dict[str, str]:
    """name → column, from texts that are NAME=COLUMN, NAME=COLUMN[UNIT] or the name of a .toml file.

    A file has lines such as `position = "block_x"` or `position = { column = "block_x", unit = "mm" }`.
    RecordingError if one is neither, or a name is mapped twice.
    """
    mapping: dict[str, str] = {}
    for text in texts:
        name, equals, column = text.partition("=")
        if equals:
            entries = [(name.strip(), column.strip())]
        elif text.endswith(".toml"):
            entries = list(_file(Path(text)).items())
        else:
            raise RecordingError(f"{shown(text)} is neither NAME=COLUMN, {_EXAMPLE}, nor a .toml file")
        for name, column in entries:
            if not name or not column:
                raise RecordingError(f"{shown(text)} is not NAME=COLUMN, {_EXAMPLE}")
            if mapping.setdefault(name, column) != column:
                raise RecordingError(f"{shown(name)} is mapped twice, to {shown(mapping[name])} and {shown(column)}")
    return mapping


def _file(path: Path) -> dict[str, str]:
    try:
        content = read_toml(path)
    except TomlError as error:
        raise RecordingError(str(error)) from error
    return mapping_of(content, f"{path}: ")


def mapping_of(content: Mapping[str, object], prefix: str) -> dict[str, str]:
    """The same of a table that was read; RecordingError names an entry after `prefix`."""
    return {name: _target(f"{prefix}{name}", value) for name, value in content.items()}


def _target(where: str, value: object) -> str:
    match value:
        case str():
            return value
        case {"column": str(column), **rest} if not rest:
            return column
        case {"column": str(column), "unit": str(unit), **rest} if not rest:
            return f"{column}[{unit}]"
    raise RecordingError(f'{where} must be "COLUMN" or {{ column = "COLUMN", unit = "UNIT" }}, not {shown(value)}')
