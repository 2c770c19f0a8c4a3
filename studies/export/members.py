"""What the numbers of an export are: units, bounds, sentences."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence

from ...codegen.targets.follower import TIME
from ...codegen.targets.manifest import Member
from ...model.block import Parameter, Parameters
from ...model.limits import ORDERS_OF_JOINT, ORDERS_OF_MUSCLE
from ...model.plant import STIFFNESS
from ...model.symbols import SIGNALS, hat, signal_of
from ...model.system import System
from ..laboratory.scales import Scales

ON_PAPER = (
    "All is in the paper's units: lengths over the optimal fibre length of muscle 1, forces over its largest force, "
    "time τ = v_max t."
)
IN_SI = (
    "What is measured and estimated is in SI. The state and the parameters are in the paper's units: lengths over the "
    "optimal fibre length of the first muscle, forces over its largest force, time τ = v_max t."
)

# unit of a number by name, as a number and as a word; what is not named has none
Units = Mapping[str, tuple[float, str]]

# fibres are lengths too
_ORDERS_OF_MUSCLE = {**ORDERS_OF_MUSCLE, "L_C": 0}
_PER_TIME = ("", "/s", "/s2")
_NO_UNIT = (1.0, "1")


def units(system: System, scales: Scales) -> Units:
    """Those of all that is measured and estimated, in SI."""
    found = dict.fromkeys(system.muscle("y"), (scales.force, "N"))
    of_muscle = dict.fromkeys(system.muscles, (scales.length, "m"))
    lengths = [
        (size, "m" if slides else "rad") for size, slides in zip(scales.coordinates, scales.sliding, strict=True)
    ]
    of_joint = dict(zip(system.joints, lengths, strict=True))
    found |= {system.name("y", joint): unit for joint, unit in of_joint.items()}
    for orders, owners in ((ORDERS_OF_JOINT, of_joint), (_ORDERS_OF_MUSCLE, of_muscle)):
        for (signal, order), (owner, (size, word)) in itertools.product(orders.items(), owners.items()):
            unit = (float(size) * scales.rate**order, word + _PER_TIME[order])
            name = system.name(signal, owner)
            found |= {hat(name): unit, f"{name}_sd": unit}
    return found


def states(names: Iterable[str], system: System) -> list[Member]:
    """Members for the state of an observer, in the paper's units."""
    return [Member(name, _NO_UNIT[1], _said(name, system, f"inner state {name}")) for name in names]


def inputs(names: Iterable[str], system: System, units: Units) -> list[Member]:
    """Members for what is measured."""
    return [Member(name, units.get(name, _NO_UNIT)[1], _said(name, system)) for name in names]


def estimates(names: Iterable[str], system: System, units: Units) -> list[Member]:
    """Members for what is estimated, and for guards."""
    said = {name: _said(name, system, _limit(name)) for name in names}
    bounds = dict.fromkeys(map(hat, system.muscle("a")), ("≥ 0, ≤ 1", 0.0, 1.0))
    return [Member(name, units.get(name, _NO_UNIT)[1], said[name], *bounds.get(name, ())) for name in said]


def signals(names: Sequence[str], system: System) -> list[Member]:
    """Members for what a plant shows, in the paper's units."""
    known = {name: signal_of(name).sentence for name in system.quantities}
    for muscle in system.muscles:
        known[system.name("taut", muscle)] = f"1 while the tendon of {muscle} carries force, else 0"
        known[system.name("Phi_S", muscle)] = f"force of the tendon of {muscle}"
    known |= {name: f"reference of {name.removeprefix('r.')}" for name in names if name.startswith("r.")}
    known[STIFFNESS] = "the largest rate of all tendons, which asks for small steps"
    return [Member(name, _NO_UNIT[1], known.get(name) or _said(name, system, name)) for name in names]


def guards(names: Iterable[str]) -> list[Member]:
    """Members for guards."""
    return [Member(name, _NO_UNIT[1], _limit(name)) for name in names]


def _limit(name: str) -> str:
    return f"1 while the limit {name} is active, else 0"


def numbers(parameters: Parameters) -> list[Member]:
    """Members for the parameters."""
    return [
        Member(
            name,
            about.unit,
            about.sentence,
            _bounds(about),
            max(about.above, about.least),
            min(about.below, about.most),
        )
        for name, about in parameters.items()
    ]


def _bounds(parameter: Parameter) -> str:
    bounds = (
        (parameter.above > -math.inf, f"> {parameter.above:g}"),
        (parameter.least > -math.inf, f"≥ {parameter.least:g}"),
        (parameter.below < math.inf, f"< {parameter.below:g}"),
        (parameter.most < math.inf, f"≤ {parameter.most:g}"),
        (parameter.whole, "whole"),
    )
    return ", ".join(words for given, words in bounds if given)


def _said(name: str, system: System, otherwise: str = "") -> str:
    """What a state, measurement or estimate is; `otherwise` if no table knows it."""
    known = {hat(quantity): f"estimate: {signal_of(quantity).sentence}" for quantity in system.quantities}
    known |= {f"{quantity}_sd": f"standard deviation: {signal_of(quantity).sentence}" for quantity in system.quantities}
    known |= {f"{length}_sd": "standard deviation: fibre length" for length in system.muscle("L_C")}
    known |= {name: signal_of(name).sentence for name in (*system.measured, *SIGNALS)}
    known |= {length: f"tendon length that {force} tells" for length, force in system.tendons.items()}
    known |= {TIME: "time since the first sample"}
    return known.get(name, otherwise)


def sentence_of(system: System) -> str:
    """What an observer of the system does."""
    if system.paper:
        return "estimates of a mass between two muscles, from its position and both tendon forces"
    joints, muscles = ", ".join(system.joints), ", ".join(system.muscles)
    return f"estimates of joints ({joints}) and muscles ({muscles}), from positions and tendon forces"
