"""The observers that are asked for, by scenarios and recordings alike: registered ones, and a user's own Blocks."""

from __future__ import annotations

import functools
from collections.abc import Container, Iterable, Mapping, Sequence

from ...model.block import Block
from ...model.curves import NGUYEN2019
from ...model.plant import DRIVES
from ...observers import OBSERVERS, PAPER, Observer
from ..files.errors import ScenarioError
from ..files.quote import shown
from .loops import all_paths, paper_loop

# names of registered observers and Blocks with an observer's ports; the paper's three if there are none
Observers = Sequence[str | Block] | str | Block | None

_OWN = "one of your own is given as its Block, on a command line as FILE.py:NAME"


def observers_named(given: Observers) -> dict[str, Observer]:
    """The observers that are given, by name. ScenarioError for one that is not registered, and for a name of two."""
    chosen: dict[str, Observer] = {}
    named = PAPER if given is None else [given] if isinstance(given, str | Block) else given
    if not isinstance(named, Iterable) or not (named := list(named)):
        raise ScenarioError(f"observers must be one or more, not {shown(given)}; left out they are {', '.join(PAPER)}")
    for observer in named:
        if isinstance(observer, Block):
            mine = own_observer(observer)
            if chosen.setdefault(observer.name, mine) is not mine:
                raise ScenarioError(f"two observers are called {observer.name!r}; give one another name")
        elif isinstance(observer, str) and observer in OBSERVERS:
            chosen[observer] = OBSERVERS[observer]
        else:
            raise ScenarioError(f"unknown observer {shown(observer)}; there are {', '.join(OBSERVERS)}; {_OWN}")
    if own := own_among(chosen):
        refuse_taken(own, {*OBSERVERS, *_names_of_scenarios()})
    return chosen


# the same Observer for the same Block, since what is compiled is remembered by it
@functools.lru_cache(maxsize=64)
def own_observer(block: Block) -> Observer:
    """A user's Block, of which no theorem, gain rule or rates are known."""
    return Observer(block.name, whole=lambda: block)


def own_among(chosen: Mapping[str, Observer]) -> dict[str, Observer]:
    """Those that are a user's own."""
    return {name: observer for name, observer in chosen.items() if OBSERVERS.get(name) is not observer}


def compiled_with(chosen: Mapping[str, Observer]) -> tuple[Observer, ...]:
    """Those of a library that has the chosen ones: all that are registered, so that it serves whatever is chosen next.

    A library for a user's own observer is compiled anyway: there the others need not be in it.
    """
    own = own_among(chosen)
    return tuple(observer for name, observer in OBSERVERS.items() if name in chosen or not own) + tuple(own.values())


def refuse_taken(own: Iterable[str], taken: Container[str]) -> None:
    """ScenarioError if a user's own observer has a name that something else has."""
    for name in own:
        if name in taken:
            raise ScenarioError(f"the name {name!r} is taken; give your observer another one")


@functools.cache
def _names_of_scenarios() -> frozenset[str]:
    """What the Blocks of the closed loop are called, and what its paths begin with."""
    paths = all_paths()
    blocks = [block.name for block in paper_loop(next(iter(DRIVES)), NGUYEN2019).exported]
    return frozenset([*blocks, *(path.partition(".")[0] for path in (*paths.parameters, *paths.groups()))])
