"""How much memory the system would still give: some libraries do not say that they got none, or wait for ever."""

from __future__ import annotations

import mmap

# a thread's stack, twice the 64 MB that glibc's malloc reserves for each, and some; address space, not memory
THREAD = 160_000_000


def has_room(size: int) -> bool:
    """Whether `size` bytes of address space would be granted."""
    try:
        mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS).close()
    except (OSError, MemoryError):
        return False
    return True
