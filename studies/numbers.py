"""Numbers in the texts of others: one strict pattern, and the cells of a table by it."""

from __future__ import annotations

import re

# no blanks, no underscores, no digits of other scripts, no inf, no hexadecimals
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
# what C, NumPy and pandas write where there is no number
GAP = re.compile(r"([+-]?nan)?", re.IGNORECASE | re.ASCII)
