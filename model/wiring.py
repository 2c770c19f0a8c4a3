"""wire() joins Blocks by name into a Block; many(), rename() and with_numbers() prepare the parts."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping, Sequence

import casadi as ca

from .block import EXPRESSIONS, Block, BlockError, Parameter, Symbols, symbols

Substitution = tuple[list[ca.SX], list[ca.SX]]


def wire(
    name: str,
    parts: Sequence[Block],
    connections: Mapping[str, str | float],
    external: Mapping[str, str] | None = None,
) -> Block:
    """The composite of `parts`, its signals named `part.signal`.

    connections: `"part.input"` → `"part.output"`, a number, or the name of an external input.
    external: name → "t", "held" or "staged", the inputs of the composite itself.
    Refuses open inputs, unknown names, shared symbols and algebraic loops (BlockError).
    """
    external = external or {}
    _refuse_shared_symbols(parts)
    inputs = {f"{part.name}.{port}": symbol for part in parts for port, symbol in part.u.items()}
    outputs = {f"{part.name}.{port}": expression for part in parts for port, expression in part.y.items()}
    _check_names("input", connections, inputs)
    if missing := [port for port in inputs if port not in connections]:
        raise BlockError(f"{name}: nothing is connected to {', '.join(missing)}")
    own = symbols(external)
    sources = [source for source in connections.values() if isinstance(source, str)]
    _check_names("source", sources, {**outputs, **own})

    resolved = _resolve(name, inputs, outputs, connections, own)
    by = (list(inputs.values()), [resolved[port] for port in inputs])
    held = frozenset(port for port, kind in external.items() if kind == "held")

    def gathered(group: str) -> Symbols:
        return Symbols({f"{part.name}.{key}": value for part in parts for key, value in getattr(part, group).items()})

    x = gathered("x")
    joined = {group: _substitute(gathered(group), by) for group in ("x0", *EXPRESSIONS)}
    return Block(
        name,
        x=x,
        u=own,
        p=gathered("p"),
        **{**joined, "x0": _starts(name, x, joined["x0"])},
        parameters={f"{part.name}.{key}": value for part in parts for key, value in part.parameters.items()},
        held=held,
        limits=gathered("limits"),
        parts=tuple(parts),
    )


def _starts(name: str, x: Symbols, x0: Symbols) -> Symbols:
    """The values at the start, where one may follow from the start of other states."""
    by = (list(x.values()), [x0.get(key, ca.SX(0)) for key in x])
    turns = len(x)
    while ca.depends_on(x0.vector(), x.vector()):
        if not turns:
            raise BlockError(f"{name}: states whose starts depend on each other")
        x0, turns = _substitute(x0, by), turns - 1
    return x0


def many(block: Block, names: Iterable[str]) -> list[Block]:
    """One copy of `block` per name, with symbols of its own."""
    return [_fresh(block, name) for name in names]


def rename(block: Block, name: str, names: Mapping[str, str], outputs: Iterable[str] | None = None) -> Block:
    """`block` as `name`, its states, outputs and parameters renamed by `names` (old → new).

    Parameters that get the same new name become one, and guards one that is 1 where any of them is. If `outputs` (new
    names) is given, only these remain, in order.
    """
    known = [*block.x, *block.y, *block.p, *block.guards, *block.domain]
    _check_names("name", names, dict.fromkeys(known))

    def new(key: str) -> str:
        return names.get(key, key)

    p, parameters = Symbols(), dict[str, Parameter]()
    merged: Substitution = ([], [])
    for key, symbol in block.p.items():
        if (kept := p.setdefault(new(key), symbol)) is not symbol:
            merged[0].append(symbol)
            merged[1].append(kept)
        parameters.setdefault(new(key), block.parameters[key])

    def renamed(entries: Symbols) -> Symbols:
        return _substitute(Symbols({new(key): value for key, value in entries.items()}), merged)

    y = renamed(block.y)
    if outputs is not None:
        outputs = list(outputs)
        _check_names("output", outputs, y)
        y = Symbols({key: y[key] for key in outputs})
    x, limits = renamed(block.x), renamed(block.limits)
    limits = limits.only(key for key in limits if key in x or key in y)
    guards = Symbols()
    for key, guard in block.guards.items():
        guards[new(key)] = ca.fmax(guards[new(key)], guard) if new(key) in guards else guard
    guards = _substitute(guards, merged)
    return block.rewritten(renamed, name=name, x=x, p=p, parameters=parameters, y=y, guards=guards, limits=limits)


def with_numbers(block: Block, numbers: Mapping[str, float]) -> Block:
    """`block` with numbers in the place of the parameters of these names: what they make 0 or 1 is gone."""
    _check_names("parameter", numbers, block.p)
    by = ([block.p[name] for name in numbers], [ca.SX(value) for value in numbers.values()])
    p = block.p.only(name for name in block.p if name not in numbers)
    parameters = {name: block.parameters[name] for name in p}
    return block.rewritten(lambda entries: _substitute(entries, by), p=p, parameters=parameters)


def _fresh(block: Block, name: str) -> Block:
    x, u, p = symbols(block.x), symbols(block.u), symbols(block.p)
    old = [*block.x.values(), *block.u.values(), *block.p.values()]
    new = [*x.values(), *u.values(), *p.values()]
    return block.rewritten(lambda entries: _substitute(entries, (old, new)), name=name, x=x, u=u, p=p)


def _substitute(entries: Symbols, by: Substitution) -> Symbols:
    if not entries or not by[0]:
        return entries
    return Symbols(zip(entries, ca.substitute(list(entries.values()), *by), strict=True))


def _resolve(
    name: str,
    inputs: Mapping[str, ca.SX],
    outputs: Mapping[str, ca.SX],
    connections: Mapping[str, str | float],
    own: Symbols,
) -> dict[str, ca.SX]:
    """Each input as an expression in states, parameters and external inputs; loops are found per output."""
    port_of = {symbol.element_hash(): port for port, symbol in inputs.items()}
    done: dict[str, ca.SX] = {}

    def follow(port: str, path: tuple[str, ...]) -> ca.SX:
        if port in path:
            loop = " → ".join([*path[path.index(port) :], port])
            raise BlockError(f"{name}: algebraic loop through the inputs {loop}")
        if port not in done:
            source = connections[port]
            if not isinstance(source, str):
                done[port] = ca.SX(source)
            elif source in own:
                done[port] = own[source]
            else:
                needed = [s for s in ca.symvar(outputs[source]) if s.element_hash() in port_of]
                values = [follow(port_of[s.element_hash()], (*path, port)) for s in needed]
                done[port] = ca.substitute([outputs[source]], needed, values)[0] if needed else outputs[source]
        return done[port]

    return {port: follow(port, ()) for port in inputs}


def _refuse_shared_symbols(parts: Sequence[Block]) -> None:
    owner: dict[int, str] = {}
    names: set[str] = set()
    for part in parts:
        if part.name in names:
            raise BlockError(f"two parts are called {part.name}")
        names.add(part.name)
        for symbol in (*part.x.values(), *part.u.values(), *part.p.values()):
            other = owner.setdefault(symbol.element_hash(), part.name)
            if other != part.name:
                raise BlockError(f"{other} and {part.name} share the symbol {symbol.name()}; many() makes copies")


def _check_names(what: str, used: Iterable[str], valid: Mapping[str, object]) -> None:
    for name in used:
        if name not in valid:
            near = difflib.get_close_matches(name, valid, n=3) or list(valid)
            raise BlockError(f"unknown {what} {name!r}; valid: {', '.join(near)}")
