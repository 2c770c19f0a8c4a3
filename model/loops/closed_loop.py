"""The truth of a run, one composite: reference, uncertainty, plant, controller. Sensors look at it from outside."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from ..block import Block, Symbols
from ..control.backstepping import backstepping
from ..curves import NGUYEN2019, Curves
from ..limits import limits
from ..plant import plant as plant_of
from ..sensors import NOISE_CHANNELS, SENSED
from ..signals.activations import given_activations
from ..signals.pulses import PULSES, pulses
from ..signals.reference import reference
from ..signals.uncertainty import uncertainty
from ..symbols import QUANTITIES, STATES, hat
from ..system import pair_system
from ..wiring import rename, wire

TAUT = ("taut1", "taut2")
# what the controller takes for Δ and Δ̇: the truth, an estimate that it takes for constant, or both estimates
KNOWN = {"Delta": "uncertainty.Delta", "dDelta": "uncertainty.dDelta"}
ESTIMATED: Mapping[str, str | float] = {"Delta": f"eyes.{hat('Delta')}", "dDelta": 0.0}
ESTIMATED_WITH_RATE = {"Delta": f"eyes.{hat('Delta')}", "dDelta": f"eyes.{hat('dDelta')}"}
# parameters of these parts, and signals of those, are known without the part's name
_PLAIN = ("pulses", "activations", "eyes")
_BARE = ("plant", "uncertainty", "reference")


def closed_loop(
    drive: str = "virtual",
    curves: Curves = NGUYEN2019,
    controller: Block | None = None,
    eyes: Block | None = None,
    Delta: Mapping[str, str | float] = KNOWN,
) -> Block:
    """The Block `truth` with the outputs x1…x4, Delta, u1, u2, a1, a2, taut1, taut2, Phi_S1, Phi_S2 (r, if followed).

    Inputs: t and the held gates of the pulses. With the drive `given` there is no controller. eyes: what the controller
    sees instead of the states (observers/feedback.py), with the held noise as further inputs. Delta: what it takes for
    Δ and Δ̇, the truth by default.
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
            **{f"controller.{name}": source for name, source in Delta.items()},
            "pulses.u1": "controller.u1",
            **{f"pulses.{name}": name for name in PULSES},
            "plant.u1": "pulses.u1",
            "plant.u2": "controller.u2",
        }
        if eyes is not None:
            parts.append(eyes)
            held += NOISE_CHANNELS
            connections |= {
                **{f"eyes.{port}": f"plant.{port}" for port in SENSED},
                **{f"eyes.{channel}": channel for channel in NOISE_CHANNELS},
                **{f"controller.{x}": f"eyes.{hat(x)}" for x in STATES},
                "eyes.t": "t",
            }
    wired = wire("truth", parts, connections, {"t": "t", **dict.fromkeys(held, "held")})
    truth = rename(wired, "truth", _names(wired), outputs)
    numbers = Symbols({"C": truth.p["plant.C"]})
    own = limits(system, [*truth.x, *truth.y], numbers)
    return replace(truth, limits=Symbols({**truth.limits, **own}))


def _names(wired: Block) -> dict[str, str]:
    """Composite names as the paths of a scenario: `plant.x1` → `x1`, `plant.muscle1.k` → `muscle1.k`, …."""
    names = {}
    for key in wired.p:
        part, _, rest = key.partition(".")
        if part in _PLAIN or (part == "plant" and rest.startswith("muscle")):
            names[key] = rest
    for key in (*wired.x, *wired.y):
        part, _, rest = key.partition(".")
        if part in _BARE:
            names[key] = rest
    names |= {key: key.removeprefix("eyes.") for key in wired.guards}
    return {**names, **{f"plant.{x}_0": f"initial.{x}" for x in STATES}}
