"""Recordings of pairs that are drawn, with their truth: another text of plant, muscles and sensors, in SI.

The curves are those of De Groote, Kinney, Rao and Fregly, Annals of Biomedical Engineering 44, 2016, with OpenSim 4.6's
coefficients; the activation follows an excitation as in Thelen, Journal of Biomechanical Engineering 125, 2003.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

from hillobs.model.arrays import Array
from hillobs.model.curves import CURVES
from hillobs.model.skeleton.paths import constant_moment_arms
from hillobs.model.skeleton.tree import GROUND, SLIDER, Joint, Link, Tree
from hillobs.studies.laboratory.mechanisms.mechanism import Mechanism
from hillobs.studies.laboratory.muscles import Muscle, MusclePair
from hillobs.studies.laboratory.recording import Recording
from hillobs.studies.laboratory.subject import subject_of

KINDS = ("sines", "random", "abrupt")
RATES = (100.0, 200.0, 500.0, 1000.0)
# what is drawn, from and to, evenly in the logarithm: N, m, slack lengths in fibre lengths, 1/s, kg, N/F₀, m, N/F₀
F_MAX, FIBRE, SLACK, V_MAX, MASS = (300.0, 5000.0), (0.03, 0.2), (1.0, 3.0), (6.0, 12.0), (5.0, 80.0)
UNLIKE, PUSH, NOISE_POSITION, NOISE_FORCE = (0.6, 1.6), (0.003, 0.15), (2e-5, 5e-4), (1e-3, 0.02)
# the load in the paper's units, mass · l₀ v_max²/F₀
LOADS = (0.006, 2.7)
# a pair is drawn again if its fibres leave these lengths or velocities, or pull with less: no muscle is used there
LENGTHS, VELOCITIES, LEAST_FORCE = (0.5, 1.6), (-0.9, 1.4), 0.01
# s: until the start is forgotten; of an activation that rises, that falls
_BEFORE, _RISE, _FALL = 2.0, 0.010, 0.040
# far below the least noise, 1e-4 of a length
_ACCURACY = 1e-9

TENDON_STRAIN, PASSIVE_STRAIN = 0.049, 0.6
_K_T = math.log(1.2 / 0.2) / TENDON_STRAIN
_BELLS = (
    (0.8150671134243542, 1.055033428970575, 0.162384573599574, 0.063303448465465),
    (0.433004984392647, 0.71677541339776, -0.029947116970696, 0.200356847296188),
    (0.1, 1.0, 0.353553390593274, 0.0),
)
_D1, _D2, _D3, _D4 = -0.3211346127989808, -8.149, -0.374, 0.8825327733249912
_PASSIVE_0 = math.exp(4 * (0.2 - 1) / PASSIVE_STRAIN)

Signal = Callable[[float], float]


@dataclass(frozen=True)
class Drawn:
    """A recording with its truth, the pair that made it, and what its activations were like."""

    seed: int
    kind: str
    pair: MusclePair
    recording: Recording


def tendon_force(length: float) -> float:
    """Over the tendon's length, in its slack length."""
    # fT = c₁ exp(kT(lT − 1)) − c₃
    return 0.2 * math.exp(_K_T * (length - 1)) - 0.2


def passive_force(length: float) -> float:
    """Over the fibre's length."""
    # fP = (exp(4(l − 1)/e₀) − exp(4(0.2 − 1)/e₀))/(exp(4) − exp(4(0.2 − 1)/e₀))
    return (math.exp(4 * (length - 1) / PASSIVE_STRAIN) - _PASSIVE_0) / (math.exp(4) - _PASSIVE_0)


def force_factor(length: float) -> float:
    """Over the fibre's length."""
    # fL = Σ b₁ exp(−½((l − b₂)/(b₃ + b₄ l))²)
    return sum(b1 * math.exp(-0.5 * ((length - b2) / (b3 + b4 * length)) ** 2) for b1, b2, b3, b4 in _BELLS)


def fibre_velocity(factor: float) -> float:
    """In the largest, positive when the fibre lengthens, over the force factor."""
    # fV = d₁ asinh(d₂v + d₃) + d₄
    return (math.sinh((factor - _D4) / _D1) - _D3) / _D2


def drawn(seed: int, duration: float = 8.0, rates: Sequence[float] = RATES, kinds: Sequence[str] = KINDS) -> Drawn:
    """The recording of a seed, of so many s, at one of the rates in Hz; the same each time."""
    random = np.random.default_rng(seed)
    kind = str(random.choice(kinds))
    while True:
        pair = _pair(random)
        if (truth := _simulated(random, pair, kind, duration, float(random.choice(rates)))) is not None:
            return Drawn(seed, kind, pair, _recorded(random, seed, truth, pair))


def _between(random: np.random.Generator, bounds: tuple[float, float]) -> float:
    return float(np.exp(random.uniform(*np.log(bounds))))


