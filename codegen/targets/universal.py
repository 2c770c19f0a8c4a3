"""Libraries of macOS for several processors in one file, as `lipo` makes them."""

from __future__ import annotations

import struct
from collections.abc import Sequence

# all numbers of the table are big-endian: its mark and how many libraries; then of each its processor and kind, where
# it begins, its size, and the power of two that its beginning is a multiple of
_MARK = 0xCAFEBABE
_HEAD, _ENTRY = struct.Struct(">II"), struct.Struct(">IIIII")
# pages have at most 2¹⁴ bytes
_ALIGNMENT = 14
# where a library tells its processor and kind, little-endian
_PROCESSOR = struct.Struct("<4xII")


def universal(libraries: Sequence[bytes]) -> bytes:
    """One library of those for a processor each."""
    begin = _HEAD.size + _ENTRY.size * len(libraries)
    table, content = _HEAD.pack(_MARK, len(libraries)), b""
    for library in libraries:
        gap = -(begin + len(content)) % (1 << _ALIGNMENT)
        content += bytes(gap)
        place = begin + len(content)
        table += _ENTRY.pack(*_PROCESSOR.unpack_from(library), place, len(library), _ALIGNMENT)
        content += library
    return table + content
