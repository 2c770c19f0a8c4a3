"""What the system tells of the processor."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path

# what each level of the x86-64 psABI adds to the one before, in the words of /proc/cpuinfo
_LEVELS: Mapping[str, tuple[str, ...]] = {
    "x86-64-v2": ("cx16", "lahf_lm", "popcnt", "pni", "sse4_1", "sse4_2", "ssse3"),
    "x86-64-v3": ("abm", "avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe", "xsave"),
    "x86-64-v4": ("avx512bw", "avx512cd", "avx512dq", "avx512f", "avx512vl"),
}


def cpuinfo(*names: str) -> str:
    """Return what /proc says of the first processor under one of the names, or an empty text where it does not tell.

    The names differ from one kind of processor to the other: `flags` or `Features`.
    """
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text("ascii", "replace").splitlines():
            name, _, words = line.partition(":")
            if name.strip() in names:
                return words.strip()
    return ""


def features() -> list[str]:
    """Return the names of what the processor can do, sorted; none where the system does not tell."""
    return sorted(set(cpuinfo("flags", "Features").split()))


def lacking(level: str) -> list[str]:
    """Return what the processor lacks for a level of x86-64; nothing for other names, or where the system is silent."""
    if level not in _LEVELS or not (known := features()):
        return []
    return [word for name, words in _LEVELS.items() if name <= level for word in words if word not in known]


def divides_slowly() -> bool:
    """Whether eight quotients take Newton's method less time than the divider: 16 cycles on Intel, 4 to 10 on AMD."""
    return cpuinfo("vendor_id") == "GenuineIntel"
