"""What failed, when, and the likely reason, in sentences."""

from __future__ import annotations

from collections.abc import Sequence

from ...codegen.failure import Failure
from ...model.plant import STIFFNESS


def observer_failure(name: str, failure: Failure, at: str, violated: Sequence[str], likely: str) -> str:
    """Of an observer: `violated` names its gain conditions that do not hold; if all do, the reason is `likely`."""
    if failure.group == "domain":
        return f"{name}: {failure.name}, which must stay positive, is not {at}"
    if violated:
        likely = f"gain conditions that do not hold: {', '.join(dict.fromkeys(violated))}"
    return f"{name}: {_beyond(failure, at)}; {likely}"


def plant_failure(failure: Failure) -> str:
    """Of the truth of a simulation."""
    at = f"at τ = {failure.time:g}"
    if failure.name == STIFFNESS:
        return (
            f"the plant: {at} a tendon comes to rest at a rate above {failure.limit:.3g}, faster than the step "
            "resolves; try a smaller step"
        )
    if failure.group != "domain":
        return (
            f"the plant: {_beyond(failure, at)}; the parameters or the reference ask for more than the muscles can give"
        )
    what = "fibre" if "L_C" in failure.name else "tendon"
    if failure.time == 0:
        return f"the plant: it starts outside its domain, the {what} length {failure.name} is not positive"
    return f"the plant: the {what} length {failure.name} reached 0 {at}: the mass is pulled beyond what a muscle can be"


def _beyond(failure: Failure, at: str) -> str:
    return f"{failure.name} is not a number within ±{failure.limit:.3g} {at}"
