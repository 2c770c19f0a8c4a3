"""Trials of a pair whose mass a rig holds and moves, with known activations: another text of the muscles, in SI."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from hillobs.model.arrays import Array
from hillobs.model.curves import CURVES
from hillobs.studies.calibrate.prior import PRIORS
from hillobs.studies.calibrate.trial import Trial
from hillobs.studies.laboratory.muscles import SIZES, Muscle, MusclePair
from hillobs.studies.laboratory.recording import Recording
from random_recordings import (
    PASSIVE_STRAIN,
    TENDON_STRAIN,
    fibre_velocity,
    force_factor,
    passive_force,
    tendon_force,
)

RATE, NOISE_POSITION, NOISE_FORCE = 200.0, 1e-4, 0.005
# s that the rig takes from one length to the next
MOVE = 0.15
# between these, in optimal fibre lengths, every fibre finds its balance
_SHORTEST, _LONGEST = 0.2, 2.2
# activations below which a fibre is as fast as it likes
_RELAXED = 0.02
# far below the noise
_ACCURACY = 1e-9

MUSCLE = Muscle(
    CURVES["degroote_fregly2016"],
    F_max=1000.0,
    optimal_fibre_length=0.1,
    tendon_slack_length=0.2,
    v_max=10.0,
    numbers={"tendon_strain": TENDON_STRAIN, "passive_strain": PASSIVE_STRAIN, "damping": 0.0},
)
PAIR = MusclePair(20.0, 0.66, MUSCLE, MUSCLE)
# of muscle 1, in m: its fibres have 0.67 to 1.51 of their best length, 0.76 to 1.37, and passive ones 0.8 to 1.6
FIVE, THREE, STRETCH = (0.275, 0.295, 0.315, 0.335, 0.36), (0.285, 0.315, 0.345), (0.28, 0.37, 0.28)
MAXIMAL, PASSIVE = {"muscle1": 1.0}, {"muscle1": 0.0, "muscle2": 0.0}


def staircase(positions: Sequence[float], hold: float = 1.0, move: float = MOVE) -> Array:
    """Positions at RATE: each held until `hold` s are over, the last `move` of them on the way to the next."""
    steps = []
    t = np.arange(round(hold * RATE)) / RATE
    for here, there in pairwise([*positions, positions[-1]]):
        s = np.clip((t - (hold - move)) / move, 0, 1)
        # without a jerk
        steps.append(here + (there - here) * s**3 * (10 - 15 * s + 6 * s**2))
    return np.concatenate(steps)


def stretch(positions: Sequence[float] = STRETCH, seconds: float = 10.0) -> Array:
    """Positions at RATE of a slow way there and back."""
    leg = seconds / (len(positions) - 1)
    return staircase(positions, leg, leg)[: -round(leg * RATE)]


def forces(muscle: Muscle, length: Array, a: float) -> Array:
    """Of the tendon, along lengths of the muscle at RATE, from balance on."""
    t, fibre, tendon = np.arange(len(length)) / RATE, muscle.optimal_fibre_length, muscle.tendon_slack_length

    def part(of_fibre: float, whole: float) -> float:
        return tendon_force((whole - fibre * of_fibre) / tendon)

    def balance(of_fibre: float, whole: float) -> float:
        return part(of_fibre, whole) - passive_force(of_fibre) - a * force_factor(of_fibre)

    def at_rest(whole: float) -> float:
        return float(brentq(balance, _SHORTEST, _LONGEST, args=(whole,)))

    def rate(t_: float, state: Sequence[float]) -> list[float]:
        # v = fV⁻¹((fT − fP)/(a fL))
        active = part(state[0], float(np.interp(t_, t, length))) - passive_force(state[0])
        return [muscle.v_max * fibre_velocity(active / (a * force_factor(state[0])))]

    if a > _RELAXED:
        start = [at_rest(length[0])]
        fibres = solve_ivp(rate, (0, t[-1]), start, "LSODA", t, rtol=_ACCURACY, atol=_ACCURACY, max_step=0.01).y[0]
    else:
        fibres = np.array([at_rest(whole) for whole in length])
    return muscle.F_max * np.array([part(*both) for both in zip(fibres, length, strict=True)])


def held(name: str, position: Array, activations: Mapping[str, float], pair: MusclePair = PAIR) -> Recording:
    """A recording without noise; a muscle of which nothing is said is passive."""
    lengths = {"muscle1": position, "muscle2": pair.C - position}
    found = [forces(getattr(pair, of), length, activations.get(of, 0.0)) for of, length in lengths.items()]
    measured = dict(zip(("position", "force_1", "force_2"), (position, *found), strict=True))
    n = len(position)
    return Recording(name, np.arange(n) / RATE, measured, true={}, rows=np.arange(1, n + 1))


def noisy(recording: Recording, seed: int, force: float = NOISE_FORCE) -> Recording:
    """The same with white noise of both sensors."""
    random, n = np.random.default_rng(seed), len(recording)
    sizes = {"position": NOISE_POSITION, "force_1": force * PAIR.muscle1.F_max, "force_2": force * PAIR.muscle2.F_max}
    return recording.remeasured(
        **{name: recording[name] + size * random.normal(size=n) for name, size in sizes.items()}
    )


def trial(recording: Recording, activations: Mapping[str, float], sd: float = 0.0) -> Trial:
    """Levels that are as sure as `sd`."""
    return Trial(recording, activations, dict.fromkeys(activations, sd))


def guessed(seed: int, pair: MusclePair = PAIR) -> MusclePair:
    """The pair with numbers that are off, both muscles alike."""
    muscle1, muscle2 = (wrong(muscle, np.random.default_rng(seed)) for muscle in (pair.muscle1, pair.muscle2))
    return replace(pair, muscle1=muscle1, muscle2=muscle2)


def wrong(muscle: Muscle, random: np.random.Generator) -> Muscle:
    """The muscle with numbers that are off as what is known before says."""
    factors = {name: float(np.exp(part.default * random.normal())) for name, part in PRIORS.items()}
    numbers = {name: value * factors.get(name, 1.0) for name, value in muscle.numbers.items()}
    return replace(muscle, **{name: getattr(muscle, name) * factors[name] for name in SIZES}, numbers=numbers)
