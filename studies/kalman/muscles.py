"""What follows from estimates for muscles: activations, how sure they are, and the law between them."""

from __future__ import annotations

import functools
from collections.abc import Mapping

import casadi as ca
import numpy as np

from ...codegen.shared_library import compile_functions
from ...model.arrays import Array
from ...model.block import Block
from ...model.system import System
from ...observers.behind.activation import activation_estimate
from ...observers.behind.spread import spread
from ...observers.kalman.activations import linear_law
from ...observers.kalman.apart.activations import linear_law as law_apart
from ...observers.kalman.apart.estimates import estimates_apart
from ...observers.slopes import tendon_lines

ACTIVATION, SPREAD, LAW, TENDONS, APART = "activation", "spread", "linear_law", "tendon_lines", "kalman"


class CompiledMuscles:
    """The Blocks behind estimates as functions of many samples: of the pair those but the last, else the last three."""

    def __init__(self, system: System) -> None:
        of_pair = (activation_estimate, spread, linear_law, tendon_lines)
        blocks = [of(system) for of in (of_pair if system.paper else (law_apart, tendon_lines, estimates_apart))]
        self._blocks = {block.name: block for block in blocks}
        self._library = compile_functions([_function(block) for block in self._blocks.values()])

    def outputs(self, name: str, numbers: Mapping[str, float], given: Mapping[str, Array]) -> dict[str, Array]:
        """Outputs and guards (n) by name, of one of the above; numbers, given: by the names it knows."""
        block = self._blocks[name]
        columns = np.stack([given[port] for port in block.u], axis=-1)
        (results,) = self._library.call(name, columns, [numbers[number] for number in block.p])
        return dict(zip([*block.y, *block.guards], results.T, strict=True))


@functools.lru_cache(maxsize=8)
def compiled_muscles(system: System) -> CompiledMuscles:
    """What follows from estimates of a system, compiled once."""
    return CompiledMuscles(system)


def _function(block: Block) -> ca.Function:
    results = ca.densify(ca.vertcat(block.y.vector(), block.guards.vector()))
    return ca.Function(block.name, [block.u.vector(), block.p.vector()], ca.cse([results]))
