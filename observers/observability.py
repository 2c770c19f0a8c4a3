"""Observability by Lie derivatives: which coordinates the outputs determine at a point, and which they do not."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ..model.arrays import Array
from ..model.block import Block, BlockError, Symbols, symbols

# singular values below this part of the largest are zero (docs/observers.md#observability)
TOLERANCE = 1e-9
# what cancellation leaves of a Lie derivative that vanishes
_ROUNDING = 1e-13
# squares of larger numbers are none
_LARGEST = 1e150


def augmented(block: Block, unknown: Sequence[str], derivatives: int = 0) -> Block:
    """`block` with the inputs `unknown` as further states: w, then `d1w` … up to the order given, the last constant.

    Inputs that are not named stay inputs, known and constant. BlockError for an unknown name or a negative order.
    """
    if derivatives < 0:
        raise BlockError(f"{block.name}: the order of the unknowns' derivatives must be at least 0, not {derivatives}")
    if missing := [name for name in unknown if name not in block.u]:
        raise BlockError(f"{block.name}: no input {', '.join(missing)}; there are {', '.join(block.u)}")
    x, dx = Symbols(block.x), Symbols(block.dx)
    for name in unknown:
        chain = Symbols({name: block.u[name], **symbols(f"d{k}{name}" for k in range(1, derivatives + 1))})
        x |= chain
        dx |= dict(zip(chain, [*list(chain.values())[1:], ca.SX(0)], strict=True))
    u = Symbols({name: symbol for name, symbol in block.u.items() if name not in unknown})
    return dataclasses.replace(block, x=x, dx=dx, u=u, x0=Symbols(), held=frozenset())


def with_constants(block: Block, names: Sequence[str]) -> Block:
    """`block` with the parameters `names` as further states that stay as they are. BlockError for an unknown name."""
    if missing := [name for name in names if name not in block.p]:
        raise BlockError(f"{block.name}: no number {', '.join(missing)}; there are {', '.join(block.p)}")
    chosen, kept = block.p.only(names), [name for name in block.p if name not in names]
    still = Symbols({name: ca.SX(0) for name in names})
    parameters = {name: block.parameters[name] for name in kept}
    return dataclasses.replace(
        block,
        x=Symbols({**block.x, **chosen}),
        dx=Symbols({**block.dx, **still}),
        p=block.p.only(kept),
        parameters=parameters,
        x0=Symbols(),
        limits=Symbols(),
    )


def lie_derivatives(block: Block, outputs: Sequence[str], order: int) -> list[ca.SX]:
    """h, L_f h, … L_f^order h, each a column over the outputs."""
    _check(block, outputs, order)
    x, f = block.x.vector(), Symbols({name: block.dx[name] for name in block.x}).vector()
    columns = [ca.vertcat(*(block.y[name] for name in outputs))]
    for _ in range(order):
        # L_f^{k+1} h = (∂ L_f^k h/∂x) f;  without cse the expressions double with each order
        columns.append(ca.cse(ca.jtimes(columns[-1], x, f)))
    return columns


def observability_matrix(block: Block, outputs: Sequence[str], order: int) -> ca.Function:
    """O = ∂(h, L_f h, …)/∂x as a dense function of (x, u, p); rows by order, then by output."""
    rows = ca.vertcat(*lie_derivatives(block, outputs, order))
    matrix = ca.cse(ca.densify(ca.jacobian(rows, block.x.vector())))
    return ca.Function("observability", _arguments(block), [matrix], ["x", "u", "p"], ["matrix"])


def structural_rank(block: Block, outputs: Sequence[str], order: int) -> int:
    """The rank that the pattern of zeros in O allows: full even where a slack tendon makes numbers vanish."""
    rows = ca.vertcat(*lie_derivatives(block, outputs, order))
    return int(ca.sprank(ca.jacobian(rows, block.x.vector())))


def decoupling_matrix(block: Block, outputs: Sequence[str], unknown: Sequence[str]) -> ca.Function:
    """∂(h_i, …, L_f^{r_i} h_i)/∂x for all outputs i, r_i the order at which an unknown first appears in output i.

    Where it is square and regular, state and unknowns follow from finitely many derivatives of the outputs.
    """
    _check(block, outputs, 0)
    if not unknown or (missing := [name for name in unknown if name not in block.x]):
        named = ", ".join(missing) if unknown else "none"
        raise BlockError(f"{block.name}: no coordinate {named} that could be unknown; there are {', '.join(block.x)}")
    w = ca.vertcat(*(block.x[name] for name in unknown))
    rows = []
    for name in outputs:
        row = lie_derivatives(block, [name], 0)
        while len(row) <= len(block.x) and not any(ca.which_depends(row[-1], w, 1, True)):
            row = lie_derivatives(block, [name], len(row))
        rows += row
    matrix = ca.cse(ca.densify(ca.jacobian(ca.vertcat(*rows), block.x.vector())))
    return ca.Function("decoupling", _arguments(block), [matrix], ["x", "u", "p"], ["matrix"])


@dataclass(frozen=True)
class Verdict:
    """What O says at one point. Singular values are those of the scaled matrix, largest first."""

    coordinates: tuple[str, ...]
    rank: int
    ranks: tuple[int, ...]  # with Lie derivatives of the orders 0 … k
    singular_values: tuple[float, ...]
    unobservable: tuple[str, ...]  # coordinates whose column can be deleted without losing rank
    null_directions: tuple[Mapping[str, float], ...]  # what moves without a trace, per typical size, largest part 1
    weakest: Mapping[str, float]  # what moves with the smallest trace, in the same way

    @property
    def full(self) -> bool:
        """Every coordinate is determined."""
        return self.rank == len(self.coordinates)


def judge(
    matrix: Array, coordinates: Sequence[str], sizes: Mapping[str, float], outputs: int, tolerance: float = TOLERANCE
) -> Verdict:
    """The verdict on O at one point; sizes: typical size of each coordinate, outputs: rows per order.

    BlockError if O is not finite there.
    """
    if not _computable(matrix):
        raise BlockError("the observability matrix is not finite at this point, or so large that it has no square")
    scaled = scale(matrix, [sizes[name] for name in coordinates], outputs)
    values = _singular_values(scaled)
    smallest = tolerance * values[0]
    rank = _rank(scaled, smallest)
    ranks = tuple(_rank(scaled[: outputs * k], smallest) for k in range(1, len(matrix) // outputs + 1))
    without = {name: np.delete(scaled, i, axis=1) for i, name in enumerate(coordinates)}
    lost = tuple(name for name, rest in without.items() if _rank(rest, smallest) == rank)
    directions = [_words(row, coordinates) for row in np.linalg.svd(scaled)[2]]
    null = tuple(directions[rank:])
    return Verdict(tuple(coordinates), rank, ranks, tuple(values.tolist()), lost, null, directions[-1])


def scale(matrix: Array, sizes: Sequence[float], outputs: int) -> Array:
    """Columns × typical size, rows normalised; zero rows stay zero. Works on a stack of matrices too.

    A row that is smaller than the rounding of the same output's row one order below is zero.
    """
    columns = matrix * np.asarray(sizes)
    norms = np.linalg.norm(columns, axis=-1, keepdims=True)
    below = np.concatenate([np.zeros_like(norms[..., :outputs, :]), norms[..., :-outputs, :]], axis=-2)
    scaled: Array = np.divide(columns, norms, out=np.zeros_like(columns), where=norms > _ROUNDING * below)
    return scaled


def ranks_of(matrices: Array, sizes: Sequence[float], outputs: int, tolerance: float = TOLERANCE) -> NDArray[np.int64]:
    """The rank of each matrix of a stack (points × rows × columns); −1 where it is not finite, or too large."""
    finite = _computable(matrices)
    values = _singular_values(scale(np.where(finite[:, None, None], matrices, 0.0), sizes, outputs))
    ranks: NDArray[np.int64] = np.where(finite, np.sum(values > tolerance * values[:, :1], axis=1), -1)
    return ranks


def _computable(matrices: Array) -> NDArray[np.bool_]:
    """Whether all entries of a matrix, or of each of a stack, are numbers of which singular values can be computed."""
    return np.asarray((np.abs(matrices) <= _LARGEST).all(axis=(-2, -1)))


def _singular_values(matrices: Array) -> Array:
    return np.asarray(np.linalg.svd(matrices, compute_uv=False), dtype=np.float64)


def _rank(matrix: Array, smallest: float) -> int:
    return int(np.sum(_singular_values(matrix) > smallest))


def _words(direction: Array, coordinates: Sequence[str]) -> dict[str, float]:
    largest = direction[np.argmax(np.abs(direction))]
    parts = direction / largest
    return {name: round(float(part), 6) for name, part in zip(coordinates, parts, strict=True) if abs(part) > 1e-6}


def _check(block: Block, outputs: Sequence[str], order: int) -> None:
    if not outputs:
        raise BlockError(f"{block.name}: without an output nothing can be observed; there are {', '.join(block.y)}")
    if missing := [name for name in outputs if name not in block.y]:
        raise BlockError(f"{block.name}: no output {', '.join(missing)}; there are {', '.join(block.y)}")
    if jumping := [*block.next, *block.per_step]:
        raise BlockError(
            f"{block.name}: Lie derivatives need continuous states, but {', '.join(jumping)} moves in jumps"
        )
    if order < 0:
        raise BlockError(f"{block.name}: the order of the Lie derivatives must be at least 0, not {order}")


def _arguments(block: Block) -> list[ca.SX]:
    return [block.x.vector(), block.u.vector(), block.p.vector()]
