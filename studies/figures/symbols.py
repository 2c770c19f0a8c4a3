"""What axes call a swept parameter: the paper's symbol, with its owner where others have one of the same name."""

from __future__ import annotations

import functools
import re
from collections import Counter

from ...observers import OBSERVERS, PAPER, estimator, label

_GREEK = {
    "alpha": r"\alpha", "beta": r"\beta", "gamma": r"\gamma", "delta": r"\delta", "Delta": r"\Delta",
    "eps": r"\varepsilon", "eta": r"\eta", "lambda": r"\lambda", "sigma": r"\sigma", "tau": r"\tau",
}  # fmt: skip
# the code needs other names than the paper where one letter means two things
_RENAMED = {"a_dual": "a", "A_hill": "A"}
# of one letter: x₁, h₁₁, ε_a0, k_max
_NAME = re.compile(rf"({'|'.join(_GREEK)}|[A-Za-z])(\d*)(?:_([A-Za-z0-9]+))?")
_HAT = "_hat"
# whose letters need no owner's name
_NAMELESS = ("plant", "muscle")


def symbol(path: str) -> str:
    r"""`high_gain.eps_h` as $\varepsilon_{h}$; `muscle1.k` as "muscle 1 $k$"; `noise.force` as its words."""
    owner, _, name = path.rpartition(".")
    letter = _letter(name)
    words = [_owner(part) for part in owner.split(".") if part and not (letter[0] == "$" and _plain(part, path))]
    return " ".join([*words, letter])


def _plain(owner: str, path: str) -> bool:
    """Whether a letter alone says whose it is."""
    if owner in OBSERVERS:
        return owner in PAPER and _names()[path.partition(".")[2]] == 1
    return owner in _NAMELESS


def _owner(name: str) -> str:
    """An observer's label, or words: `muscle1` as "muscle 1"."""
    return re.sub(r"(?<=[a-z])(?=\d)", " ", label(name))


def _letter(name: str) -> str:
    """A letter with what stands below it; a word stays one."""
    match = _NAME.fullmatch(_RENAMED.get(name, name).removesuffix(_HAT))
    if match is None:
        return name.replace("_", " ")
    base, digits, below = match.groups()
    letter = _GREEK.get(base, base)
    letter = rf"\hat{{{letter}}}" if name.endswith(_HAT) else letter
    # a word below a letter stands upright
    low = digits + (rf"\mathrm{{{below}}}" if below and len(below) > 2 else below or "")
    return f"${letter}_{{{low}}}$" if low else f"${letter}$"


@functools.cache
def _names() -> Counter[str]:
    """How many of the paper's observers have a parameter of each name."""
    return Counter(name for owner in PAPER for name in estimator(OBSERVERS[owner].block()).parameters)
