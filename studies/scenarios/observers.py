"""The observers that are asked for, by scenarios and recordings alike: registered ones, and a user's own Blocks."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence

from ...model.block import Block
from ...observers import OBSERVERS, PAPER, Observer
from ..files.errors import ScenarioError
from ..files.quote import shown

# names of registered observers and Blocks with an observer's ports; the paper's three if there are none
Observers = Sequence[str | Block] | str | Block | None

_OWN = "one of your own is given as its Block, on a command line as FILE.py:NAME"


def observers_named(given: Observers) -> dict[str, Observer]:
    """The observers that are given, by name. ScenarioError for one that is not registered, and for a name of two."""
    chosen: dict[str, Observer] = {}
    for observer in [given] if isinstance(given, str | Block) else given or PAPER:
        if isinstance(observer, Block):
            mine = own_observer(observer)
            if chosen.setdefault(observer.name, mine) is not mine:
                raise ScenarioError(f"two observers are called {observer.name!r}; give one another name")
        elif isinstance(observer, str) and observer in OBSERVERS:
            chosen[observer] = OBSERVERS[observer]
        else:
            raise ScenarioError(f"unknown observer {shown(observer)}; there are {', '.join(OBSERVERS)}; {_OWN}")
    return chosen


# the same Observer for the same Block, since what is compiled is remembered by it
@functools.lru_cache(maxsize=64)
def own_observer(block: Block) -> Observer:
    """A user's Block, of which no theorem, gain rule or rates are known. ScenarioError if its name is registered."""
    if block.name in OBSERVERS:
        raise taken(block.name)
    return Observer(block.name, lambda: block)


def own_among(chosen: Mapping[str, Observer]) -> tuple[Observer, ...]:
    """Those that are a user's own."""
    return tuple(observer for name, observer in chosen.items() if name not in OBSERVERS)


def taken(name: str) -> ScenarioError:
    """What is said of an observer whose name something else has."""
    return ScenarioError(f"the name {name!r} is taken; give your observer another one")