def _pair(random: np.random.Generator) -> MusclePair:
    while True:
        first = [_between(random, bounds) for bounds in (F_MAX, FIBRE, SLACK, V_MAX)]
        mass = _between(random, MASS)
        if LOADS[0] <= mass * first[1] * first[3] ** 2 / first[0] <= LOADS[1]:
            break
    second = [number * _between(random, UNLIKE) for number in first] if random.random() < 0.5 else first
    muscles = [_muscle(*numbers) for numbers in (first, second)]
    # both fibres near their best length, tendons stretched by 2 %
    C = random.uniform(0.9, 1.15) * sum(m.optimal_fibre_length for m in muscles)
    return MusclePair(mass, C + 1.02 * sum(m.tendon_slack_length for m in muscles), *muscles)


def _muscle(force: float, fibre: float, slack: float, v_max: float) -> Muscle:
    numbers = {"tendon_strain": TENDON_STRAIN, "passive_strain": PASSIVE_STRAIN, "damping": 0.0}
    return Muscle(CURVES["degroote_fregly2016"], force, fibre, slack * fibre, v_max, numbers)


def _sum_of_sines(random: np.random.Generator, n: int, slowest: float, fastest: float) -> Signal:
    """With amplitudes that together are 1, between frequencies in Hz."""
    sizes = random.uniform(0.3, 1, n)
    terms = np.stack([sizes / sizes.sum(), 2 * np.pi * random.uniform(slowest, fastest, n), random.uniform(0, 7, n)])
    a, w, phase = (row.tolist() for row in terms)
    return lambda t: sum(a * math.sin(w * t + phase) for a, w, phase in zip(a, w, phase, strict=True))


def _activation(random: np.random.Generator, kind: str) -> Signal:
    middle = random.uniform(0.1, 0.5)
    size = random.uniform(0.3, 0.95) * min(middle, 1 - middle)
    if kind == "random":
        # the more terms, the seldomer all of them meet
        size = min(1.5 * size, 0.98 * middle)
    shape = _sum_of_sines(random, 2, 0.2, 1.2) if kind == "sines" else _sum_of_sines(random, 12, 0.1, 3.0)
    return lambda t: middle + size * shape(t)


def _levels(random: np.random.Generator, until: float) -> tuple[list[float], list[float]]:
    """When an excitation jumps, and to what."""
    times = np.cumsum(random.uniform(0.15, 1.0, int(until / 0.15) + 1))
    return times[times < until].tolist(), random.uniform(0.03, 0.7, len(times) + 1).tolist()


