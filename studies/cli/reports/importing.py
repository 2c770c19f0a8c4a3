"""What was taken of an OpenSim model, as tables and sentences."""

from __future__ import annotations

import math
from collections.abc import Iterator

from rich.table import Table

from ....model.skeleton.tree import SLIDER, Joint
from ...laboratory.mechanisms.mechanism import Mechanism
from ...laboratory.opensim.document import listed
from ...laboratory.opensim.model import OpenSimModel
from ...laboratory.path_fit.fit import Fitted
from .plain import plain_table

_NONE = "–"
# jumps of a muscle that are named
_FEW = 3


def tables(model: OpenSimModel, mechanism: Mechanism) -> Iterator[Table]:
    """The joints with what they hold, then the muscles."""
    yield plain_table(
        f"{model.name}: joints",
        ("joint", "type", "holds", "coordinate", "range"),
        [
            (
                name,
                _kind(joint),
                f"{joint.parent} → {joint.child}",
                joint.alias or _NONE,
                _range(joint),
            )
            for name, joint in mechanism.tree.joints.items()
        ],
        words=5,
    )
    yield plain_table(
        f"{model.name}: muscles",
        ("muscle", "class", "crosses", "F_max, N", "fibre, mm", "tendon, mm", "pennation, °", "v_max, 1/s"),
        [
            (
                name,
                model.classes[name],
                ", ".join(mechanism.paths[name].joints) or _NONE,
                f"{muscle.F_max:.6g}",
                f"{muscle.optimal_fibre_length * 1e3:.4g}",
                f"{muscle.tendon_slack_length * 1e3:.4g}",
                f"{math.degrees(muscle.pennation):.3g}",
                f"{muscle.v_max:.3g}",
            )
            for name, muscle in mechanism.muscles.items()
        ],
        words=3,
    )


def notes(model: OpenSimModel, mechanism: Mechanism) -> Iterator[str]:
    """What was left out or differs, joints that no muscle moves, and where ranges come from."""
    yield from model.notes
    single = {joint.alias for joint in mechanism.tree.joints.values()}
    if held := [f"{name} = {value:.4g}" for name, value in model.held.items() if name not in single]:
        yield f"held in the frames of their joints: {', '.join(held)}"
    if mechanism.points:
        yield f"markers are points that a simulation may lead: {listed(mechanism.points)}"
    crossed = {joint for path in mechanism.paths.values() for joint in path.joints}
    if free := [name for name in mechanism.tree.free if name not in crossed]:
        yield f"no muscle crosses {', '.join(free)}: lock what does not move, --lock {free[0]}=…"
    if any(mechanism.tree.joints[name].range for name in mechanism.tree.coordinates):
        yield "ranges are those of the model or of --range; lengths are wrong beyond those of the polynomials' fit"


def fit_table(fitted: Fitted) -> Table:
    """How far the polynomials are from the geometry, in mm."""
    coordinates = list(dict.fromkeys(name for fit in fitted.fits for name in fit.arms))
    return plain_table(
        "Fit: root mean square / largest error, mm (moment arms: mm/rad, mm/m)",
        ("muscle", "length", *(f"moment arm of {name}" for name in coordinates)),
        [
            (fit.muscle, _millimetres(fit.length), *(_millimetres(fit.arms.get(name)) for name in coordinates))
            for fit in fitted.fits
        ],
        words=1,
    )


def fit_notes(fitted: Fitted) -> Iterator[str]:
    """Rows that OpenSim has dropped, and where lengths jump."""
    if fitted.used != fitted.points:
        yield (
            f"OpenSim has used {fitted.used:,} of {fitted.points:,} points: where one has no length it drops all later "
            "ones too; narrow the ranges"
        )
    for fit in fitted.fits:
        for jump in fit.jumps[:_FEW]:
            yield (
                f"{fit.muscle} jumps by {jump.size * 1e3:.1f} mm at {jump.coordinate} = {jump.at:.3g}; "
                "no polynomial follows, so choose a --range without"
            )


def _millimetres(errors: tuple[float, float] | None) -> str:
    return _NONE if errors is None else " / ".join(f"{1e3 * error:.2f}" for error in errors)


def _kind(joint: Joint) -> str:
    if joint.locked is not None:
        return f"{joint.kind}, locked at {joint.locked:.4g} {_unit(joint)}"
    return f"{joint.kind}, prescribed" if joint.prescribed else joint.kind


def _range(joint: Joint) -> str:
    if joint.range is None or not joint.moves:
        return _NONE
    low, high = joint.range
    degrees = "" if joint.kind == SLIDER else f" ({math.degrees(low):.0f} … {math.degrees(high):.0f}°)"
    return f"{low:.3g} … {high:.3g} {_unit(joint)}{degrees}"


def _unit(joint: Joint) -> str:
    return "m" if joint.kind == SLIDER else "rad"
