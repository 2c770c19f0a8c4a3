"""Every number that a Python call takes is a number, of a size that memory holds, or there is a sentence."""

import dataclasses
import math
import tracemalloc
from collections.abc import Callable
from decimal import Decimal

import numpy as np
import pytest

import hillobs
from hillobs import Error, Muscle, MusclePair, Range, Recording
from hillobs.studies.files.numbers import numbers, samples
from places import RECORDINGS

MANY = np.broadcast_to(0.0, 10**12)

BAD = {
    "a text": "0.1",
    "a truth value": True,
    "a truth value of NumPy": np.True_,
    "a date": np.datetime64("2000-01-01"),
    "a time": np.timedelta64(1, "s"),
    "a complex number": 1j,
    "nothing": None,
    "no number": math.nan,
    "infinity": math.inf,
    "a number of many digits": 10**400,
    "a decimal": Decimal("0.1"),
    "an object": object(),
    "an array of objects": np.array([0.1, "x"], dtype=object),
    "an array of dates": np.array(["2000-01-01"], dtype="M8[D]"),
    "an array in two dimensions": np.ones((2, 2)),
    "a table": {"a": 1},
}
PAIR = hillobs.read_muscles(RECORDINGS / "dgf_smooth.toml")
RUN = hillobs.read_recording(RECORDINGS / "dgf_smooth_noisy.csv.gz")
PLACES: dict[str, Callable[[object], object]] = {
    "simulate changes": lambda bad: hillobs.simulate(changes={"plant.m": bad}),
    "simulate seed": lambda bad: hillobs.simulate(changes={"seed": bad}),
    "simulate step": lambda bad: hillobs.simulate(changes={"step": bad}),
    "sweep over one": lambda bad: hillobs.sweep(over={"plant.m": [bad]}),
    "sweep over": lambda bad: hillobs.sweep(over={"plant.m": bad if bad is not True else [True]}),
    "sweep changes": lambda bad: hillobs.sweep(changes={"plant.m": bad}),
    "sweep seeds": lambda bad: hillobs.sweep(seeds=bad),
    "sweep one seed": lambda bad: hillobs.sweep(seeds=[bad]),
    "sweep samples": lambda bad: hillobs.sweep(over={"plant.m": Range(1, 2)}, kind="latin", samples=bad),
    "sweep workers": lambda bad: hillobs.sweep(workers=bad if bad is not None else "x", seeds=1),
    "range low": lambda bad: Range(bad, 1, 3),
    "range high": lambda bad: Range(0, bad, 3),
    "range count": lambda bad: Range(0, 1, bad),
    "estimate changes": lambda bad: hillobs.estimate(RUN, PAIR, changes={"high_gain.eps_h": bad}),
    "estimate doubt": lambda bad: hillobs.estimate(RUN, PAIR, doubt={"F_max": bad}),
    "muscle sds": lambda bad: dataclasses.replace(PAIR.muscle1, sds={"F_max": bad}),
    "estimate keep_every": lambda bad: hillobs.estimate(RUN, PAIR, keep_every=bad),
    "observability place": lambda bad: hillobs.observability(place={"x3": bad}),
    "observability order": lambda bad: hillobs.observability(order=bad if bad is not None else "x"),
    "observability changes": lambda bad: hillobs.observability(changes={"plant.m": bad}),
    **{f"muscle {f}": lambda bad, f=f: dataclasses.replace(PAIR.muscle1, **{f: bad}) for f in ("F_max", "v_max")},
    "muscle numbers": lambda bad: dataclasses.replace(
        PAIR.muscle1, numbers={**PAIR.muscle1.numbers, "tendon_strain": bad}
    ),
    "pair mass": lambda bad: dataclasses.replace(PAIR, mass=bad),
    "pair C": lambda bad: dataclasses.replace(PAIR, C=bad),
    "recording time": lambda bad: dataclasses.replace(RUN, time=bad),
    "recording force_1": lambda bad: RUN.remeasured(force_1=bad),
    "recording true": lambda bad: dataclasses.replace(RUN, true={"velocity": bad}),
}


@pytest.mark.parametrize("place", PLACES)
def test_what_is_no_number_is_refused_in_a_sentence(place: str) -> None:
    for what, bad in BAD.items():
        with pytest.raises(Error) as refused:
            PLACES[place](bad)
        assert str(refused.value).isprintable(), what
        assert len(str(refused.value)) < 600, what


def test_what_a_mask_hides_is_no_value_of_an_axis_and_no_sample() -> None:
    """The numbers under a mask are what its owner does not want counted."""
    hidden = np.ma.array([1.0, 2.0], mask=[False, True])
    with pytest.raises(Error, match=r"plant\.m must be a number, not --"):
        hillobs.sweep(over={"plant.m": hidden})
    shown = np.ma.array([1, 2], mask=False)
    assert numbers("x", shown, 2).tolist() == [1, 2]
    np.testing.assert_array_equal(samples("x", hidden, 2), [1, np.nan])
    assert type(samples("x", shown, 2)) is np.ndarray


@pytest.mark.parametrize("one", [1, 1.0, np.float64(1), np.float32(1), np.int8(1), np.uint64(1)])
def test_numbers_of_python_and_numpy_are_welcome(one: object) -> None:
    assert Range(one, 2, 3).low == 1.0
    assert dataclasses.replace(PAIR, mass=one).mass == 1.0
    assert hillobs.observability(place={"x2": one}).point["x2"] == 1.0


HUGE: dict[str, Callable[[], object]] = {
    "a range": lambda: Range(0.1, 0.2, 10**9),
    "values": lambda: hillobs.sweep(over={"plant.m": range(1, 10**9)}),
    "values of an array": lambda: hillobs.sweep(over={"plant.m": np.broadcast_to(1.0, 10**12)}),
    "seeds": lambda: hillobs.sweep(seeds=10**12),
    "seeds of a range": lambda: hillobs.sweep(seeds=range(10**12)),
    "samples": lambda: hillobs.sweep(over={"plant.m": Range(1, 2)}, kind="sobol", samples=2**40),
    "points": lambda: hillobs.simulate(changes={"record": 5e-4, "duration": 1e6}),
    "steps": lambda: hillobs.simulate(changes={"step": 1e-12}),
    "an order": lambda: hillobs.observability(order=10**9),
    "a recording": lambda: Recording(
        "x", MANY, dict.fromkeys(("position", "force_1", "force_2"), MANY), {}, np.arange(1)
    ),
}


@pytest.mark.parametrize("what", HUGE)
def test_sizes_are_looked_at_before_memory_is_taken(what: str) -> None:
    """50 MB are far more than a sentence needs, and far less than what is asked for."""
    tracemalloc.start()
    try:
        with pytest.raises(Error):
            HUGE[what]()
        assert tracemalloc.get_traced_memory()[1] < 50_000_000
    finally:
        tracemalloc.stop()


def test_parts_of_a_pair_are_what_they_are_called() -> None:
    with pytest.raises(Error, match="muscle1 must be a Muscle"):
        MusclePair(1.0, 1.0, "x", PAIR.muscle2)
    with pytest.raises(Error, match="curves must be those of a muscle file"):
        Muscle("millard2012", 1.0, 1.0, 1.0, 1.0, {})
