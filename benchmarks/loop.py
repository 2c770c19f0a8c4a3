"""How much faster the compiled loop is than the same step in CasADi's virtual machine, interleaved in one run."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import casadi as ca

from hillobs.model.curves import NGUYEN2019
from hillobs.studies.loops import compile_loop, paper_loop
from hillobs.studies.prepare import prepare

ROUNDS = 7
VM_STEPS = 400


def clock(work: Callable[[], object]) -> float:
    """CPU seconds of `work`."""
    start = time.process_time()
    work()
    return time.process_time() - start


def main() -> None:
    """Print steps per second of both and their ratio, medians over the rounds."""
    prepared = prepare("paper-noisy", None, {})
    loop, grid = paper_loop("virtual", NGUYEN2019), prepared.grid
    compiled = compile_loop(loop)
    numbers = {block.name: prepared.table.values(block, prepared.scenario.given) for block in loop.blocks}
    names = [block.name for block in loop.observers]
    truth, front = loop.functions(loop.truth), loop.functions(loop.front)["out"]
    steps = [loop.functions(block)["step"] for block in loop.observers]
    held, tendons = [0.0] * len(loop.held), [parameter.default for parameter in loop.front.parameters.values()]
    x = truth["init"](0, numbers["truth"], held, [])
    starts = [[0.1] * len(block.x) for block in loop.observers]

    def machine() -> None:
        for _ in range(VM_STEPS):
            _, stages = truth["step"](0, grid.h, x, numbers["truth"], held, [])
            # without noise the sensors show what they look at
            seen = ca.vertcat(stages, ca.horzcat(*(front(0, [], tendons, held, y)[0] for y in ca.horzsplit(stages))))
            for step, start, name in zip(steps, starts, names, strict=True):
                step(0, grid.h, start, numbers[name], held, seen)

    fast, slow = [], []
    for _ in range(ROUNDS):
        fast.append(grid.steps / clock(lambda: compiled.run(grid, 0, numbers, names)))
        slow.append(VM_STEPS / clock(machine))
    ratio = statistics.median(f / s for f, s in zip(fast, slow, strict=True))
    print(f"closed-loop steps per CPU second, {len(names)} estimators, scores and noise included (median of {ROUNDS}):")
    print(f"compiled: {statistics.median(fast):,.0f}")
    print(f"CasADi's virtual machine, step by step from Python: {statistics.median(slow):,.0f}")
    print(f"ratio {ratio:.0f}")


if __name__ == "__main__":
    main()
