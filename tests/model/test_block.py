"""The grammar: what a Block may be, and how wire, many, rename and with_numbers treat it."""

import casadi as ca
import numpy as np
import pytest

from hillobs.model.block import Block, BlockError, Parameter, Symbols, symbols
from hillobs.model.wiring import many, rename, wire, with_numbers


def integrator(name: str = "integrator") -> Block:
    x, u, p = symbols("x"), symbols("u"), symbols("k")
    return Block(
        name,
        x=x,
        u=u,
        p=p,
        parameters={"k": Parameter(2.0, "gain", "test")},
        dx=Symbols(x=p.k * u.u),
        y=Symbols(x=x.x, through=u.u),
    )


def evaluate(block: Block, group: str, **values: float) -> dict[str, float]:
    every = {**block.x, **block.u, **block.p}
    entries = getattr(block, group)
    function = ca.Function("f", list(every.values()), [entries.vector()])
    numbers = np.array(function(*(values.get(name.replace(".", "_"), 0.0) for name in every))).ravel()
    return dict(zip(entries, numbers.tolist(), strict=True))


def test_a_state_must_move_in_exactly_one_way() -> None:
    x = symbols("a b")
    with pytest.raises(BlockError, match=r"states are a, b, moved are a"):
        Block("b", x=x, dx=Symbols(a=x.a))
    with pytest.raises(BlockError, match="exactly one"):
        Block("b", x=x, dx=Symbols(a=x.a, b=x.b), next=Symbols(b=x.b))


def test_a_foreign_symbol_is_named() -> None:
    x, stranger = symbols("a"), ca.SX.sym("stranger")
    with pytest.raises(BlockError, match=r"b: dx\.a uses stranger"):
        Block("b", x=x, dx=Symbols(a=stranger))


@pytest.mark.parametrize("name", ["", "1st", "a b", "a-b", "x" * 41, "ä"])
def test_a_name_must_be_an_identifier(name: str) -> None:
    with pytest.raises(BlockError, match="no name for a block"):
        Block(name)


def test_a_block_keeps_its_expressions_whatever_becomes_of_those_given() -> None:
    x = symbols("x")
    rate = -x.x
    block = Block("decay", x=x, dx=Symbols(x=rate))
    rate[0] = 3
    assert str(block.dx.x) == "(-x)"


def test_components_are_scalars_and_states_are_symbols() -> None:
    with pytest.raises(BlockError, match="every component is a scalar"):
        Block("b", y=Symbols(a=ca.SX(2, 1)))
    x = symbols("a")
    with pytest.raises(BlockError, match="must be a symbol"):
        Block("b", x=Symbols(a=2 * x.a), dx=Symbols(a=x.a))


def test_wire_connects_by_name() -> None:
    loop = wire("loop", many(integrator(), ["a", "b"]), {"a.u": "b.x", "b.u": "drive"}, {"drive": "staged"})
    assert list(loop.x) == ["a.x", "b.x"]
    assert list(loop.u) == ["drive"]
    assert evaluate(loop, "dx", b_x=3.0, drive=5.0, a_k=2.0, b_k=7.0) == {"a.x": 6.0, "b.x": 35.0}
    assert [part.name for part in loop.parts] == ["a", "b"]


def test_wire_takes_numbers() -> None:
    loop = wire("loop", many(integrator(), ["a"]), {"a.u": 1.5})
    assert evaluate(loop, "dx", a_k=2.0) == {"a.x": 3.0}


@pytest.mark.parametrize(
    ("connections", "message"),
    [
        ({"a.u": "b.x"}, r"nothing is connected to b\.u"),
        ({"a.u": "b.x", "b.u": "a.y"}, r"unknown source 'a\.y'; valid: .*a\.x"),
        ({"a.u": "b.x", "b.v": "a.x", "b.u": 1.0}, r"unknown input 'b\.v'; valid: .*b\.u"),
        ({"a.u": "b.through", "b.u": "a.through"}, r"algebraic loop through the inputs a\.u → b\.u → a\.u"),
        ({"a.u": "a.through", "b.u": 1.0}, r"algebraic loop through the inputs a\.u → a\.u"),
    ],
)
def test_wire_refuses(connections: dict[str, str | float], message: str) -> None:
    with pytest.raises(BlockError, match=message):
        wire("loop", many(integrator(), ["a", "b"]), connections)


def test_loops_are_found_per_output_not_per_block() -> None:
    """Feedback through a block that has feed-through elsewhere is no algebraic loop."""
    loop = wire("loop", many(integrator(), ["a", "b"]), {"a.u": "b.through", "b.u": "a.x"})
    assert evaluate(loop, "dx", a_x=3.0, a_k=1.0, b_k=1.0) == {"a.x": 3.0, "b.x": 3.0}


def test_wire_refuses_one_block_twice_and_equal_names() -> None:
    block = integrator()
    with pytest.raises(BlockError, match="share the symbol"):
        wire("loop", [block, rename(block, "other", {})], {"integrator.u": 1.0, "other.u": 1.0})
    with pytest.raises(BlockError, match="two parts are called a"):
        wire("loop", [*many(block, ["a"]), *many(block, ["a"])], {"a.u": 1.0})


def test_the_order_of_parts_does_not_matter() -> None:
    connections: dict[str, str | float] = {"a.u": "b.x", "b.u": "a.x", "c.u": "b.through"}
    parts = many(integrator(), ["a", "b", "c"])
    values = {"a_x": 1.0, "b_x": 2.0, "c_x": 3.0, "a_k": 4.0, "b_k": 5.0, "c_k": 6.0}
    one = evaluate(wire("loop", parts, connections), "dx", **values)
    other = evaluate(wire("loop", parts[::-1], connections), "dx", **values)
    assert one == other


def test_rename_is_a_bijection_and_merges_equal_parameters() -> None:
    loop = wire("loop", many(integrator(), ["a", "b"]), {"a.u": "b.x", "b.u": 1.0})
    renamed = rename(loop, "loop", {"a.k": "k", "b.k": "k", "a.x": "first"}, ["first"])
    assert list(renamed.p) == ["k"]
    assert list(renamed.y) == ["first"]
    assert evaluate(renamed, "dx", b_x=3.0, k=2.0) == {"first": 6.0, "b.x": 2.0}
    back = rename(rename(loop, "loop", {"a.x": "first"}), "loop", {"first": "a.x"})
    assert list(back.x) == list(loop.x)
    with pytest.raises(BlockError, match="unknown name 'nothing'"):
        rename(loop, "loop", {"nothing": "x"})


def test_held_inputs_stay_held() -> None:
    loop = wire("loop", many(integrator(), ["a"]), {"a.u": "w"}, {"w": "held", "t": "t"})
    assert loop.held == {"w"}


def test_a_symbol_that_is_not_there_is_named() -> None:
    with pytest.raises(AttributeError, match="no symbol 'c'; there are a, b"):
        _ = symbols("a b").c


def test_numbers_take_the_place_of_parameters() -> None:
    block = integrator()
    written = with_numbers(block, {"k": 3.0})
    assert not written.p
    assert not written.parameters
    assert evaluate(written, "dx", u=2.0) == evaluate(block, "dx", u=2.0, k=3.0) == {"x": 6.0}
    # a factor of 0 leaves nothing to compute
    assert with_numbers(block, {"k": 0.0}).dx.x.is_zero()
    with pytest.raises(BlockError, match="unknown parameter 'gain'; valid: k"):
        with_numbers(block, {"gain": 1.0})
