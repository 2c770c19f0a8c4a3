"""The truth of a run, one composite: reference, uncertainty, plant, controller. Sensors look at it from outside."""

from __future__ import annotations

from dataclasses import replace

from ..block import Block, Symbols
from ..control.backstepping import backstepping
from ..curves import NGUYEN2019, Curves
from ..limits import limits
from ..plant import plant as plant_of
from ..sensors import SENSED
from ..signals.activations import given_activations
from ..signals.pulses import PULSES, pulses
from ..signals.reference import reference
from ..signals.uncertainty import uncertainty
from ..symbols import QUANTITIES, STATES
from ..system import pair_system
from ..wiring import rename, wire

TAUT = ("taut1", "taut2")
# parameters of these parts are known by other names, signals of those without the part's
_PREFIXES = {"pulses": "", "activations": ""}
_BARE = ("plant", "uncertainty", "reference")


def closed_loop(drive: str = "virtual", curves: Curves = NGUYEN2019, controller: Block | None = None) -> Block:
    """The Block `truth` with the outputs x1…x4, Delta, u1, u2, a1, a2, taut1, taut2, Phi_S1, Phi_S2 (r, if followed).

    Inputs: t and the held gates of the pulses. With the drive `given` there is no controller.
    """
    system = pair_system(curves)
    plant = plant_of(system, drive)
    parts = [uncertainty(), plant]
    connections: dict[str, str | float] = {
        "uncertainty.t": "t",
        "plant.Delta": "uncertainty.Delta",
    }
    held: list[str] = []
    outputs = [*QUANTITIES, *TAUT, *(signal for signal in SENSED if signal not in QUANTITIES)]
    if drive == "given":
        parts.append(given_activations())
        connections |= {"activations.t": "t", "plant.a1": "activations.a1", "plant.a2": "activations.a2"}
    else:
        controller = controller or backstepping(curves)
        parts += [reference(), controller, pulses()]
        held += PULSES
        outputs.append("r")
        connections |= {
            "reference.t": "t",
            **{f"controller.{x}": f"plant.{x}" for x in STATES},
            **{f"controller.{r}": f"reference.{r}" for r in ("r", "dr", "ddr", "dddr")},
            **{f"controller.{d}": f"uncertainty.{d}" for d in ("Delta", "dDelta")},
            "pulses.u1": "controller.u1",
            **{f"pulses.{name}": name for name in PULSES},
            "plant.u1": "pulses.u1",
            "plant.u2": "controller.u2",
        }
    wired = wire("truth", parts, connections, {"t": "t", **dict.fromkeys(held, "held")})
    truth = rename(wired, "truth", _names(wired), outputs)
    numbers = Symbols({"C": truth.p["plant.C"]})
    return replace(truth, limits=limits(system, [*truth.x, *truth.y], numbers))


def _names(wired: Block) -> dict[str, str]:
    """Composite names as the paths of a scenario: `plant.x1` → `x1`, `plant.muscle1.k` → `muscle1.k`, …."""
    names = {}
    for key in wired.p:
        part, _, rest = key.partition(".")
        if part in _PREFIXES:
            names[key] = _PREFIXES[part] + rest
        elif part == "plant" and rest.startswith("muscle"):
            names[key] = rest
    for key in (*wired.x, *wired.y):
        part, _, rest = key.partition(".")
        if part in _BARE:
            names[key] = rest
    return {**names, **{f"plant.{x}_0": f"initial.{x}" for x in STATES}}
