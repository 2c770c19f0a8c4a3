"""Muscles of a model: the three classes whose curves are here, their sizes, and what of a class is not here."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from ....model.curves import DEGROOTE_FREGLY2016, MILLARD2012, THELEN2003, CurveSet
from ...files.errors import ScenarioError, in_file
from ...files.quote import shown
from ..muscles import Muscle
from .document import Component, listed
from .names import plain, refuse_equal

# no muscle is known without them, and OpenSim always writes them
_SIZES = ("max_isometric_force", "optimal_fiber_length", "tendon_slack_length")
# so near, a model means the number that is fixed here
_EQUAL = 1e-3
# the same with OpenSim's default, for all classes
_V_MAX, _PENNATION = ("max_contraction_velocity", 10.0), ("pennation_angle_at_optimal", 0.0)


@dataclass(frozen=True)
class MuscleClass:
    """A class: its curve set, tags of that one's numbers with OpenSim's defaults, and what is fixed here.

    A tag may be that of an object and one in it, with a slash between. over_strain: what is so many times one over a
    strain here; switches: what must not be true.
    """

    curves: CurveSet
    numbers: Mapping[str, tuple[str, float]]
    fixed: Mapping[str, float]
    switches: Mapping[str, str]
    over_strain: Mapping[str, tuple[float, str]] = field(default_factory=dict)


_RIGID = {"ignore_tendon_compliance": "its tendon is rigid there and elastic here"}
CLASSES: Mapping[str, MuscleClass] = {
    "Thelen2003Muscle": MuscleClass(
        THELEN2003,
        {
            "tendon_strain": ("FmaxTendonStrain", 0.04),
            "passive_strain": ("FmaxMuscleStrain", 0.6),
            "k_PE": ("KshapePassive", 5.0),
            "gamma": ("KshapeActive", 0.45),
            "A_f": ("Af", 0.25),
            "F_len": ("Flen", 1.4),
        },
        {"fv_linear_extrap_threshold": 0.95},
        _RIGID,
    ),
    "Millard2012EquilibriumMuscle": MuscleClass(
        MILLARD2012,
        {
            "tendon_strain": ("TendonForceLengthCurve/strain_at_one_norm_force", 0.049),
            "passive_strain": ("FiberForceLengthCurve/strain_at_one_norm_force", 0.7),
            "damping": ("fiber_damping", 0.1),
        },
        {
            "ActiveForceLengthCurve/min_norm_active_fiber_length": 0.4441,
            "ActiveForceLengthCurve/transition_norm_fiber_length": 0.73,
            "ActiveForceLengthCurve/max_norm_active_fiber_length": 1.8123,
            "ActiveForceLengthCurve/shallow_ascending_slope": 0.8616,
            "ForceVelocityCurve/concentric_slope_near_vmax": 0.25,
            "ForceVelocityCurve/isometric_slope": 5.0,
            "ForceVelocityCurve/eccentric_slope_near_vmax": 0.15,
            "ForceVelocityCurve/max_eccentric_velocity_force_multiplier": 1.4,
            "ForceVelocityCurve/concentric_curviness": 0.6,
            "ForceVelocityCurve/eccentric_curviness": 0.9,
            "FiberForceLengthCurve/strain_at_zero_force": 0.0,
            "FiberForceLengthCurve/stiffness_at_low_force": 0.2,
            "FiberForceLengthCurve/curviness": 0.75,
            "TendonForceLengthCurve/norm_force_at_toe_end": 2 / 3,
            "TendonForceLengthCurve/curviness": 0.5,
        },
        _RIGID,
        {
            "FiberForceLengthCurve/stiffness_at_one_norm_force": (2.0, "passive_strain"),
            "TendonForceLengthCurve/stiffness_at_one_norm_force": (1.375, "tendon_strain"),
        },
    ),
    "DeGrooteFregly2016Muscle": MuscleClass(
        DEGROOTE_FREGLY2016,
        {
            "tendon_strain": ("tendon_strain_at_one_norm_force", 0.049),
            "passive_strain": ("passive_fiber_strain_at_one_norm_force", 0.6),
            "damping": ("fiber_damping", 0.0),
        },
        {"active_force_width_scale": 1.0},
        {**_RIGID, "ignore_passive_fiber_force": "its fibres have no passive force there and have one here"},
    ),
}


def muscles(forces: list[Component]) -> dict[str, Component]:
    """The muscles among forces, of any class. ScenarioError if two have one name."""
    found: dict[str, Component] = {}
    for force in forces:
        if force.element.tag in CLASSES or force.child(_SIZES[0]) is not None:
            if force.name in found:
                raise ScenarioError(f"{force.where}: there is another muscle {shown(force.name)}")
            found[force.name] = force
    return found


def chosen_muscles(forces: list[Component], only: Sequence[str]) -> dict[str, Component]:
    """Those that are asked for, or all, by their names here. ScenarioError if one is missing, or its class not read."""
    found = muscles(forces)
    if not found:
        raise ScenarioError("has no muscles")
    if missing := [name for name in only if name not in found]:
        raise ScenarioError(f"has no muscle {shown(missing[0])}; there are {listed(found)}")
    names = {name: plain(name) for name in found if not only or name in only}
    refuse_equal(names)
    chosen = {here: found[there] for there, here in names.items()}
    for component in chosen.values():
        if component.element.tag not in CLASSES:
            raise ScenarioError(
                f"{component.where}: muscles of this class are not read, but {', '.join(CLASSES)}; "
                "leave it out by naming others with --muscles"
            )
    return chosen


def muscle(component: Component) -> tuple[Muscle, list[str]]:
    """The muscle, and a sentence for each thing that its class has and ours has not. ScenarioError if it cannot be."""
    kind = CLASSES[component.element.tag]
    F_max, optimal_fibre_length, tendon_slack_length = map(component.number, _SIZES)
    numbers = {key: _inner(component, tag, default) for key, (tag, default) in kind.numbers.items()}
    with in_file(component.where):
        read = Muscle(
            kind.curves,
            F_max,
            optimal_fibre_length,
            tendon_slack_length,
            v_max=component.number(*_V_MAX),
            numbers=numbers,
            pennation=component.number(*_PENNATION),
        )
    return read, list(_differences(component, kind, numbers))


def _differences(component: Component, kind: MuscleClass, numbers: Mapping[str, float]) -> Iterator[str]:
    fixed = {**kind.fixed, **{tag: factor / numbers[strain] for tag, (factor, strain) in kind.over_strain.items()}}
    for tag, here in fixed.items():
        if not math.isclose(there := _inner(component, tag, here), here, rel_tol=_EQUAL):
            yield f"{component.name}: {tag} is {there:g} there and {here:g} in {kind.curves.name}"
    for tag, sentence in kind.switches.items():
        if component.flag(tag):
            yield f"{component.name}: {sentence} ({tag})"


def _inner(component: Component, tag: str, default: float) -> float:
    """A number of a component, or of the object in it that stands before the slash."""
    holder, _, own = tag.rpartition("/")
    if not holder:
        return component.number(own, default)
    found = component.child(holder)
    return default if found is None else Component(found).number(own, default)
