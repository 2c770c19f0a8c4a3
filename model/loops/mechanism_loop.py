"""The truth of a run of any system: what disturbs its joints, what drives its muscles, and maybe a controller."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from dataclasses import replace

import casadi as ca

from ..block import STEP, Block, BlockError, Symbols
from ..control.tracking import REFERENCES, tracking
from ..limits import STABLE, limits
from ..plant import DRIVES as OF_THE_PAIR
from ..plant import STIFFNESS
from ..plant import plant as plant_of
from ..signals.activations import signals_of
from ..signals.dynamics import activation_dynamics
from ..signals.reference import reference
from ..signals.uncertainty import uncertainty
from ..system import System
from ..wiring import many, rename, wire
from .start import start, start_parameters

DRIVES = {**OF_THE_PAIR, "excited": "activations that follow excitations given as signals, without a controller"}
_CHOSEN = "chosen, docs/mechanisms.md#simulations"
_GIVEN = {"given": "activation", "excited": "excitation"}


def mechanism_loop(system: System, drive: str, tracked: Sequence[str], rate: float) -> Block:
    """The Block `truth`; its outputs are the quantities of the system, then taut and Phi_S of each muscle.

    tracked: what the controller leads along the reference, with the drives that have one, and r of it is told; rate:
    the unit of times is 1/rate s. Input: t. Parameters are `uncertainty.elbow.offset`, `initial.BRA.a` and so on.
    """
    if drive not in DRIVES:
        raise BlockError(f"unknown drive {drive!r}; valid: {', '.join(DRIVES)}")
    plant = plant_of(system, "given" if drive in _GIVEN else drive)
    parts = [plant]
    connections: dict[str, str | float] = {}
    names = {f"plant.{key}": key for key in (*plant.x, *plant.y, *plant.p, *plant.guards)}

    def add(block: Block, name: str, prefix: str) -> None:
        (part,) = many(block, [name])
        parts.append(part)
        names.update({f"{part.name}.{key}": f"{prefix}.{key}" for key in (*part.p, *part.y)})

    for i, joint in enumerate(system.joints):
        add(uncertainty(0.0, _CHOSEN), f"uncertainty{i}", f"uncertainty.{joint}")
        connections[f"uncertainty{i}.t"] = "t"
        connections[f"plant.{system.name('Delta', joint)}"] = f"uncertainty{i}.Delta"
        names[f"uncertainty{i}.Delta"] = system.name("Delta", joint)
    told = [*system.muscle("taut"), *system.muscle("Phi_S")]
    if drive in _GIVEN:
        signals = signals_of(_GIVEN[drive], system.muscles)
        add(signals, signals.name, signals.name)
        connections[f"{signals.name}.t"] = "t"
        for i, muscle in enumerate(system.muscles):
            source = f"{signals.name}.{muscle}"
            if drive == "excited":
                add(activation_dynamics(rate), f"dynamics{i}", f"dynamics.{muscle}")
                names |= {f"dynamics{i}.a": f"dynamics.{muscle}.a"}
                connections[f"dynamics{i}.e"], source = source, f"dynamics{i}.a"
            connections[f"plant.{system.name('a', muscle)}"] = source
    else:
        controller = tracking(system, tracked)
        parts.append(controller)
        names |= {f"controller.{key}": f"controller.{key}" for key in (*controller.p, *controller.guards)}
        connections |= {f"controller.{state}": f"plant.{state}" for state in system.states}
        for i, joint in enumerate(system.joints):
            connections[f"controller.{system.name('Delta', joint)}"] = f"uncertainty{i}.Delta"
            connections[f"controller.dDelta.{joint}"] = f"uncertainty{i}.dDelta"
        for i, name in enumerate(tracked):
            add(reference(0.0, 0.0, _CHOSEN), f"reference{i}", f"reference.{name}")
            connections[f"reference{i}.t"] = "t"
            connections |= {f"controller.{kind}.{name}": f"reference{i}.{kind}" for kind in REFERENCES}
            names[f"reference{i}.r"] = f"r.{name}"
            told.append(f"r.{name}")
        connections |= {f"plant.{u}": f"controller.{u}" for u in system.muscle("u")}
    wired = wire("truth", parts, connections, {"t": "t"})
    stiff = system.muscle(STIFFNESS) if drive != "virtual" else ()
    truth = rename(wired, "truth", names, [*system.quantities, *told, *stiff])
    truth = _with_largest_stiffness(_starting(truth, system), stiff)
    bounds = limits(system, [*truth.x, *truth.y], truth.p)
    return replace(truth, limits=Symbols({**truth.limits, **bounds}))


def _starting(truth: Block, system: System) -> Block:
    """The same, from where `start` lets it start."""
    told = {f"{state}_0" for state in system.states}
    parameters = {
        **{key: value for key, value in truth.parameters.items() if key not in told},
        **start_parameters(system),
    }
    p = Symbols({key: truth.p.get(key, ca.SX.sym(key)) for key in parameters})
    return replace(truth, p=p, parameters=parameters, x0=Symbols({**truth.x0, **start(system, p)}))


def _with_largest_stiffness(truth: Block, stiff: Sequence[str]) -> Block:
    """`stiffness`, of all tendons the largest; beyond what a step resolves it has failed."""
    if not stiff:
        return truth
    largest = functools.reduce(ca.fmax, [truth.y[name] for name in stiff])
    y = Symbols({**truth.y.only(name for name in truth.y if name not in stiff), STIFFNESS: largest})
    return replace(truth, y=y, limits=Symbols({STIFFNESS: STABLE / STEP}))
