"""The observability matrix at many points, as compiled C."""

from __future__ import annotations

import functools
from collections.abc import Mapping

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ...codegen.shared_library import Library, compile_functions
from ...model.arrays import Array
from ...observers.observability import TOLERANCE, decoupling_matrix, ranks_of
from ..files.errors import ScenarioError
from ..files.progress import Progress
from .question import Question

_CHUNK = 4000


def matrices(question: Question, points: Mapping[str, Array], progress: Progress) -> Array:
    """O at many points as compiled C: (points × rows × coordinates)."""
    library = _compiled(question.matrix)
    x, u = _columns(question, points)
    chunks = []
    for begin in range(0, len(x), _CHUNK):
        rows = slice(begin, begin + _CHUNK)
        (flat,) = library.call("observability", x[rows], u[rows], question.p)
        chunks.append(flat.reshape(len(flat), x.shape[1], -1).transpose(0, 2, 1))
        progress(min(1.0, rows.stop / len(x)))
    return np.concatenate(chunks)


def _columns(question: Question, points: Mapping[str, Array]) -> tuple[Array, Array]:
    """Coordinates and known inputs (points × names) of points that are numbers or arrays by name."""
    names = [*question.block.x, *question.block.u]
    columns = np.stack(np.broadcast_arrays(*(points[name] for name in names)), axis=1)
    x, u = np.split(columns, [len(question.block.x)], axis=1)
    return x, u


@functools.cache
def _compiled(matrix: ca.Function) -> Library:
    return compile_functions([matrix])


def rank_and_conditioning(
    question: Question, stack: Array, tolerance: float = TOLERANCE
) -> tuple[NDArray[np.int64], Array]:
    """The rank of each O, and its smallest singular value with columns × typical size and rows as they are.

    The second fades continuously where the first jumps: it is how much the outputs and their derivatives change
    when the worst combination of coordinates changes by its typical size.
    """
    sizes = [question.sizes[name] for name in question.coordinates]
    ranks = ranks_of(stack, sizes, len(question.sensors), tolerance)
    values = np.linalg.svd(np.where(ranks[:, None, None] >= 0, stack, 0.0) * sizes, compute_uv=False)
    return ranks, np.asarray(values[:, -1])


def determinant(question: Question, points: Mapping[str, Array]) -> Array:
    """|det| of the map from (x, Δ, u) to the fewest output derivatives: Φ′²_S1 Φ′²_S2 for the paper's sensors."""
    function = decoupling_matrix(question.block, question.outputs, question.unknowns)
    if function.size1_out(0) != function.size2_out(0):
        raise ScenarioError(
            "the determinant needs as many output derivatives as coordinates: x1,F1,F2 with unknown u or a"
        )
    x, u = _columns(question, points)
    (flat,) = compile_functions([function]).call("decoupling", x, u, question.p)
    n = x.shape[1]
    return np.asarray(np.abs(np.linalg.det(flat.reshape(len(flat), n, n))))
