"""The plant of a scenario with its controller, for the observers that meet it in another program."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import casadi as ca

from ...codegen.targets.free_run import Schedule, free_run
from ...codegen.targets.manifest import Manifest
from ...model.block import Block
from ...model.wiring import rename, wire
from ..files.versions import __version__
from ..scenarios.layers import Value
from ..scenarios.prepare import prepare
from . import members

NAME = "plant"


def exported_plant(scenario: str | Path = "paper-clean", changes: Mapping[str, Value] | None = None) -> Manifest:
    """The truth of a scenario and what its sensors measure of it, without noise, with all that a target needs to know.

    All is in the paper's units, a sample each step of the scenario. changes: path → value, such as {"plant.m": 1.2}.
    ScenarioError says what is wrong.
    """
    prepared = prepare(scenario, None, changes or {})
    loop, grid, system = prepared.loop, prepared.grid, prepared.system
    block = _measured(loop.truth, loop.sensors, loop.noise)
    schedule = Schedule(grid.h, dict(zip(loop.pulses, grid.pulses, strict=True)))
    prefix = f"hillobs_{NAME}"
    made = free_run(block, schedule, prefix)
    return Manifest(
        name=NAME,
        prefix=prefix,
        label="Plant",
        sentence=f"{prepared.scenario.name}: {prepared.scenario.description.rstrip('.')}; sensors without noise",
        version=__version__,
        period=grid.h,
        time_unit="",
        substeps=1,
        units=members.ON_PAPER,
        state=members.states(made.states, system),
        params=members.numbers(block.parameters),
        input=(),
        estimate=[*members.signals([*block.y], system), *members.guards(block.guards)],
        guards=len(block.guards),
        defaults=[prepared.value(path) for path in block.p],
        columns=(),
        functions=made.functions,
    )


def _measured(truth: Block, sensors: Block, noise: tuple[str, ...]) -> Block:
    """The truth with what the sensors measure of it, named as paths of a scenario are."""
    connections: dict[str, str | float] = {
        **{f"{truth.name}.{port}": 0.0 if port in noise else port for port in truth.u},
        **{f"{sensors.name}.{port}": 0.0 if port in noise else f"{truth.name}.{port}" for port in sensors.u},
    }
    external = {port: "held" if port in truth.held else "t" for port in truth.u if port not in noise}
    wired = wire(NAME, [truth, sensors], connections, external)
    named = (*wired.x, *wired.y, *wired.p, *wired.guards, *wired.domain)
    bare = {key: key.removeprefix(f"{truth.name}.") for key in named}
    bare |= {f"{sensors.name}.{name}": name for name in sensors.y}
    return _without_unused(rename(wired, NAME, bare))


def _without_unused(block: Block) -> Block:
    """The Block without parameters that nothing depends on."""
    groups = (block.dx, block.next, block.per_step, block.x0, block.y, block.guards, block.domain, block.limits)
    used = {symbol.element_hash() for group in groups for symbol in ca.symvar(group.vector())}
    kept = [name for name, symbol in block.p.items() if symbol.element_hash() in used]
    parameters = {name: block.parameters[name] for name in kept}
    return block.rewritten(lambda entries: entries, p=block.p.only(kept), parameters=parameters)
