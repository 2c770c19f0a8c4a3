"""What programs may do with an FMU, in both versions: any steps, the past again, errors, several at once."""

from pathlib import Path

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from exported_fmus import VERSIONS, instance, samples, saved_fmus, this_machine_only
from exported_programs import PERIOD, needs_cc

pytestmark = [pytest.mark.chaos, needs_cc]
__all__ = ["this_machine_only"]
NAME = "high_gain"
FIRST = dict(zip(("y1", "y2", "y3"), samples(1)[0].tolist(), strict=True))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hillobs.codegen.targets.platforms.zig", lambda: None)
        return saved_fmus(tmp_path_factory.mktemp("fmu"), NAME)


@pytest.fixture(params=VERSIONS)
def made(request: pytest.FixtureRequest, folder: Path):
    with instance(folder, NAME, request.param) as fmu:
        yield fmu


def refused(call, *arguments, words: str, fmu) -> None:
    """The call is an error, which the program is told of."""
    fmu.told.clear()
    with pytest.raises(FMICallException, match="status 3"):
        call(*arguments)
    assert words in " ".join(fmu.told)


# longer than the period and a multiple of it, longer and none, shorter
@pytest.mark.parametrize("step", [0.02, 0.0125, 0.001])
def test_it_samples_each_period_whatever_the_steps_are(made, step: float) -> None:
    y = samples(400)
    made.begin(**FIRST)
    told = made.run(y, step)
    made.fmu.terminate()
    made.fmu.reset()
    made.begin(**FIRST)
    # instants k T in [i step, (i + 1) step), which see what was set at i step
    last, expected = 0, []
    for i, row in enumerate(y):
        due = int(np.ceil((i + 1) * step / PERIOD - 1e-3))
        made.run(np.tile(row, (due - last, 1)), PERIOD, last * PERIOD)
        last = due
        expected.append(made.get(made.outputs))
    assert (told == np.array(expected)).all()


def test_after_a_reset_the_same_run_is_the_same(made) -> None:
    y = samples(100)
    made.begin(**FIRST)
    first = made.run(y, PERIOD)
    made.fmu.terminate()
    refused(made.step, 100 * PERIOD, PERIOD, words="after the end", fmu=made)
    made.fmu.reset()
    made.begin(**FIRST)
    assert (made.run(y, PERIOD) == first).all()


def test_a_start_at_another_time_changes_nothing_but_the_time(made) -> None:
    y = samples(100)
    made.begin(**FIRST)
    first = made.run(y, PERIOD)
    made.fmu.reset()
    made.begin(start=2.5, **FIRST)
    assert (made.run(y, PERIOD, 2.5) == first).all()


def test_what_was_can_be_again(made) -> None:
    y = samples(200)
    made.begin(**FIRST)
    made.run(y[:100], PERIOD)
    before = made.get(made.outputs)
    state = made.save()
    serialized = made.to_bytes(state)
    expected = made.run(y[100:], PERIOD, 100 * PERIOD)
    made.restore(state)
    assert made.get(made.outputs) == before
    assert (made.run(y[100:], PERIOD, 100 * PERIOD) == expected).all()
    again = made.of_bytes(serialized)
    made.restore(again)
    assert (made.run(y[100:], PERIOD, 100 * PERIOD) == expected).all()
    made.forget(state)
    made.forget(again)


def test_bytes_of_something_else_are_no_state(made) -> None:
    made.begin(**FIRST)
    state = made.save()
    serialized = made.to_bytes(state)
    for wrong in (serialized[:-1], b"x" + serialized[1:]):
        refused(made.of_bytes, wrong, words="no state of this high_gain", fmu=made)
    made.forget(state)


def test_a_state_goes_on_in_another_instance(folder: Path) -> None:
    for version in VERSIONS:
        with instance(folder, NAME, version) as one, instance(folder, NAME, version) as other:
            one.begin(**FIRST)
            other.begin(**FIRST)
            one.run(samples(100), PERIOD)
            state = one.save()
            other.restore(other.of_bytes(one.to_bytes(state)))
            more = samples(50)
            assert (one.run(more, PERIOD, 100 * PERIOD) == other.run(more, PERIOD, 100 * PERIOD)).all()


def test_two_instances_do_not_know_each_other(folder: Path) -> None:
    y = samples(200)
    for version in VERSIONS:
        with instance(folder, NAME, version) as one, instance(folder, NAME, version) as other:
            one.begin(**FIRST)
            alone = one.run(y, PERIOD)
            one.fmu.reset()
            one.begin(**FIRST)
            other.begin(**FIRST)
            other.set({"eps_h": 0.2})
            rows = []
            for k in range(len(y)):
                rows.append(one.run(y[k : k + 1], PERIOD, k * PERIOD)[0])
                other.run(y[k : k + 1] * 1.001, PERIOD, k * PERIOD)
            assert (np.array(rows) == alone).all()


def test_a_parameter_counts_from_the_next_step_on(made) -> None:
    y = samples(100)
    made.begin(**FIRST)
    usual = made.run(y, PERIOD)
    made.fmu.reset()
    made.begin(**FIRST)
    assert (made.run(y[:50], PERIOD) == usual[:50]).all()
    made.set({"eps_h": 0.3})
    assert made.get(["eps_h"]) == [0.3]
    assert (made.run(y[50:], PERIOD, 50 * PERIOD) != usual[50:]).any()


def test_references_to_nothing_are_refused(made) -> None:
    largest = max(made.references.values())
    refused(made.get_references, [largest + 1], words="no variable", fmu=made)
    for reference in (0, made.references["x1_hat"], largest + 1, 2**32 - 1):
        refused(made.set_references, [reference], [1.0], words="no input or parameter", fmu=made)


def test_steps_that_cannot_be_are_refused(made) -> None:
    refused(made.step, 0.0, PERIOD, words="before the initialization", fmu=made)
    made.begin(**FIRST)
    refused(made.step, 1.0, PERIOD, words="where the last one ended", fmu=made)
    for size in (-PERIOD, np.nan, np.inf):
        refused(made.step, 0.0, size, words="a finite number", fmu=made)
    made.step(0.0, 0.0)
    made.run(samples(10), PERIOD)


def test_a_sample_that_is_no_number_is_an_error_and_can_be_taken_back(made) -> None:
    y = samples(20)
    made.begin(**FIRST)
    expected = made.run(y, PERIOD)
    made.fmu.reset()
    made.begin(**FIRST)
    made.run(y[:10], PERIOD)
    state = made.save()
    made.set({"y2": np.nan})
    refused(made.step, 10 * PERIOD, PERIOD, words="not finite or beyond its limits", fmu=made)
    assert made.get(made.outputs) == expected[9].tolist()
    made.restore(state)
    assert (made.run(y[10:], PERIOD, 10 * PERIOD) == expected[10:]).all()
    made.forget(state)


def test_inputs_that_come_with_the_first_step_are_early_enough(made) -> None:
    y = samples(50)
    made.begin(**FIRST)
    expected = made.run(y, PERIOD)
    made.fmu.reset()
    made.begin()  # all inputs are 0
    assert (made.run(y, PERIOD) == expected).all()
    assert made.told == []
