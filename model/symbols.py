"""The one table of signals: name in the code, symbol in figures, unit, sentence, equation in the paper."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Signal:
    """What a named number of the model is.

    `tolerance` is the error below which it counts as settled, `size` how much it typically varies.
    """

    name: str
    symbol: str
    sentence: str
    equation: str
    unit: str = "1"
    tolerance: float = float("nan")
    size: float = 1.0


_SIGNALS = (
    Signal("t", r"$\tau$", "time", "paper, §II"),
    Signal("x1", r"$x_1$", "position L_m1 of the mass", "[x1d]", tolerance=2e-3, size=0.01),
    Signal("x2", r"$x_2$", "velocity of the mass, positive to the right", "[x2d]", tolerance=5e-3, size=0.01),
    Signal("x3", r"$x_3$", "length L_S1 of the series elastic element of muscle 1", "[x3d]", tolerance=5e-4, size=0.01),
    Signal("x4", r"$x_4$", "length L_S2 of the series elastic element of muscle 2", "[x4d]", tolerance=5e-4, size=0.01),
    Signal(
        "Delta", r"$\Delta_\Phi$", "bounded uncertainty in the acceleration", "[Deltaphi]", tolerance=5e-3, size=0.01
    ),
    Signal(
        "u1", r"$u_1$", "virtual input of muscle 1: minus its fibre velocity", "[lcdot1]", tolerance=5e-3, size=0.01
    ),
    Signal(
        "u2", r"$u_2$", "virtual input of muscle 2: minus its fibre velocity", "[lcdot2]", tolerance=5e-3, size=0.01
    ),
    Signal("a1", r"$a_1$", "activation of muscle 1", "[z]", tolerance=2e-2, size=0.5),
    Signal("a2", r"$a_2$", "activation of muscle 2", "[z]", tolerance=2e-2, size=0.1),
    Signal("taut1", "taut 1", "1 while tendon 1 carries force, else 0", "[PhiSj]"),
    Signal("taut2", "taut 2", "1 while tendon 2 carries force, else 0", "[PhiSj]"),
    Signal("Phi_S1", r"$\Phi_{S1}$", "force of tendon 1", "[PhiSj]"),
    Signal("Phi_S2", r"$\Phi_{S2}$", "force of tendon 2", "[PhiSj]"),
    Signal("r", r"$r$", "reference of the position", "paper, §V"),
    Signal("y1", r"$y_1$", "measured position", "[y1]"),
    Signal("y2", r"$y_2$", "measured force of tendon 1", "[y2]"),
    Signal("y3", r"$y_3$", "measured force of tendon 2", "[y3]"),
    Signal("l_a", r"$l_a$", "adaptive part of the gain L", "[dotla]"),
    Signal("r_a0", r"$r_{a0}$", "second layer of the gain L", "[dra0]"),
    Signal("k_1", r"$k_1$", "adaptive gain of muscle 1", "[kj]"),
    Signal("r_a1", r"$r_{a1}$", "second layer of the gain k_1", "[draj]"),
    Signal("k_2", r"$k_2$", "adaptive gain of muscle 2", "[kj]"),
    Signal("r_a2", r"$r_{a2}$", "second layer of the gain k_2", "[draj]"),
)

SIGNALS = {signal.name: signal for signal in _SIGNALS}

STATES = ("x1", "x2", "x3", "x4")
MUSCLES = ("muscle1", "muscle2")
# what an observer estimates and every table scores, in this order
QUANTITIES = (*STATES, "Delta", "u1", "u2", "a1", "a2")
MEASURED = ("y1", "y2", "y3")

# what each quantity of the pair is in any system, and whose: `x3` is the tendon length, L_S, of muscle 1
_IN_A_SYSTEM = {
    **{"x1": ("q", "mass"), "x2": ("dq", "mass"), "Delta": ("Delta", "mass")},
    **{"x3": ("L_S", "muscle1"), "u1": ("u", "muscle1"), "a1": ("a", "muscle1")},
    **{"x4": ("L_S", "muscle2"), "u2": ("u", "muscle2"), "a2": ("a", "muscle2")},
}
_LIKE = {kind: name for name, (kind, _) in reversed(_IN_A_SYSTEM.items())}
# symbol and sentence of a signal of any joint or muscle
_OF_ANY = {
    "q": (r"$q$", "coordinate of {}"),
    "dq": (r"$\dot q$", "rate of the coordinate of {}"),
    "Delta": (r"$\Delta$", "acceleration of {} that no tendon makes"),
    "y": (r"$y$", "what is measured of {}"),
    "L_S": ("$L_S$", "tendon length of {}"),
    "u": ("$u$", "how fast the fibres of {} shorten along its tendon"),
    "a": ("$a$", "activation of {}"),
}


def hat(name: str) -> str:
    """The name of the estimate of `name`."""
    return f"{name}_hat"


def kind_of(quantity: str) -> str:
    """What a quantity is, whosever: q, dq, Delta, L_S, u or a."""
    return _IN_A_SYSTEM[quantity][0] if quantity in _IN_A_SYSTEM else quantity.rpartition(".")[2]


def is_quantity(name: str) -> bool:
    """Whether it is called as a quantity of the pair, or of a joint or muscle, is."""
    owner, _, kind = name.rpartition(".")
    return name in _IN_A_SYSTEM or (kind in _LIKE and owner.isidentifier())


def owner_of(quantity: str) -> str:
    """The joint or muscle that a quantity is of."""
    return _IN_A_SYSTEM[quantity][1] if quantity in _IN_A_SYSTEM else quantity.rpartition(".")[0]


def muscle_of(quantity: str) -> str | None:
    """The muscle whose slack tendon makes `quantity` meaningless, or None."""
    return owner_of(quantity) if kind_of(quantity) in ("L_S", "u", "a") else None


def taut_of(muscle: str) -> str:
    """The signal that is 1 while the tendon of a muscle carries force."""
    return f"taut{MUSCLES.index(muscle) + 1}" if muscle in MUSCLES else f"{muscle}.taut"


def signal_of(name: str) -> Signal:
    """A signal of the table, or of a joint or muscle, such as `BRA.L_S`, with the tolerance and size of its kind."""
    if name in SIGNALS:
        return SIGNALS[name]
    owner, _, kind = name.rpartition(".")
    symbol, sentence = _OF_ANY.get(kind, (kind, "{}"))
    like = SIGNALS[_LIKE[kind]] if kind in _LIKE else Signal(kind, kind, "", "")
    return Signal(name, f"{symbol} {owner}", sentence.format(owner), "", like.unit, like.tolerance, like.size)
