"""TOML files of others: bounded, UTF-8, and what is wrong in one sentence; and values as TOML writes them."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from .errors import TomlError
from .quote import short
from .reading import cause, read_whole

# scenarios, muscles and mappings have some hundred entries; larger files are something else
_LARGEST_FILE = 200_000
_BARE_KEY = re.compile("[A-Za-z0-9_-]+")
# from here on a whole number is written with an exponent
_POINTLESS = 1e15
# columns, and numbers on a line of a list that takes more
_WIDTH, _A_LINE = 90, 4


def read_toml(path: Path, largest: int = _LARGEST_FILE) -> dict[str, object]:
    """The content of a TOML file of at most so many bytes. TomlError says what is wrong, and where."""
    try:
        raw = read_whole(path, largest)
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


def toml_value(value: object) -> str:
    """A number, a text or a truth value as TOML writes it; a whole number without a point; a list of such."""
    match value:
        case str():
            return _text(value)
        case bool():
            return str(value).lower()
        case float() if value.is_integer() and abs(value) < _POINTLESS:
            return repr(int(value))
        case list():
            words = list(map(toml_value, value))
            if len(plain := f"[{', '.join(words)}]") <= _WIDTH:
                return plain
            lines = (", ".join(words[at : at + _A_LINE]) for at in range(0, len(words), _A_LINE))
            return "[\n" + "".join(f"    {line},\n" for line in lines) + "]"
        case Mapping():
            return f"{{ {', '.join(f'{_key(key)} = {toml_value(inner)}' for key, inner in value.items())} }}"
    return repr(value)


def toml_numbers(comments: Iterable[str], content: Mapping[str, object]) -> str:
    """A TOML file of dotted paths with a value each, below some comments."""
    lines = [*(f"# {comment}" for comment in comments), *(f"{path} = {toml_value(of)}" for path, of in content.items())]
    return "\n".join(lines) + "\n"


def toml_document(content: Mapping[str, object]) -> str:
    """A whole TOML file: what is no table first, then tables."""
    return "\n".join(_lines(content, "")).strip("\n") + "\n"


def _lines(content: Mapping[str, object], place: str) -> Iterator[str]:
    tables = {
        key: value for key, value in content.items() if isinstance(value, Mapping) and not (place and _few(value))
    }
    plain = {key: value for key, value in content.items() if key not in tables}
    # a table of tables needs no line of its own
    if place and (plain or not tables):
        yield f"\n[{place.removesuffix('.')}]"
    for key, value in plain.items():
        yield f"{_key(key)} = {toml_value(value)}"
    for key, table in tables.items():
        yield from _lines(table, f"{place}{_key(key)}.")


def _few(table: Mapping[str, object]) -> bool:
    """Whether a table is a number or two, which stay on a line."""
    return len(table) <= 2 and all(isinstance(value, int | float) for value in table.values())


def _key(key: str) -> str:
    return key if _BARE_KEY.fullmatch(key) else _text(key)


def _text(text: str) -> str:
    """A text as TOML writes it, every character that cannot be printed as an escape."""
    quoted = json.dumps(text, ensure_ascii=False)
    return "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in quoted)
