"""A Block as functions: where it starts, one RK4 step, what happens at a sample and at a grid point, its outputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import casadi as ca

from ..model.block import STEP, Block, BlockError, Symbols

# RK4: where each stage is taken and what it weighs
NODES = (0.0, 0.5, 0.5, 1.0)
WEIGHTS = (1 / 6, 1 / 3, 1 / 3, 1 / 6)
STAGES = len(NODES)
# what has no limit of its own: the sum of its squares over 10⁹ steps is a number still
_LARGEST = 1e145
# instructions; the stages of the paper's runs have some hundred
_LARGE_STAGE = 1_000


def functions(
    block: Block, held: Sequence[str], staged: Sequence[str], stage_outputs: Sequence[str] = ()
) -> dict[str, ca.Function]:
    """The functions of `block` by role, all over the same inputs.

    held, staged: names of the external inputs in array order; `block` takes what it knows by name.
    stage_outputs: outputs that `step` also returns at each of its four stages.

        init  (t, p, held, staged)                 → x
        scales(h, p)                               → 1 over the largest magnitude of each x, then y
        step  (t, h, x, p, held, staged (n × 4))   → x, stage outputs (n × 4)
        stage (t, h, node, x, p, held, staged)     → h ẋ at t + node h, stage outputs, if no input is held over a step
        sample(t, x, p, held, staged)              → x, if states move by `next`
        each  (t, x, p, held, staged)              → x, if states move by `per_step`
        out   (t, x, p, held, staged)              → y, domain
        watch (t, x, p, held, staged)              → guards
    """
    known = {"t", *held, *staged}
    if unknown := [port for port in block.u if port not in known]:
        raise BlockError(f"{block.name}: no one provides the inputs {', '.join(unknown)}; there are {sorted(known)}")
    t, h, x, p = ca.SX.sym("t"), ca.SX.sym("h"), _column("x", block.x), _column("p", block.p)
    w, v = _column("held", held), _column("staged", staged)
    values = {
        "t": t,
        **dict(zip(held, ca.vertsplit(w), strict=True)),
        **dict(zip(staged, ca.vertsplit(v), strict=True)),
    }

    def at(entries: Symbols) -> ca.SX:
        """The expressions in terms of the columns x, p, held, staged and t."""
        old = [*block.x.values(), *block.p.values(), *block.u.values()]
        new = [*ca.vertsplit(x), *ca.vertsplit(p), *(values[port] for port in block.u)]
        return (
            ca.densify(ca.substitute(entries.vector(), ca.vertcat(*old), ca.vertcat(*new))) if old else entries.vector()
        )

    def moved(by: Symbols) -> ca.SX:
        """The state after the jump `by`, other states as they are."""
        return at(Symbols({name: by.get(name, symbol) for name, symbol in block.x.items()}))

    point, names = [t, x, p, w, v], ["t", "x", "p", "held", "staged"]
    start = Symbols({name: block.x0.get(name, ca.SX(0)) for name in block.x})
    rates = Symbols({name: block.dx.get(name, ca.SX(0)) for name in block.x})
    outputs = Symbols({name: block.y[name] for name in stage_outputs})
    rhs = ca.Function("rhs", point, [at(rates), at(outputs)])
    limits = [ca.fmin(block.limits.get(name, ca.SX(_LARGEST)), _LARGEST) for name in (*block.x, *block.y)]
    scales = at(Symbols({str(i): 1 / limit for i, limit in enumerate(limits)}))
    result = {
        "scales": _function(block, "scales", [h, p], [ca.substitute(scales, STEP, h)], ["h", "p"], ["scales"]),
        "init": _function(block, "init", [t, p, w, v], [at(start)], ["t", "p", "held", "staged"], ["x_next"]),
        "step": _step(block, rhs, t, h, x, p, w, [name in block.held for name in staged]),
        "out": _function(block, "out", point, [at(block.y), at(block.domain)], names, ["y", "domain"]),
        "watch": _function(block, "watch", point, [at(block.guards)], names, ["guards"]),
    }
    if not any(name in block.held for name in staged):
        node = ca.SX.sym("node")
        rate, seen = rhs(t + node * h, x, p, w, v)
        result["stage"] = _function(
            block, "stage", [t, h, node, x, p, w, v], [h * rate, seen], ["t", "h", "node", *names[1:]], ["dx", "seen"]
        )
    for role, jump in (("sample", block.next), ("each", block.per_step)):
        if jump:
            result[role] = _function(block, role, point, [moved(jump)], names, ["x_next"])
    return result


def compiled(table: Mapping[str, ca.Function]) -> dict[str, ca.Function]:
    """Those of the functions that become C: of a large step its stages, since compilers take long for large pieces."""
    small = "stage" not in table or table["stage"].n_instructions() <= _LARGE_STAGE
    return {role: function for role, function in table.items() if role != ("stage" if small else "step")}


def _step(
    block: Block, rhs: ca.Function, t: ca.SX, h: ca.SX, x: ca.SX, p: ca.SX, w: ca.SX, held: Sequence[bool]
) -> ca.Function:
    """One RK4 step; a staged input that the block holds keeps the value of the first stage."""
    stages = ca.SX.sym("staged", len(held), STAGES)
    k, after, outputs = ca.SX(0), x, []
    for i, (node, weight) in enumerate(zip(NODES, WEIGHTS, strict=True)):
        # kᵢ = f(t + cᵢh, x + cᵢh kᵢ₋₁),  x⁺ = x + h Σ bᵢkᵢ
        seen = ca.vertcat(*(stages[j, 0 if keep else i] for j, keep in enumerate(held))) if held else stages[:, i]
        k, y = rhs(t + node * h, x + node * h * k, p, w, seen)
        after = after + h * weight * k
        outputs.append(y)
    return _function(
        block,
        "step",
        [t, h, x, p, w, stages],
        [after, ca.horzcat(*outputs)],
        ["t", "h", "x", "p", "held", "staged"],
        ["x_next", "stages"],
    )


def _function(
    block: Block, role: str, inputs: list[ca.SX], outputs: list[ca.SX], names_in: list[str], names_out: list[str]
) -> ca.Function:
    # without cse each observer's curves are evaluated several times: 2.6 × the instructions
    shared = ca.cse([ca.densify(output) for output in outputs])
    return ca.Function(f"{block.name}_{role}", inputs, shared, names_in, names_out)


def _column(name: str, entries: Sequence[str] | Symbols) -> ca.SX:
    return ca.SX.sym(name, len(entries))
