"""What every observer must do, ours or a user's own: call `conformance(block)` on yours."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import casadi as ca
import numpy as np

from ..codegen.shared_library import compile_functions
from ..codegen.stepper import STAGES, compiled, functions
from ..model.arrays import Array
from ..model.block import Block, BlockError
from ..model.symbols import MEASURED
from ..observers import OBSERVERS, estimator
from ..observers.ports import SENSED
from ..observers.tendons import tendons
from .simulate.run import simulate

_POINTS = 200
# of the largest estimate: a user's observer is compiled anew with the others, and another library rounds otherwise
_ROUNDING = 1e-9
_STEP = 1e-4
_AGREEMENT = 1e-12
# forces at which a tendon is slack, at its edge, in the toe, at the end of the toe, beyond; a sensor may read below 0
_FORCES = (-1e-3, 0.0, 1e-12, 0.1, 0.5, 2.0)


def conformance(block: Block) -> list[str]:
    """What is wrong with the observer `block`, in sentences; empty if it conforms.

    Checked: the ports, the description of its parameters, finite numbers for taut and slack tendons and for zero
    error, compiled C equal to the expressions, and that it runs beside the others without changing them.
    BuildError if nothing can be compiled.

    >>> x = hillobs.symbols("x1_hat x2_hat Delta_hat x3_hat u1_hat x4_hat u2_hat")
    >>> y = hillobs.symbols("y1 y2 y3")
    >>> still = hillobs.Symbols({name: 0 for name in x})
    >>> hillobs.conformance(hillobs.Block("still", x=x, u=y, dx=still, y=x))
    []
    """
    try:
        whole = estimator(block)
    except BlockError as error:
        return [str(error)]
    complaints = [*_descriptions(block), *_numbers(whole)]
    return complaints or [*_compiled(whole), *_runs(block)]


def _descriptions(block: Block) -> Iterator[str]:
    for name, parameter in block.parameters.items():
        if not (parameter.sentence and parameter.source and parameter.unit):
            yield f"{block.name}: parameter {name} needs a sentence, a source and a unit"


def _numbers(whole: Block) -> Iterator[str]:
    table, front = functions(whole, sorted(whole.held), SENSED), functions(tendons(), (), MEASURED)
    p, p_front = ([parameter.default for parameter in block.parameters.values()] for block in (whole, tendons()))
    held = [0.0] * len(whole.held)
    for force in _FORCES:
        y = [2.6, force, force]
        lengths, _ = front["out"](0, [], p_front, [], y)
        seen = ca.vertcat(y, lengths)
        x = table["init"](0, p, held, seen)
        after, _ = table["step"](0, _STEP, x, p, held, ca.repmat(seen, 1, STAGES))
        jumps = {role: table[role](_STEP, x, p, held, seen) for role in ("sample", "each") if role in table}
        outputs, domain = table["out"](0, x, p, held, seen)
        guards = table["watch"](0, x, p, held, seen)
        for what, values in (
            ("start", x),
            ("step", after),
            *jumps.items(),
            ("outputs", outputs),
            ("guards", guards),
            ("domain", domain),
        ):
            if not np.isfinite(np.array(values, dtype=float)).all():
                yield f"{whole.name}: {what} not finite at the measured forces {force:g}"


def _compiled(whole: Block) -> Iterator[str]:
    table = compiled(functions(whole, sorted(whole.held), SENSED))
    library = compile_functions(list(table.values()))
    for function in table.values():
        points = _points(whole, function)
        ours = np.hstack(library.call(function.name(), *points))
        expected = np.array([_evaluate(function, row) for row in zip(*points, strict=True)])
        if not np.allclose(ours, expected, rtol=_AGREEMENT, atol=_AGREEMENT, equal_nan=True):
            yield f"{function.name()}: compiled C and expression differ by {np.nanmax(np.abs(ours - expected)):.1e}"


def _evaluate(function: ca.Function, row: Sequence[Array]) -> Array:
    """All results of the CasADi function at one point, one after the other."""
    given = [ca.reshape(ca.DM(value), *function.size_in(i)) for i, value in enumerate(row)]
    return np.concatenate([np.array(result, dtype=float).ravel(order="F") for result in function.call(given)])


def _points(whole: Block, function: ca.Function) -> list[Array]:
    """Random arguments about the start of a run."""
    random = np.random.default_rng(0)
    p = np.array([parameter.default for parameter in whole.parameters.values()])
    nothing = np.zeros(1)
    centre = {"t": nothing, "node": nothing, "h": np.full(1, 1e-3), "p": p, "held": np.zeros(len(whole.held))}
    result = []
    for i in range(function.n_in()):
        name, size = function.name_in(i), function.numel_in(i)
        spread = random.uniform(-1, 1, (_POINTS, size))
        if name == "staged":
            result.append(np.tile([2.6, 0.1, 0.1, 2.02, 2.02], size // len(SENSED)) + 0.05 * spread)
        elif name == "x":
            result.append(0.1 + 0.1 * spread)
        else:
            result.append(np.broadcast_to(centre[name], (_POINTS, size)) + 0 * spread)
    return result


def _runs(block: Block) -> Iterator[str]:
    short = {"duration": 0.5, "score.start": 0.1}
    registered = block.name in OBSERVERS
    beside = simulate("paper-noisy", [*OBSERVERS, *([] if registered else [block])], short)
    alone = simulate("paper-noisy", [block.name if registered else block], short)
    for name in ("x_hat", "u_hat", "a_hat", "Delta_hat"):
        apart, together = (run[name].sel(observer=block.name).values for run in (alone, beside))
        if not np.isfinite(apart).all():
            yield f"{block.name}: {name} is not finite in paper-noisy"
        allowed = 0.0 if registered else _ROUNDING * float(np.nanmax(np.abs(together), initial=0.0))
        if not np.allclose(apart, together, rtol=0.0, atol=allowed, equal_nan=True):
            yield f"{block.name}: {name} depends on which other observers run"
