"""Neither units nor the order of the sensors change the decision."""

import dataclasses
from itertools import permutations

import casadi as ca
import pytest

from hillobs.model.block import Block, Symbols
from hillobs.observers.observability import Verdict, judge, observability_matrix
from observed_systems import REGIONS, SENSORS, block, evaluate, kernel_of, same_space, sizes, verdict


def decision(v: Verdict) -> tuple[object, ...]:
    return v.rank, v.ranks, v.unobservable


def rescaled(b: Block, kind: str, name: str, c: float) -> Block:
    """The same system, one state or output counted in another unit: old = c · new."""
    if kind == "output":
        return dataclasses.replace(b, y=Symbols({**b.y, name: b.y[name] / c}))
    new = ca.SX.sym(name)

    def change(entries: Symbols) -> Symbols:
        if not entries:
            return entries
        return Symbols(zip(entries, ca.substitute(list(entries.values()), [b.x[name]], [c * new]), strict=True))

    changed = {group: change(getattr(b, group)) for group in ("y", "dx", "guards", "domain")}
    changed["dx"][name] = changed["dx"][name] / c
    return dataclasses.replace(b, x=Symbols({**b.x, name: new}), **changed)


QUANTITIES = [("state", n) for n in ("x1", "x2", "x3", "x4", "Delta", "1", "2")] + [("output", n) for n in SENSORS]


@pytest.mark.parametrize(("unknown", "order"), [("u", 6), ("a", 2)])
@pytest.mark.parametrize(("kind", "name"), QUANTITIES)
def test_units_do_not_matter(unknown: str, order: int, kind: str, name: str) -> None:
    name = f"{unknown}{name}" if name in "12" else name
    b = block(unknown)
    for c in (1e-6, 1e6):
        other = rescaled(b, kind, name, c)
        f = observability_matrix(other, SENSORS, order)
        size = sizes(b)
        if kind == "state":
            size[name] /= c
        for region in ("both taut", "1 slack"):
            at = dict(REGIONS[region])
            expected = verdict(unknown, at, order=order)
            if kind == "state":
                at[name] /= c
            in_other_units = judge(evaluate(other, f, at), list(other.x), size, 3)
            assert decision(in_other_units) == decision(expected)
            assert in_other_units.singular_values == pytest.approx(expected.singular_values, rel=1e-6, abs=1e-10)
            assert same_space(kernel_of(in_other_units), kernel_of(expected), 1e-5)


@pytest.mark.parametrize(("unknown", "order"), [("none", 3), ("u", 6), ("a", 2)])
def test_the_order_of_the_sensors_does_not_matter(unknown: str, order: int) -> None:
    for region in REGIONS.values():
        expected = verdict(unknown, region, order=order)
        for outputs in permutations(SENSORS):
            permuted = verdict(unknown, region, outputs, order)
            assert decision(permuted) == decision(expected)
            assert permuted.singular_values == pytest.approx(expected.singular_values, rel=1e-9, abs=1e-13)
