"""The contenders of `make bench` solve the same problem, and the emitter writes what CasADi computes."""

from collections.abc import Iterator

import casadi as ca
import numpy as np
import pytest

from benchmarks.contenders import AbsentError, numpy_batch, ours, plain_c
from benchmarks.contenders.optional import imported
from benchmarks.emit import JAX, NUMBERS, NUMPY, in_loop, python, source
from benchmarks.lean import lean_rates, lean_step
from benchmarks.problem import noise, problem, right_hand_side, states
from benchmarks.report import Section
from benchmarks.roofline import Work, work_of
from few_observers import few_observers
from hillobs.observers import PAPER

RUNS = 3


@pytest.fixture(scope="module", autouse=True)
def _few() -> Iterator[None]:
    """The library of the problem has the observers that take part."""
    with few_observers(*PAPER):
        yield


def functions() -> list[tuple[ca.Function, dict[str, list[float]]]]:
    """Every function that a contender is made of, and the roles of all Blocks of the loop, with parameters."""
    of = problem()
    rates, step = lean_rates(of), lean_step(of)
    whole, numbers = right_hand_side(of)
    own = [(f, {}) for f in (rates.function, rates.clock, step.function, step.clock)]
    roles = [(f, {"p": of.numbers[b.name]}) for b in of.loop.blocks for f in of.loop.functions(b).values()]
    return [(whole, {"p": numbers}), *own, *roles]


@pytest.mark.parametrize("dialect", [NUMBERS, NUMPY], ids=lambda d: d.module)
def test_the_python_of_every_function_is_what_casadi_computes(dialect) -> None:
    rng = np.random.default_rng(0)
    for f, known in functions():
        given = [rng.uniform(0.5, 2.5, (RUNS, f.numel_in(i))) for i in range(f.n_in())]
        for i, name in enumerate(f.name_in()):
            if name in known:
                given[i][:] = known[name]
        emitted = python(f, dialect)
        abreast = emitted(*(a.T for a in given)) if dialect is NUMPY else None
        for run in range(RUNS):
            arguments = [a[run] for a in given]
            exact = f.call([ca.reshape(ca.DM(a), *f.size_in(i)) for i, a in enumerate(arguments)])
            found = abreast or emitted(*(a.tolist() for a in arguments))
            for i, values in enumerate(found):
                own = [np.broadcast_to(v, RUNS)[run] for v in values]
                np.testing.assert_allclose(own, np.array(exact[i]).ravel("F"), rtol=1e-12, atol=1e-12, err_msg=f.name())


def test_a_loop_over_runs_is_the_same_run_by_run() -> None:
    f = lean_step(problem()).function
    rng = np.random.default_rng(1)
    c, x, w = (rng.uniform(0.5, 2.5, size) for size in (f.numel_in(0), (f.numel_in(1), RUNS), (f.numel_in(2), RUNS)))
    after = x.ravel().copy()
    in_loop(f, RUNS, ("x", "w"), "x")(c, after, w.ravel())
    expected = [np.array(f(c, x[:, run], w[:, run])).ravel() for run in range(RUNS)]
    np.testing.assert_allclose(after.reshape(-1, RUNS).T, expected, rtol=1e-12)


def test_an_operation_without_a_translation_is_refused() -> None:
    x = ca.SX.sym("x")
    with pytest.raises(ValueError, match="erfc: instruction 1 is an operation that has no Python"):
        source(ca.Function("erfc", [x], [ca.erf(x)]), JAX)


@pytest.mark.parametrize(
    "build",
    [plain_c.exported, plain_c.shared, lambda of: numpy_batch.batch(of, runs=4), ours.Variant()],
    ids=["exported C", "shared C", "NumPy", "ours"],
)
def test_the_contenders_end_where_our_kernel_ends(build) -> None:
    of = problem()
    contender = build(of)
    np.testing.assert_allclose(contender.final(), states(of, contender.steps), rtol=0, atol=1e-9)


def test_with_noise_they_end_where_the_as_written_model_ends() -> None:
    """The noise of the peers reaches the sensors: NumPy's lean step against CasADi's VM on the wired Block."""
    of, steps = problem(), 100
    f, numbers = right_hand_side(of)
    h, x, samples = of.grid.h, of.x0, noise(of, 2, steps)
    for k in range(steps):
        w = samples[k // of.grid.hold, :, 1]
        k1 = f(k * h, x, numbers, w)
        k2 = f((k + 0.5) * h, x + h / 2 * k1, numbers, w)
        k3 = f((k + 0.5) * h, x + h / 2 * k2, numbers, w)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + f((k + 1) * h, x + h * k3, numbers, w))
    found = np.asarray(numpy_batch.batch(of, runs=2).work())[:, 1]
    np.testing.assert_allclose(found, np.array(x).ravel(), rtol=0, atol=1e-9)
    assert np.abs(found - states(of, steps)).max() > 1e-4


def test_operations_are_counted_from_the_graph() -> None:
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    f = ca.Function("f", [x, y], [x * y + ca.sqrt(x) / y, ca.fmax(x - y, 0)])
    assert work_of(f) == Work(flops=5, divisions=1, roots=1)
    assert work_of(f).times(2) + work_of(f) == work_of(f).times(3)


def test_who_is_not_installed_says_so_in_a_sentence() -> None:
    with pytest.raises(AbsentError, match=r"no_such_package is not installed: pip install 'hillobs\[bench\]'"):
        imported("no_such_package")


def test_a_section_is_a_table_in_markdown() -> None:
    text = Section("Title.", ["", "a"], [["row", "1"]]).markdown()
    assert text == "Title.\n\n|  | a |\n| --- | ---: |\n| row | 1 |"
