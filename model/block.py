"""One kind of thing: the Block. Plant, reference, sensors, controller, observers and score are all Blocks."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Container, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import casadi as ca

from .errors import Error

# the integration step, the one symbol that Blocks share
STEP = ca.SX.sym("h")


class BlockError(Error, ValueError):
    """A Block or a wiring that cannot be; the sentence names the part and what is valid."""


class Symbols(dict[str, ca.SX]):
    """Ordered names → expressions, also as attributes: `p.eps_h` is `p["eps_h"]`."""

    def __getattr__(self, name: str) -> ca.SX:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(f"no symbol {name!r}; there are {', '.join(self)}") from None

    def part(self, name: str) -> Symbols:
        """The symbols named `name.…`, without that prefix."""
        return Symbols(
            {key.removeprefix(f"{name}."): value for key, value in self.items() if key.startswith(f"{name}.")}
        )

    def only(self, names: Iterable[str]) -> Symbols:
        """The entries named, in this order."""
        return Symbols({name: self[name] for name in names})

    def vector(self) -> ca.SX:
        """All entries as one column, in order (0 × 1 if there are none)."""
        return ca.vertcat(*self.values()) if self else ca.SX(0, 1)


def symbols(names: str | Iterable[str]) -> Symbols:
    """Fresh scalar symbols for the names given (one string is split at blanks).

    >>> x = hillobs.symbols("position velocity")
    >>> x.position, list(x)
    (SX(position), ['position', 'velocity'])
    """
    return Symbols({name: ca.SX.sym(name) for name in (names.split() if isinstance(names, str) else names)})


@dataclass(frozen=True)
class Parameter:
    """A number of the model: its default, a sentence of what it means, its source and unit, and what it may be.

    It is finite, > above, ≥ least, < below, ≤ most, and a whole number if `whole`.
    `shared` is the path of the one value that all Blocks take which use it, unless one is given its own.
    """

    default: float
    sentence: str
    source: str
    unit: str = "1"
    above: float = -math.inf  # value > above
    least: float = -math.inf  # value ≥ least
    below: float = math.inf  # value < below
    most: float = math.inf  # value ≤ most
    whole: bool = False  # no fraction
    shared: str = ""

    def objection(self, value: float) -> str:
        """What `value` must be and is not, or an empty string."""
        bounds = (
            (math.isfinite(value), "a finite number"),
            (value > self.above, f"above {self.above:g}"),
            (value >= self.least, f"at least {self.least:g}"),
            (value < self.below, f"below {self.below:g}"),
            (value <= self.most, f"at most {self.most:g}"),
            (not self.whole or float(value).is_integer(), "a whole number"),
        )
        return next((words for holds, words in bounds if not holds), "")


# Parameters by name, in order
Parameters = Mapping[str, Parameter]

# the code generator takes no double and no last underscore
_NAME = re.compile(r"(?=.{1,40}$)[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*")


@dataclass(frozen=True, eq=False)  # compared by identity: SX has no usable ==
class Block:
    """ẋ = f(t, x, u, p), y = h(t, x, u, p), every component a named scalar.

    Each state moves in exactly one way: `dx` (continuous), `next` (at each sample k·T_s) or `per_step`
    (at each grid point of the integrator, after `next`); it starts at `x0`, an expression in p and the
    inputs at t = 0, or at 0. The input `t` is time, the inputs in `held` are constant over a step, all
    others are evaluated at each stage. `guards` are 1 while a limit is active, else 0; an expression in
    `domain` must stay positive. The magnitude of a state or output must stay within its entry in `limits`,
    an expression in p and STEP; where there is none, its square must be a number. `parameters` tell of each
    symbol in p. `parts` are the Blocks that it was wired from.
    BlockError if the name is none, a state does not move in one way, or an expression has a symbol of nobody.
    """

    name: str
    x: Symbols = field(default_factory=Symbols)
    u: Symbols = field(default_factory=Symbols)
    p: Symbols = field(default_factory=Symbols)
    y: Symbols = field(default_factory=Symbols)
    dx: Symbols = field(default_factory=Symbols)
    next: Symbols = field(default_factory=Symbols)
    per_step: Symbols = field(default_factory=Symbols)
    x0: Symbols = field(default_factory=Symbols)
    parameters: Parameters = field(default_factory=dict)
    held: frozenset[str] = frozenset()
    guards: Symbols = field(default_factory=Symbols)
    domain: Symbols = field(default_factory=Symbols)
    limits: Symbols = field(default_factory=Symbols)
    parts: tuple[Block, ...] = ()

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            raise BlockError(f"{self.name!r} is no name for a block: letters, digits, single _ between, at most 40")
        for group in ("x", "u", "p", "y", "dx", "next", "per_step", "x0", "guards", "domain", "limits"):
            object.__setattr__(self, group, _scalars(self.name, group, getattr(self, group)))
        moves = [*self.dx, *self.next, *self.per_step]
        if sorted(moves) != sorted(self.x):
            raise BlockError(
                f"{self.name}: each state must move in exactly one of dx, next, per_step; "
                f"states are {', '.join(self.x) or 'none'}, moved are {', '.join(moves) or 'none'}"
            )
        if list(self.parameters) != list(self.p):
            raise BlockError(
                f"{self.name}: parameters described are {list(self.parameters)}, the symbols in p {list(self.p)}"
            )
        for name, parameter in self.parameters.items():
            if objection := parameter.objection(parameter.default):
                raise BlockError(f"{self.name}: the default of {name} must be {objection}, not {parameter.default:g}")
        signals = {**self.x, **self.y}
        for what, names, valid in (
            ("x0", self.x0, self.x),
            ("held", self.held, self.u),
            ("limits", self.limits, signals),
        ):
            if unknown := [name for name in names if name not in valid]:
                raise BlockError(f"{self.name}: {what} names {', '.join(unknown)}; valid are {', '.join(valid)}")
        self._check_free_symbols()

    def _check_free_symbols(self) -> None:
        inputs = [*self.u.values(), *self.p.values()]
        for groups, known in (
            (EXPRESSIONS, [*self.x.values(), *inputs]),
            (("x0",), inputs),
            (("limits",), [*self.p.values(), STEP]),
        ):
            allowed = {symbol.element_hash() for symbol in known}
            entries = [entry for group in groups for entry in getattr(self, group).values()]
            # all at once first: to ask each costs more than all else that making a Block does
            if not entries or not _strangers(ca.vertcat(*entries), allowed):
                continue
            for group in groups:
                for name, expression in getattr(self, group).items():
                    if free := _strangers(expression, allowed):
                        raise BlockError(
                            f"{self.name}: {group}.{name} uses {', '.join(free)}, not among its own symbols"
                        )

    @property
    def sampled(self) -> bool:
        """Whether it moves at samples only, and stands still between them."""
        return bool(self.next) and not self.dx and not self.per_step

    def rewritten(self, change: Callable[[Symbols], Symbols], **fields: object) -> Block:
        """A copy with `change` applied to each group of expressions, and `fields` replaced."""
        changed: dict[str, Any] = {group: change(getattr(self, group)) for group in ("x0", "limits", *EXPRESSIONS)}
        return replace(self, **{**changed, **fields})


EXPRESSIONS = ("y", "dx", "next", "per_step", "guards", "domain")


def _strangers(expression: ca.SX, allowed: Container[int]) -> list[str]:
    """The symbols of an expression whose hashes are not among those `allowed`."""
    return [symbol.name() for symbol in ca.symvar(expression) if symbol.element_hash() not in allowed]


def _scalars(block: str, group: str, given: Mapping[str, ca.SX | float]) -> Symbols:
    result = Symbols()
    for name, value in given.items():
        # + makes a copy, at a tenth of the constructor's cost: an SX can be changed in place
        entry = +value if isinstance(value, ca.SX) else ca.SX(value)
        if not entry.is_scalar():
            raise BlockError(f"{block}: {group}.{name} has the shape {entry.shape}; every component is a scalar")
        if group in ("x", "u", "p") and not entry.is_symbolic():
            raise BlockError(f"{block}: {group}.{name} must be a symbol, it is an expression")
        result[name] = entry if entry.is_dense() else ca.densify(entry)
    return result