def _simulated(
    random: np.random.Generator, pair: MusclePair, kind: str, duration: float, rate: float
) -> dict[str, Array] | None:
    """Columns of a recording by name, without noise; nothing if the pair leaves what a muscle does."""
    muscles, end = (pair.muscle1, pair.muscle2), _BEFORE + duration
    push = _between(random, PUSH) * pair.muscle1.F_max * random.choice([0, 1, 1])
    shape = _sum_of_sines(random, 3, 0.1, 1.0)
    activations = [_activation(random, kind) for _ in muscles]
    jumps = [_levels(random, end) for _ in muscles]
    abrupt = kind == "abrupt"
    v_max = [m.v_max * m.optimal_fibre_length for m in muscles]

    def inside(t: float, position: float, lengths: Sequence[float], a: Sequence[float]) -> tuple[list[float], ...]:
        """Tendon lengths, their forces, fibre velocities, in SI."""
        both = (position, pair.C - position)
        tendons = [whole - m.optimal_fibre_length * at for whole, m, at in zip(both, muscles, lengths, strict=True)]
        parts = [tendon_force(at / m.tendon_slack_length) for at, m in zip(tendons, muscles, strict=True)]
        # v = fV⁻¹((fT − fP)/(a fL))
        velocities = [
            v * fibre_velocity((part - passive_force(at)) / (level * force_factor(at)))
            for v, part, at, level in zip(v_max, parts, lengths, a, strict=True)
        ]
        return tendons, [m.F_max * part for m, part in zip(muscles, parts, strict=True)], velocities

    def levels(t: float, state: Sequence[float]) -> Sequence[float]:
        return state[4:] if abrupt else [activation(t) for activation in activations]

    def rhs(t: float, state: Sequence[float], excitations: Sequence[float]) -> list[float]:
        state = [float(value) for value in state]
        a = levels(t, state)
        _, (F1, F2), speeds = inside(t, state[0], state[2:4], a)
        rates = [v / m.optimal_fibre_length for v, m in zip(speeds, muscles, strict=True)]
        # ȧ = (e − a)/T,  T = T_rise(½ + 3a/2), or T_fall/(½ + 3a/2)
        moved = [
            (e - at) / (_RISE * (0.5 + 1.5 * at) if e > at else _FALL / (0.5 + 1.5 * at))
            for e, at in zip(excitations, a, strict=True)
        ]
        return [state[1], (F2 - F1 + push * shape(t)) / pair.mass, *rates, *(moved if abrupt else ())]

    def excited(t: float) -> list[float]:
        return [at[int(np.searchsorted(times, t, side="right"))] for times, at in jumps]

    t = _BEFORE + np.arange(round(duration * rate)) / rate
    edges = sorted({0.0, end, *(at for times, _ in jumps for at in times)}) if abrupt else [0.0, end]
    # without force, and at rest
    slack, length = (sum(getattr(m, name) for m in muscles) for name in ("tendon_slack_length", "optimal_fibre_length"))
    start = (pair.C - slack) / length
    state = [pair.muscle1.tendon_slack_length + start * pair.muscle1.optimal_fibre_length, 0.0, start, start]
    state += [at[0] for _, at in jumps] if abrupt else []

    def left(t: float, state: Sequence[float], excitations: Sequence[float]) -> float:
        return min(*(at - LENGTHS[0] for at in state[2:4]), *(LENGTHS[1] - at for at in state[2:4]))

    left.terminal = True
    pieces = []
    for first, last in pairwise(edges):
        here = t[(first <= t) & (t < last)]
        solved = solve_ivp(
            rhs,
            (first, last),
            state,
            "LSODA",
            [*here, last],
            events=left,
            args=(excited(first),),
            rtol=_ACCURACY,
            atol=_ACCURACY,
        )
        if solved.status:
            return None
        state = solved.y[:, -1].tolist()
        pieces.append(solved.y[:, :-1])
    x = np.concatenate(pieces, axis=1)
    a = np.array([levels(at, state) for at, state in zip(t, x.T.tolist(), strict=True)]).T
    tendons, forces, velocities = np.array(
        [inside(at, *split) for at, split in zip(t, zip(x[0], x[2:4].T, a.T, strict=True), strict=True)]
    ).transpose(1, 2, 0)
    parts, speeds = forces.T / [m.F_max for m in muscles], velocities.T / v_max
    if parts.min() < LEAST_FORCE or speeds.min() < VELOCITIES[0] or speeds.max() > VELOCITIES[1]:
        return None
    disturbance = push * np.array([shape(at) for at in t])
    columns = {"time": t - _BEFORE, "position": x[0], "velocity": x[1], "disturbance": disturbance}
    for j, m in enumerate(muscles, start=1):
        columns |= {f"force_{j}": forces[j - 1], f"tendon_length_{j}": tendons[j - 1], f"activation_{j}": a[j - 1]}
        columns |= {f"fibre_length_{j}": m.optimal_fibre_length * x[j + 1], f"fibre_velocity_{j}": velocities[j - 1]}
    return columns


def _recorded(random: np.random.Generator, seed: int, truth: dict[str, Array], pair: MusclePair) -> Recording:
    """With noise of both sensors, white and normal."""
    n, sigma, part = len(truth["time"]), _between(random, NOISE_POSITION), _between(random, NOISE_FORCE)
    noise = (
        random.normal(size=(3, n)) * np.array([sigma, *(part * m.F_max for m in (pair.muscle1, pair.muscle2))])[:, None]
    )
    measured = dict(zip(("position", "force_1", "force_2"), noise, strict=True))
    known = {name: values for name, values in truth.items() if name != "time"}
    return Recording(
        f"drawn {seed}",
        truth["time"],
        {name: truth[name] + values for name, values in measured.items()},
        true=known,
        rows=np.arange(1, n + 1),
    )


def as_mechanism(one: Drawn) -> tuple[Recording, Mechanism]:
    """The same recording of a slider between two muscles A and B of the lengths q and C − q."""
    pair, recording = one.pair, one.recording
    tree = Tree({"block": Link(pair.mass)}, {"x": Joint(GROUND, "block", SLIDER, (1.0, 0.0, 0.0), range=(0.0, pair.C))})
    paths = {"A": constant_moment_arms(0.0, {"x": -1.0}), "B": constant_moment_arms(pair.C, {"x": 1.0})}
    mechanism = Mechanism(tree, {"A": pair.muscle1, "B": pair.muscle2}, paths)

    def renamed(columns: Mapping[str, Array]) -> dict[str, Array]:
        """`force_1` as `force_A`, `position` as `position_x`."""
        ends = {"1": "A", "2": "B"}
        parts = {name: name.rpartition("_") for name in columns}
        return {
            f"{stem}_{ends[end]}" if end in ends else f"{name}_x": columns[name]
            for name, (stem, _, end) in parts.items()
        }

    measured, true = renamed(recording.measured), renamed(recording.true)
    columns = subject_of(mechanism).columns
    return replace(recording, measured=measured, true=true, columns=columns), mechanism
