"""What a worker of a cluster does: it makes plan and library itself, from text, and computes a part."""

from __future__ import annotations

import functools
import json
import threading
from typing import Any

from ....codegen.batch import CompiledLoop, compile_loop
from ....codegen.cache import BuildError
from ...files.errors import ClusterError
from ..plan import Plan
from ..points import compute_part
from ..row import Rows
from .dask import distributed
from .plan_text import plan_of, text_of
from .same_code import code, difference

# threads of one worker do not build the same thing twice
_building = threading.Lock()


def order(plan: Plan, compiled: CompiledLoop) -> str:
    """What a worker is told: the plan, for which processors to compile it, and what must be the same there."""
    return json.dumps({"plan": text_of(plan), "target": compiled.target, "code": code(compiled.path)})


def work(told: str, part: int) -> Rows:
    """The rows of one part, on a worker. ClusterError if its code differs from that of the machine that asks."""
    dask = distributed()
    me: Any = dask.get_worker()
    leaving = {dask.core.Status[name] for name in ("stopping", "closing", "closed", "failed")}

    def check(_: float) -> None:
        # a worker that is told to go does not finish its part first; another one takes it
        if me.status in leaving:
            raise dask.Reschedule

    try:
        with _building:
            plan, compiled = _prepared(told, me.address)
    except BuildError as error:
        raise ClusterError(f"worker {me.address}: {error}") from error
    return compute_part(plan, compiled, part, check)


@functools.lru_cache(maxsize=4)
def _prepared(told: str, address: str) -> tuple[Plan, CompiledLoop]:
    content = json.loads(told)
    plan = plan_of(content["plan"])
    compiled = compile_loop(plan.loop, content["target"])
    if words := difference(code(compiled.path), content["code"]):
        raise ClusterError(f"worker {address} would not compute the same numbers: {words}")
    return plan, compiled
