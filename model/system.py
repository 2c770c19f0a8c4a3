"""A system of joints and muscles as observers know it: its signals by name, and what follows from what is measured."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import casadi as ca

from .block import Parameter, Parameters, Symbols, symbols
from .curves import NGUYEN2019, Curves, CurveSet, by_muscle
from .fibre import muscle_parameters
from .skeleton.load import LENGTH, MASS, lengths, pull
from .skeleton.paths import moment_arms
from .symbols import MUSCLES, hat

# of joints and of muscles, in sequence
Expressions = Sequence[ca.SX]


@dataclass(frozen=True, eq=False)  # compared by identity: SX has no usable ==
class System:
    """Joints, measured in position, and muscles, measured in tendon force.

    A joint has the signals q, dq, Delta (acceleration that no tendon makes) and y (measured); a muscle L_S, u, a, L_C,
    taut, Phi_S, y (measured force), z and slope (the tendon's length and slope that this tells). names: (signal, joint
    or muscle) → name, where it is not `elbow.q`, `BRA.L_S`, and so on. pennate: the muscles with oblique fibres.
    """

    joints: tuple[str, ...]
    muscles: tuple[str, ...]
    curves: Mapping[str, CurveSet]
    parameters: Parameters  # that lengths and accelerations take
    lengths: Callable[[Expressions, Symbols], list[ca.SX]]  # L_m of each muscle at coordinates q
    accelerations: Callable[[Expressions, Expressions, Expressions, Symbols], list[ca.SX]]  # by q, dq, forces
    reach: Callable[[str, Symbols], ca.SX | float]  # how far a joint, or how long a muscle, can be
    forces: Callable[[Expressions, Expressions, Symbols], list[ca.SX]]  # that make the accelerations Delta at q
    names: Mapping[tuple[str, str], str] = field(default_factory=dict)
    pennate: frozenset[str] = frozenset()
    places: Callable[[Expressions], Mapping[str, ca.SX]] = lambda q: {}

    @property
    def paper(self) -> bool:
        """Whether it is the paper's pair, whose numbers have the paper's names too."""
        return bool(self.names)

    def name(self, signal: str, of: str) -> str:
        """What a signal of a joint or muscle is called."""
        return self.names.get((signal, of), f"{of}.{signal}")

    def joint(self, signal: str) -> tuple[str, ...]:
        """A signal of all joints."""
        return tuple(self.name(signal, of) for of in self.joints)

    def muscle(self, signal: str) -> tuple[str, ...]:
        """A signal of all muscles."""
        return tuple(self.name(signal, of) for of in self.muscles)

    @functools.cached_property
    def states(self) -> tuple[str, ...]:
        """Positions and velocities joint by joint, then tendon lengths."""
        moving = (self.name(signal, of) for of in self.joints for signal in ("q", "dq"))
        return (*moving, *self.muscle("L_S"))

    @functools.cached_property
    def quantities(self) -> tuple[str, ...]:
        """All that is estimated: states, unknown inputs, activations."""
        return (*self.states, *self.joint("Delta"), *self.muscle("u"), *self.muscle("a"))

    @functools.cached_property
    def measured(self) -> tuple[str, ...]:
        """Positions, then forces."""
        return (*self.joint("y"), *self.muscle("y"))

    @functools.cached_property
    def estimates(self) -> tuple[str, ...]:
        """What an observer estimates: all quantities but the activations, which follow from them."""
        return tuple(hat(name) for name in (*self.states, *self.joint("Delta"), *self.muscle("u")))

    @functools.cached_property
    def tendons(self) -> Mapping[str, str]:
        """Tendon length that a measurement tells → the measured force that tells it."""
        return dict(zip(self.muscle("z"), self.muscle("y"), strict=True))

    def rates(self, q: Expressions, dq: Expressions, p: Symbols) -> list[ca.SX]:
        """L̇_m of each muscle at coordinates q, which must be symbols, and velocities dq."""
        # L̇_m = −Rᵀq̇
        return ca.vertsplit(-moment_arms(ca.vertcat(*self.lengths(q, p)), ca.vertcat(*q)).T @ ca.vertcat(*dq))

    @functools.cached_property
    def length_parameters(self) -> Parameters:
        """Those of its numbers that the muscles' lengths take."""
        p, q = symbols(self.parameters), list(symbols(self.joints).values())
        used = {symbol.name() for symbol in ca.symvar(ca.vertcat(*self.lengths(q, p)))}
        return {name: parameter for name, parameter in self.parameters.items() if name in used}

    @functools.cached_property
    def curve_parameters(self) -> Parameters:
        """`BRA.k` … for all numbers of the muscles, shared by all Blocks that use them."""
        return self._shared({of: muscle_parameters(self.curves[of], of in self.pennate) for of in self.muscles})

    @functools.cached_property
    def tendon_parameters(self) -> Parameters:
        """The same for those of the tendons alone."""
        return self._shared({of: self.curves[of].tendon for of in self.muscles})

    def _shared(self, parameters: Mapping[str, Parameters]) -> dict[str, Parameter]:
        return {
            f"{of}.{key}": replace(parameter, shared=f"{of}.{key}")
            for of, numbers in parameters.items()
            for key, parameter in numbers.items()
        }


# the pair's signals are those of the paper
_PAIR = {
    **{("q", "mass"): "x1", ("dq", "mass"): "x2", ("Delta", "mass"): "Delta", ("y", "mass"): "y1"},
    **{
        (signal, muscle): f"{letter}{j + offset}"
        for j, muscle in enumerate(MUSCLES, start=1)
        for signal, letter, offset in (
            ("L_S", "x", 2),
            ("u", "u", 0),
            ("a", "a", 0),
            ("L_C", "L_C", 0),
            ("taut", "taut", 0),
            ("Phi_S", "Phi_S", 0),
            ("y", "y", 1),
            ("z", "L_S", 0),
            ("slope", "slope", 0),
        )
    },
    # guards
    **{
        (f"{letter}_{limit}", muscle): f"{letter}{j}_{limit}"
        for j, muscle in enumerate(MUSCLES, start=1)
        for letter, limit in (("a", "limit"), ("a", "infeasible"), ("z", "limit"))
    },
}


@functools.cache
def pair_system(curves: Curves) -> System:
    """The paper's pair: a mass on a line between two muscles."""
    return System(
        joints=("mass",),
        muscles=MUSCLES,
        curves=by_muscle(curves),
        parameters={"m": MASS, "C": LENGTH},
        lengths=lambda q, p: lengths(q[0], p.C),
        accelerations=lambda q, dq, F, p: [pull(F) / p.m],
        reach=lambda of, p: p.C,
        forces=lambda q, Delta, p: [p.m * Delta[0]],
        names=_PAIR,
    )


PAIR = pair_system(NGUYEN2019)
