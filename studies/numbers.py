"""Numbers in the texts of others: one strict pattern, and the cells of a table by it."""

from __future__ import annotations

import re

from .quote import shown
from .table import ScenarioError

# no blanks, no underscores, no digits of other scripts, no inf, no hexadecimals
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
# what C, NumPy and pandas write where there is no number
GAP = re.compile(r"([+-]?nan)?", re.IGNORECASE | re.ASCII)
# of a whole number on a command line
_MOST_DIGITS = 12


def whole_number(option: str, text: str, least: int) -> int:
    """The whole number that an option is given as typed. ScenarioError if it is none, or below `least`."""
    if not text.isascii() or not text.isdigit() or len(text) > _MOST_DIGITS or int(text) < least:
        raise ScenarioError(f"{option} must be a whole number of at least {least}, not {shown(text)}")
    return int(text)
