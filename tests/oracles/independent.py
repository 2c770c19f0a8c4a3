"""Plant, controller, three observers, noise and measures in plain NumPy and SciPy: the oracle of the tests.

Written from the equations alone; imports nothing of the package and shares no code with it. Arrays carry the muscles
(2) or the states (31) on the first axis and any number of runs or time points behind it. Parameters are a flat dict of
paths, e.g. {"plant.m": 1.1, "high_gain.m": 1.0, "muscle1.k": 17.0}; what is not given keeps the paper's value.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
Parameters = Mapping[str, Any]
Signal = Callable[[Any], tuple[Any, ...]]

OBSERVERS = ("high_gain", "sliding_mode", "adaptive_sliding_mode")
QUANTITIES = ("x1", "x2", "x3", "x4", "Delta", "u1", "u2", "a1", "a2")
TOLERANCES = (2e-3, 5e-3, 5e-4, 5e-4, 5e-3, 5e-3, 5e-3, 2e-2, 2e-2)  # of the settling time
ADAPTIVE = ("l_a", "r_a0", "k_1", "r_a1", "k_2", "r_a2")
STATES = (
    "x1", "x2", "x3", "x4",
    *(f"{o}.{s}_hat" for o in OBSERVERS for s in ("x1", "x2", "Delta", "x3", "u1", "x4", "u2")),
    *(f"adaptive_sliding_mode.{s}" for s in ADAPTIVE),
)  # fmt: skip

# ---------------------------------------------------------------- parameters

PAPER: dict[str, Any] = {
    "plant.m": 1.0, "plant.C": 5.54, "plant.drive": "virtual", "plant.a_min": 0.01,
    "muscle.W": 0.3, "muscle.A_hill": 0.25, "muscle.g_max": 1.5,
    "muscle.L_slack": 2.0, "muscle.toe": 0.04, "muscle.F_toe": 0.5, "muscle.k": 19.2308,
    "reference.offset": 2.6315, "reference.amplitude": 0.01, "reference.frequency": 0.5,
    "uncertainty.offset": 0.005, "uncertainty.amplitude": 0.005, "uncertainty.frequency": 0.8,
    "controller.gamma": 1.0, "controller.q": 10.0, "controller.R": 30.0,
    "controller.k_c": 0.0, "controller.F_c": 0.2, "controller.u_max": 0.9,
    "noise.x1": 0.0, "noise.force": 0.0, "noise.drift": 0.0, "noise.period": 0.005,
    "pulse.amplitude": (), "pulse.start": (), "pulse.stop": (),
    "activation1.offset": 0.35, "activation1.amplitude": 0.1, "activation1.frequency": 1.0,
    "activation2.offset": 0.35, "activation2.amplitude": -0.1, "activation2.frequency": 1.0,
    "high_gain.eps_h": 0.1, "high_gain.h11": 3.0, "high_gain.h12": 3.0, "high_gain.h13": 1.0,
    "high_gain.h21": 2.0, "high_gain.h22": 1.0, "high_gain.h31": 2.0, "high_gain.h32": 1.0,
    "sliding_mode.alpha11": 1.1, "sliding_mode.lambda11": 28.17, "sliding_mode.alpha2": 1.1,
    "sliding_mode.alpha3": 1.0, "sliding_mode.tau_s": 0.01, "sliding_mode.delta_s": 0.01,
    "adaptive_sliding_mode.alpha0": 2 * np.sqrt(2 * 1.1), "adaptive_sliding_mode.beta0": 1.1,
    "adaptive_sliding_mode.eta1": 0.2, "adaptive_sliding_mode.eta2": 0.2, "adaptive_sliding_mode.a_dual": 0.82,
    "adaptive_sliding_mode.l0": 0.4, "adaptive_sliding_mode.r00": 0.4,
    "adaptive_sliding_mode.r01": 0.5, "adaptive_sliding_mode.r02": 0.5, "adaptive_sliding_mode.tau_a": 0.01,
    "adaptive_sliding_mode.eps_a0": 0.2, "adaptive_sliding_mode.eps_a1": 0.2, "adaptive_sliding_mode.eps_a2": 0.2,
    "adaptive_sliding_mode.alpha_a1": 0.99, "adaptive_sliding_mode.alpha_a2": 0.99,
    "adaptive_sliding_mode.gamma_a0": 200.0, "adaptive_sliding_mode.gamma_a1": 300.0,
    "adaptive_sliding_mode.gamma_a2": 300.0, "adaptive_sliding_mode.delta00": 0.001,
    "adaptive_sliding_mode.delta01": 0.001, "adaptive_sliding_mode.delta02": 0.001,
    "adaptive_sliding_mode.delta_a": 0.01, "adaptive_sliding_mode.L_min": 0.05,
    "adaptive_sliding_mode.k_max": 10.0, "adaptive_sliding_mode.r_max": 20.0, "adaptive_sliding_mode.leak": 0.0,
    "initial.x1": 2.60, "initial.x2": 0.0, "initial.x3": 2.018, "initial.x4": 2.018,
    "initial.x1_hat": 2.62, "initial.x2_hat": 0.0, "initial.x3_hat": 2.01, "initial.x4_hat": 2.01,
    "duration": 20.0, "step": 5e-4, "record": 0.01, "score.start": 2.0,
}  # fmt: skip

NOISE = {"noise.x1": 0.001, "noise.force": 0.001, "noise.drift": 0.001}
CHALLENGE = {
    **NOISE, "controller.k_c": 5.0, "reference.offset": 2.77, "reference.amplitude": 0.05, "reference.frequency": 2.0,
    "uncertainty.offset": 0.01, "uncertainty.amplitude": 0.03, "uncertainty.frequency": 1.3, "initial.x1": 2.75,
    "initial.x2": 0.1, "initial.x3": 2.0225, "initial.x4": 2.0225, "initial.x1_hat": 2.77,
}  # fmt: skip
SCENARIOS: dict[str, dict[str, Any]] = {
    "paper-clean": {},
    "paper-noisy": NOISE,
    "challenge": CHALLENGE,
    "slack": {**NOISE, "pulse.amplitude": (-0.065, 0.065), "pulse.start": (5.0, 7.0), "pulse.stop": (6.0, 8.0)},
    "slack-deep": {**CHALLENGE, "controller.k_c": 0.0, "reference.frequency": 1.0},
}  # fmt: skip


def value(p: Parameters, path: str, consumer: str = "") -> Any:
    """The consumer's own value if it has one, else the tied one; `plant.m` and `muscle.W` are the tied names."""
    name = path.split(".")[-1]
    group = path.split(".")[0]
    candidates = [path]
    if group[:6] == "muscle":
        candidates = [f"{group}.{name}", f"muscle.{name}"]
        if consumer:
            candidates = [f"{consumer}.{group}.{name}", f"{consumer}.muscle.{name}", f"{consumer}.{name}", *candidates]
    elif consumer:
        candidates = [f"{consumer}.{name}", path]
    for source in (p, PAPER):
        for candidate in candidates:
            if candidate in source:
                return source[candidate]
    raise KeyError(path)


# ---------------------------------------------------------------- muscle


@dataclass(frozen=True)
class Curves:
    """Constants of one muscle, or of both as columns of shape (2, 1)."""

    W: Any = 0.3
    A_hill: Any = 0.25
    g_max: Any = 1.5
    L_slack: Any = 2.0
    toe: Any = 0.04
    F_toe: Any = 0.5
    k: Any = 19.2308

    @cached_property
    def quintic(self) -> tuple[Any, Any, Any]:
        F, D = self.F_toe, self.toe * self.k
        return 10 * F - 4 * D, -15 * F + 7 * D, 6 * F - 3 * D


def curves_of(p: Parameters, consumer: str) -> Curves:
    """Both muscles' curves as this consumer sees them."""
    return Curves(
        **{
            name: np.array([[value(p, f"muscle{j}.{name}", consumer)] for j in (1, 2)])
            for name in ("W", "A_hill", "g_max", "L_slack", "toe", "F_toe", "k")
        }
    )


def Phi_S(L: Any, c: Curves = Curves()) -> Any:
    A3, A4, A5 = c.quintic
    s = (np.asarray(L, float) - c.L_slack) / c.toe
    # [PhiSj] Φ_S = 0 | s³(A₃ + s(A₄ + s A₅)) | F + k (L − L_slack − toe)
    return np.where(s < 0, 0.0, np.where(s < 1, s**3 * (A3 + s * (A4 + s * A5)), c.F_toe + c.k * c.toe * (s - 1)))


def dPhi_S(L: Any, c: Curves = Curves()) -> Any:
    A3, A4, A5 = c.quintic
    s = (np.asarray(L, float) - c.L_slack) / c.toe
    # Φ′_S = 0 | s²(3A₃ + s(4A₄ + 5s A₅))/toe | k
    return np.where(s < 0, 0.0, np.where(s < 1, s**2 * (3 * A3 + s * (4 * A4 + s * 5 * A5)) / c.toe, c.k))


def Phi_S_inv(y: Any, c: Curves = Curves()) -> Any:
    """Newton's method in s to the last bit; where it does not settle (unusual constants), bisection."""
    y = np.asarray(y, float)
    A3, A4, A5 = c.quintic
    B3, B4, B5 = 3 * A3, 4 * A4, 5 * A5
    inside = np.minimum(np.maximum(y, 1e-300), c.F_toe)
    s = np.minimum(np.maximum(np.cbrt(inside / A3), 1e-100), 1.0)
    with np.errstate(all="ignore"):
        for _ in range(12):
            # F(s) = s³(A₃ + s(A₄ + s A₅)) − y = 0,   s ← s − F/F′
            step = (s * (A3 + s * (A4 + s * A5)) - inside / (s * s)) / (B3 + s * (B4 + s * B5))
            s = s - step
            if abs(step).max() < 1e-15:
                break
        else:
            low, high = np.zeros_like(s), np.ones_like(s)
            for _ in range(60):
                s = (low + high) / 2
                below = s**3 * (A3 + s * (A4 + s * A5)) < inside
                low, high = np.where(below, s, low), np.where(below, high, s)
    # Φ_S⁻¹: y ≤ 0 → L_slack;  0 < y < F → the root;  y ≥ F → linear
    linear = c.L_slack + c.toe + (y - c.F_toe) / c.k
    return np.where(y <= 0, c.L_slack, np.where(y < c.F_toe, c.L_slack + c.toe * s, linear))


def Phi_P(L_C: Any) -> Any:
    # [PhiPj] Φ_P = 8 max(L_C − 1, 0)³
    return 8 * np.maximum(np.asarray(L_C, float) - 1, 0) ** 3


def f(L_C: Any, c: Curves = Curves()) -> Any:
    # [fj] f = exp(−((L_C − 1)/W)²)
    return np.exp(-(((np.asarray(L_C, float) - 1) / c.W) ** 2))


def g_inv(z: Any, c: Curves = Curves()) -> Any:
    z = np.asarray(z, float)
    A, G = c.A_hill, c.g_max
    with np.errstate(divide="ignore", invalid="ignore"):
        # [gj] z ≤ 1: (1 − z)/(1 + z/A);  z > 1: −A(z − 1)(g_max − 1)/((A + 1)(g_max − z))
        return np.where(z <= 1, (1 - z) / (1 + z / A), -A * (z - 1) * (G - 1) / ((A + 1) * (G - z)))


def g(u: Any, c: Curves = Curves()) -> Any:
    u = np.asarray(u, float)
    A, G, v = c.A_hill, c.g_max, -u
    with np.errstate(divide="ignore", invalid="ignore"):
        # [gj]⁻¹ u ≥ 0: (1 − u)/(1 + u/A);  v = −u > 0: (v(A+1)g_max + A(g_max−1))/(A(g_max−1) + v(A+1))
        return np.where(u >= 0, (1 - u) / (1 + u / A), (v * (A + 1) * G + A * (G - 1)) / (A * (G - 1) + v * (A + 1)))


def fibres(x1: Any, x34: Any, C: float) -> Any:
    # L_C1 = x₁ − x₃, L_C2 = C − x₁ − x₄
    return np.stack([x1, C - x1]) - x34


def activation(x1: Any, x34: Any, u: Any, C: float, c: Curves) -> Any:
    L_C = fibres(x1, x34, C)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        # [z] a_j = (Φ_S(x_{j+2}) − Φ_P(L_Cj))/(g(u_j) f(L_Cj))
        return (Phi_S(x34, c) - Phi_P(L_C)) / (g(u, c) * f(L_C, c))


# ---------------------------------------------------------------- sensor noise

# Random123 (Salmon, Moraes, Dror, Shaw, SC 2011), file tests/kat_vectors, generator philox4x32, 10 rounds
PHILOX_VECTORS = (
    ((0, 0, 0, 0), (0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    ((0xFFFFFFFF,) * 4, (0xFFFFFFFF,) * 2, (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
    ((0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344), (0xA4093822, 0x299F31D0),
     (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1)),
)  # fmt: skip


def philox4x32(counter: Sequence[Any], key: Sequence[Any]) -> tuple[NDArray[np.uint32], ...]:
    """Philox4x32-10 for arrays of counters and keys."""
    M0, M1, low = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57), np.uint64(0xFFFFFFFF)
    c0, c1, c2, c3, k0, k1 = np.broadcast_arrays(*(np.asarray(w, np.uint64) for w in (*counter, *key)))
    for _ in range(10):
        p0, p1 = M0 * c0, M1 * c2  # 32 × 32 → 64 bits
        c0, c1, c2, c3 = (p1 >> np.uint64(32)) ^ c1 ^ k0, p1 & low, (p0 >> np.uint64(32)) ^ c3 ^ k1, p0 & low
        k0, k1 = (k0 + np.uint64(0x9E3779B9)) & low, (k1 + np.uint64(0xBB67AE85)) & low
    return tuple(w.astype(np.uint32) for w in (c0, c1, c2, c3))


def uniform(seed: Any, channel: Any, sample: Any) -> Array:
    """U(−1, 1] of a seed, a channel (0: x1, 1: force 1, 2: force 2) and a sample's index; the arguments broadcast."""
    seed = np.asarray(seed, np.uint64)
    key = (seed & np.uint64(0xFFFFFFFF), seed >> np.uint64(32))
    w0, w1, _, _ = philox4x32((sample, channel, 0, 0), key)
    # U = 2((w₀ ≫ 5)·2²⁶ + (w₁ ≫ 6) + ½)/2⁵³ − 1
    return 2 * ((w0 >> np.uint32(5)) * 2.0**26 + (w1 >> np.uint32(6)) + 0.5) / 2.0**53 - 1


def sensor_noise(p: Parameters, seeds: Sequence[int], samples: int) -> Array:
    """What is added to (y₁, y₂, y₃): shape (samples, 3, seeds)."""
    U = uniform(np.asarray(seeds, np.uint64), np.arange(3)[:, None], np.arange(samples)[:, None, None])
    # ν = (n_x U₀, drift + n_F U₁, drift + n_F U₂)
    scale = np.array([value(p, "noise.x1"), value(p, "noise.force"), value(p, "noise.force")])
    return np.array([0.0, 1.0, 1.0])[:, None] * value(p, "noise.drift") + scale[:, None] * U


# ---------------------------------------------------------------- signals


def sine_reference(p: Parameters) -> Signal:
    o, a, w = (value(p, f"reference.{n}") for n in ("offset", "amplitude", "frequency"))
    # r = offset + amplitude sin ωτ, and ṙ, r̈, r‴
    return lambda t: (
        o + a * np.sin(w * t),
        a * w * np.cos(w * t),
        -a * w**2 * np.sin(w * t),
        -a * w**3 * np.cos(w * t),
    )


def sine_uncertainty(p: Parameters) -> Signal:
    o, a, w = (value(p, f"uncertainty.{n}") for n in ("offset", "amplitude", "frequency"))
    # [DeltaPhi] Δ_Φ = offset + amplitude sin ωτ, and Δ̇_Φ
    return lambda t: (o + a * np.sin(w * t), a * w * np.cos(w * t))


def sine_activations(p: Parameters) -> Signal:
    (o1, a1, w1), (o2, a2, w2) = (
        [value(p, f"activation{j}.{n}") for n in ("offset", "amplitude", "frequency")] for j in (1, 2)
    )
    # a_j = offset + amplitude sin ωτ
    return lambda t: (o1 + a1 * np.sin(w1 * t), o2 + a2 * np.sin(w2 * t))


def pulses(p: Parameters, h: float, steps: Any) -> Array:
    """The pulse on u₁ during each step: constant over a step, edges in whole steps."""
    k, total = np.asarray(steps), np.zeros(np.shape(steps))
    edges = (np.atleast_1d(np.asarray(value(p, f"pulse.{n}"), float)) for n in ("amplitude", "start", "stop"))
    for amplitude, start, stop in zip(*edges, strict=True):
        total = total + amplitude * ((k >= round(start / h)) & (k < round(stop / h)))
    return total


# ---------------------------------------------------------------- right-hand side


def lqr(m: float, q: float, R: float) -> tuple[Array, Array]:
    """K and P of the double integrator with B = (0, 1/m), Q = q I."""
    # p₁₂ = m√(qR), p₂₂ = m√(R(q + 2p₁₂)), p₁₁ = p₁₂p₂₂/(m²R), K = (p₁₂, p₂₂)/(mR)
    p12 = m * np.sqrt(q * R)
    p22 = m * np.sqrt(R * (q + 2 * p12))
    return np.array([p12, p22]) / (m * R), np.array([[p12 * p22 / (m**2 * R), p12], [p12, p22]])


class Model:
    """The equations for one set of parameters; `rhs` is the derivative of all 31 states."""

    def __init__(
        self,
        parameters: Parameters,
        reference: Signal | None = None,
        uncertainty: Signal | None = None,
        activations: Signal | None = None,
    ):
        p = self.p = dict(parameters)
        self.reference = reference or sine_reference(p)
        self.uncertainty = uncertainty or sine_uncertainty(p)
        self.activations = activations or sine_activations(p)
        who = ("plant", "controller", *OBSERVERS)
        self.m = {c: value(p, "plant.m", c) for c in who}
        self.C = {c: value(p, "plant.C", c) for c in who}
        self.curves = {c: curves_of(p, c) for c in who}
        self.same = {  # observers whose tendon curves are the plant's: one inversion serves all
            c: all(np.array_equal(getattr(self.curves[c], n), getattr(self.curves["plant"], n)) for n in vars(Curves()))
            for c in who
        }
        self.drive = value(p, "plant.drive")
        self.a_min = value(p, "plant.a_min")
        self.gamma, self.k_c, self.F_c, self.u_max = (
            value(p, f"controller.{n}") for n in ("gamma", "k_c", "F_c", "u_max")
        )
        self.K, self.P = lqr(self.m["controller"], value(p, "controller.q"), value(p, "controller.R"))
        self.hg, self.sm, self.asm = (
            {k.split(".")[1]: value(p, k) for k in PAPER if k.startswith(o + ".")} for o in OBSERVERS
        )
        column = lambda d, *names: np.array([[d[n]] for n in names])  # noqa: E731
        self.h_1 = column(self.hg, "h21", "h31")
        self.h_2 = column(self.hg, "h22", "h32")
        self.alpha_23 = column(self.sm, "alpha2", "alpha3")
        self.eta, self.r0, self.eps, self.alpha, self.gam, self.dead = (
            column(self.asm, n + "1", n + "2") for n in ("eta", "r0", "eps_a", "alpha_a", "gamma_a", "delta0")
        )

    def start(self) -> Array:
        """The 31 states at τ = 0."""
        hat = [value(self.p, f"initial.x{i}_hat") for i in (1, 2, 3, 4)]
        observer = [hat[0], hat[1], 0.0, hat[2], 0.0, hat[3], 0.0]
        return np.array([*(value(self.p, f"initial.x{i}") for i in (1, 2, 3, 4)), *observer * 3, 0, 0, 0.2, 0, 0.2, 0])

    def control(self, t: Any, x: Any) -> Array:
        """The backstepping controller on the true states."""
        m, c, K = self.m["controller"], self.curves["controller"], self.K
        r, dr, ddr, dddr = self.reference(t)
        D, dD = self.uncertainty(t)
        F, dF = Phi_S(x[2:4], c), dPhi_S(x[2:4], c)
        # e = (x₁ − r, x₂ − ṙ),   ζ = Φ_S(x₄) − Φ_S(x₃) + mΔ_Φ − m r̈
        e1, e2 = x[0] - r, x[1] - dr
        zeta = F[1] - F[0] + m * D - m * ddr
        # K₁ = γ + KB,   K₂ = KA + γK + BᵀP
        K1 = self.gamma + K[1] / m
        K2 = np.array([0.0, K[0]]) + self.gamma * K + self.P[1] / m
        # [beta] β = −K₁ζ − K₂e + (Φ′_S1 + Φ′_S2) x₂ − mΔ̇_Φ + m r‴
        beta = -K1 * zeta - K2[0] * e1 - K2[1] * e2 + (dF[0] + dF[1]) * x[1] - m * dD + m * dddr
        # Δ = max(Φ′²_S1 + Φ′²_S2, 1e−9)
        det = np.maximum(dF[0] ** 2 + dF[1] ** 2, 1e-9)
        # u₁ = −Φ′_S1 β/Δ,   u₂ = Φ′_S2 β/Δ
        u = np.stack([-dF[0] * beta / det, dF[1] * beta / det])
        # u += k_c (F_c − (Φ_S1 + Φ_S2)/2)/Δ · (Φ′_S2, Φ′_S1)
        u = u + self.k_c * (self.F_c - (F[0] + F[1]) / 2) / det * dF[::-1]
        # |u_j| ≤ u_max
        return np.clip(u, -self.u_max, self.u_max)

    def drives(self, t: Any, x: Any, pulse: Any = 0.0) -> tuple[Array, Array, Array]:
        """u of the plant with the pulse on u₁; the activation put in, NaN for the virtual drive; the limits' flags."""
        if self.drive == "virtual":
            u, a, flags = self.control(t, x), np.full(np.shape(x[2:4]), np.nan), np.zeros((4, *x[2:4].shape), bool)
        else:
            if self.drive == "requested":
                # a_j = (Φ_S − Φ_P)/(g(u_j) f)
                wanted = activation(x[0], x[2:4], self.control(t, x), self.C["controller"], self.curves["controller"])
            else:
                wanted = np.stack(np.broadcast_arrays(*self.activations(t), x[0])[:2])
            # a_j ∈ [a_min, 1]
            a = np.clip(wanted, self.a_min, 1.0)
            c, L_C = self.curves["plant"], fibres(x[0], x[2:4], self.C["plant"])
            # [z] z_j = (Φ_S(x_{j+2}) − Φ_P(L_Cj))/(a_j f(L_Cj)) ∈ [0, 1.45],   u_j = g⁻¹(z_j)
            z = (Phi_S(x[2:4], c) - Phi_P(L_C)) / (a * f(L_C, c))
            flags = np.stack([wanted < self.a_min, wanted > 1.0, z < 0.0, z > 1.45])
            u = g_inv(np.clip(z, 0.0, 1.45), c)
        u[0] += pulse
        return u, a, flags

    def rhs(self, t: float, X: Any, noise: Any = 0.0, pulse: Any = 0.0) -> Array:
        """Ẋ for X of shape (31, n), the held noise (3, n) and the held pulse."""
        d = np.empty_like(X)
        m, c = self.m["plant"], self.curves["plant"]
        x2, x34 = X[1], X[2:4]
        sign = np.array([[1.0], [-1.0]])
        F = Phi_S(x34, c)
        u, _, _ = self.drives(t, X[:4], pulse)
        # [load1] ẋ₁ = x₂;  [load2] ẋ₂ = (Φ_S(x₄) − Φ_S(x₃))/m + Δ_Φ;  [lsdot1] ẋ₃ = x₂ + u₁;  [lsdot2] ẋ₄ = −x₂ + u₂
        d[0] = x2
        d[1] = (F[1] - F[0]) / m + self.uncertainty(t)[0]
        d[2:4] = sign * x2 + u

        # [y1] y₁ = x₁ + ν₁;  [y2, y3] y₂ = Φ_S(x₃) + ν₂, y₃ = Φ_S(x₄) + ν₃
        y = np.concatenate([X[:1], F]) + noise
        common = Phi_S_inv(y[1:], c)
        for i, name in enumerate(OBSERVERS):
            o = 4 + 7 * i
            # e₁ = y₁ − x̂₁, e₃ = Φ_S⁻¹(y₂) − x̂₃, e₄ = Φ_S⁻¹(y₃) − x̂₄
            e1 = y[0] - X[o]
            e = (common if self.same[name] else Phi_S_inv(y[1:], self.curves[name])) - X[o + 3 : o + 7 : 2]
            accel = (y[2] - y[1]) / self.m[name]
            getattr(self, name)(X, d, o, e1, e, accel, sign * X[o + 1])
        return d

    def high_gain(self, X: Any, d: Any, o: int, e1: Any, e: Any, accel: Any, x2: Any) -> None:
        p, h = self.hg, self.hg["eps_h"]
        # [HO1a] x̂̇₁ = x̂₂ + h₁₁/ε e₁;  [HO1b] x̂̇₂ = (y₃ − y₂)/m + Δ̂ + h₁₂/ε² e₁;  [HO1c] Δ̂̇ = h₁₃/ε³ e₁
        d[o] = X[o + 1] + p["h11"] / h * e1
        d[o + 1] = accel + X[o + 2] + p["h12"] / h**2 * e1
        d[o + 2] = p["h13"] / h**3 * e1
        # [HO2a, HO3a] x̂̇_{j+2} = ±x̂₂ + û_j + h_{j+1,1}/ε e_{j+2};  [HO2b, HO3b] û̇_j = h_{j+1,2}/ε² e_{j+2}
        d[o + 3 : o + 7 : 2] = x2 + X[o + 4 : o + 7 : 2] + self.h_1 / h * e
        d[o + 4 : o + 7 : 2] = self.h_2 / h**2 * e

    def sliding_mode(self, X: Any, d: Any, o: int, e1: Any, e: Any, accel: Any, x2: Any) -> None:
        p = self.sm
        # [v11, v12, v2, v3] v₁₁ = λ₁₁|e₁|^½ sg(e₁), v₁₂ = α₁₁ sg(e₁), v₂ = α₂ sg(e₃), v₃ = α₃ sg(e₄)
        s1, v = e1 / (p["delta_s"] + abs(e1)), self.alpha_23 * e / (p["delta_s"] + abs(e))
        v12 = p["alpha11"] * s1
        # [SO1a] x̂̇₁ = x̂₂ + v₁₁;  [SO1b] x̂̇₂ = (y₃ − y₂)/m + v₁₂;  [SO1c] τ_s Δ̂̇ = −Δ̂ + v₁₂
        d[o] = X[o + 1] + p["lambda11"] * np.sqrt(abs(e1)) * s1
        d[o + 1] = accel + v12
        d[o + 2] = (-X[o + 2] + v12) / p["tau_s"]
        # [SO2a, SO3a] x̂̇_{j+2} = ±x̂₂ + v_{j+1};  [SO2b, SO3b] τ_s û̇_j = −û_j + v_{j+1}
        d[o + 3 : o + 7 : 2] = x2 + v
        d[o + 4 : o + 7 : 2] = (-X[o + 4 : o + 7 : 2] + v) / p["tau_s"]

    def adaptive_sliding_mode(self, X: Any, d: Any, o: int, e1: Any, e: Any, accel: Any, x2: Any) -> None:
        p = self.asm
        delta = p["delta_a"]
        l_a, r_0, k, r = X[25], X[26], X[27:31:2], X[28:31:2]
        # [La] L = l₀ + l_a,  L⁺ = max(L, L_min)
        L = p["l0"] + l_a
        L_p = np.maximum(L, p["L_min"])
        # [deltaa0] d₀ = L − |Δ̂|/(aβ₀) − ε_a0;  [dotla, rhoa0] l̇_a = −(r₀₀ + r_a0) sg(d₀)
        d_0 = L - abs(X[o + 2]) / (p["a_dual"] * p["beta0"]) - p["eps_a0"]
        dl = -(p["r00"] + r_0) * d_0 / (delta + abs(d_0))
        # [dra0] ṙ_a0 = γ_a0|d₀| if |d₀| > δ₀₀ else 0, − leak r_a0, r_a0 ≤ r_max
        dr_0 = np.where(abs(d_0) > p["delta00"], p["gamma_a0"] * abs(d_0), 0.0) - p["leak"] * r_0
        dr_0 = np.where((r_0 >= p["r_max"]) & (dr_0 > 0), 0.0, dr_0)
        # L ≤ L_min and l̇_a < 0: l̇_a = ṙ_a0 = 0
        held = (p["L_min"] >= L) & (dl < 0)
        dl, dr_0 = np.where(held, 0.0, dl), np.where(held, 0.0, dr_0)
        d[25], d[26] = dl, dr_0
        # α = α₀√L⁺, β = β₀L⁺, φ = −(L̇/L⁺) e₁
        s1 = e1 / (delta + abs(e1))
        beta_s = p["beta0"] * L_p * s1
        # [AO1a] x̂̇₁ = x̂₂ + α|e₁|^½ sg(e₁) − φ;  [AO1b] x̂̇₂ = (y₃ − y₂)/m + β sg(e₁);  [AO1c] τ_a Δ̂̇ = −Δ̂ + β sg(e₁)
        d[o] = X[o + 1] + p["alpha0"] * np.sqrt(L_p * abs(e1)) * s1 + dl / L_p * e1
        d[o + 1] = accel + beta_s
        d[o + 2] = (-X[o + 2] + beta_s) / p["tau_a"]
        # [AO2a, AO3a] x̂̇_{j+2} = ±x̂₂ + (k_j + η_j) sg(e_{j+2});  [AO2b, AO3b] τ_a û̇_j = −û_j + (k_j + η_j) sg(e_{j+2})
        v = (k + self.eta) * e / (delta + abs(e))
        d[o + 3 : o + 7 : 2] = x2 + v
        d[o + 4 : o + 7 : 2] = (-X[o + 4 : o + 7 : 2] + v) / p["tau_a"]
        # d_j = k_j − |û_j|/α_aj − ε_aj;  [kj, rhoaj] k̇_j = −(r₀j + r_aj) sg(d_j)
        d_j = k - abs(X[o + 4 : o + 7 : 2]) / self.alpha - self.eps
        dk = -(self.r0 + r) * d_j / (delta + abs(d_j))
        # [draj] ṙ_aj = γ_aj|d_j| if |d_j| > δ₀j else 0, − leak r_aj, r_aj ≤ r_max
        dr = np.where(abs(d_j) > self.dead, self.gam * abs(d_j), 0.0) - p["leak"] * r
        dr = np.where((r >= p["r_max"]) & (dr > 0), 0.0, dr)
        # k_j at 0 or k_max and moving out: k̇_j = ṙ_aj = 0
        held = ((k <= 0) & (dk < 0)) | ((k >= p["k_max"]) & (dk > 0))
        d[27:31:2], d[28:31:2] = np.where(held, 0.0, dk), np.where(held, 0.0, dr)


# ---------------------------------------------------------------- simulation


@dataclass
class Run:
    """Trajectories: the last axis is the run (seed), the one before it time."""

    p: dict[str, Any]
    t: Array
    states: Array  # (31, n_t, n)
    u: Array  # (2, n_t, n), the plant's, with the pulse
    Delta: Array  # (n_t,)
    a: Array  # (2, n_t, n), the formula on the true (x, u)
    a_in: Array  # the activation put in, NaN for the virtual drive
    flags: Array  # (4, 2, n_t, n): a below a_min, a above 1, z below 0, z above 1.45
    y: Array  # (3, n_t, n), as the observers see it
    estimates: dict[str, Array]  # (9, n_t, n) in the order of QUANTITIES, a limited
    limited: dict[str, Array]  # (2, 2, n_t, n): û outside [−5, 0.95], â outside [0, 1]
    truth: Array  # (9, n_t, n)
    slack: Array  # (2, n_t, n): Φ_S = 0
    model: Model

    def state(self, name: str) -> Array:
        return self.states[STATES.index(name)]


def simulate(
    parameters: Parameters,
    *,
    method: str = "rk4",
    seeds: Sequence[int] = (0,),
    start: Array | None = None,
    reference: Signal | None = None,
    uncertainty: Signal | None = None,
    activations: Signal | None = None,
    grid: Array | None = None,
    rtol: float = 1e-10,
    atol: float = 1e-12,
) -> Run:
    """Fixed-step RK4 (all steps are returned, all seeds at once) or DOP853 on `grid` (noise-free)."""
    model = Model(parameters, reference, uncertainty, activations)
    X0 = np.asarray(model.start() if start is None else start, float).reshape(31, -1)
    X0 = np.repeat(X0, len(seeds), axis=1) if X0.shape[1] == 1 else X0
    with np.errstate(all="ignore"):
        return _rk4(model, X0, seeds) if method == "rk4" else _dop853(model, X0, grid, rtol, atol)


def _rk4(model: Model, X: Array, seeds: Sequence[int]) -> Run:
    p = model.p
    h, T_s = value(p, "step"), value(p, "noise.period")
    steps, hold = round(value(p, "duration") / h), round(T_s / h)
    if abs(hold * h - T_s) > 1e-9 * T_s or hold < 1:
        raise ValueError(f"the noise's period {T_s} is not a whole number of steps {h}")
    noise = sensor_noise(p, seeds, steps // hold + 1)
    pulse = pulses(p, h, np.arange(steps + 1))
    out = np.empty((31, steps + 1, X.shape[1]))
    out[:, 0] = X
    for i in range(steps):
        t, w, q = i * h, noise[i // hold], pulse[i]
        # k₁ = F(τ, X), k₂ = F(τ + h/2, X + h/2 k₁), k₃ = F(τ + h/2, X + h/2 k₂), k₄ = F(τ + h, X + h k₃)
        k1 = model.rhs(t, X, w, q)
        k2 = model.rhs(t + h / 2, X + h / 2 * k1, w, q)
        k3 = model.rhs(t + h / 2, X + h / 2 * k2, w, q)
        k4 = model.rhs(t + h, X + h * k3, w, q)
        # X⁺ = X + h/6 (k₁ + 2k₂ + 2k₃ + k₄)
        X = X + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        out[:, i + 1] = X
    index = np.arange(steps + 1)
    return _finish(model, index * h, out, noise[index // hold].transpose(1, 0, 2), pulse)


def _dop853(model: Model, X0: Array, grid: Array | None, rtol: float, atol: float) -> Run:
    p = model.p
    if value(p, "noise.x1") or value(p, "noise.force"):
        raise ValueError("the adaptive step is for noise-free runs")
    T, h = value(p, "duration"), value(p, "step")
    t = np.linspace(0, T, round(T / value(p, "record")) + 1) if grid is None else np.asarray(grid, float)
    drift = np.array([[0.0], [1.0], [1.0]]) * value(p, "noise.drift")
    jumps = {round(float(e) / h) * h for n in ("start", "stop") for e in np.atleast_1d(value(p, f"pulse.{n}"))}
    edges = sorted({0.0, T, *(e for e in jumps if 0 < e < T)})
    out, X = np.empty((31, t.size, 1)), X0[:, 0]
    for a, b in pairwise(edges):
        q, here = pulses(p, h, round(a / h)), (t >= a) & (t <= b)
        stops = np.union1d(t[here], b)
        s = solve_ivp(
            lambda tau, X, q=q: model.rhs(tau, X[:, None], drift, q)[:, 0], (a, b), X,
            method="DOP853", rtol=rtol, atol=atol, max_step=0.005, t_eval=stops,
        )  # fmt: skip
        out[:, here, 0], X = s.y[:, : here.sum()], s.y[:, -1]
    return _finish(model, t, out, drift[:, None], pulses(p, h, np.floor(t / h + 1e-9)))


def _finish(model: Model, t: Array, X: Array, noise: Array, pulse: Array) -> Run:
    """u, Δ, a and the estimates from the states."""
    shape = X.shape[1:]
    flat = X.reshape(31, -1)
    tt, qq = np.repeat(t, shape[1]), np.repeat(np.broadcast_to(pulse, t.shape), shape[1])
    c = model.curves["plant"]
    u, a_in, flags = model.drives(tt, flat[:4], qq)
    a = activation(flat[0], flat[2:4], u, model.C["plant"], c)
    D = np.broadcast_to(np.asarray(model.uncertainty(t)[0], float), t.shape)
    estimates, limited = {}, {}
    for i, name in enumerate(OBSERVERS):
        o = 4 + 7 * i
        u_hat = flat[o + 4 : o + 7 : 2]
        # û limited to [−5, 0.95] before g, â projected to [0, 1]
        raw = activation(flat[o], flat[o + 3 : o + 7 : 2], np.clip(u_hat, -5, 0.95), model.C[name], model.curves[name])
        parts = (flat[o : o + 2], flat[o + 3 : o + 7 : 2], flat[o + 2 : o + 3], u_hat, np.clip(raw, 0, 1))
        estimates[name] = np.concatenate(parts).reshape(9, *shape)
        limited[name] = np.stack([(u_hat < -5) | (u_hat > 0.95), (raw < 0) | (raw > 1)]).reshape(2, 2, *shape)
    y = np.concatenate([flat[:1], Phi_S(flat[2:4], c)]).reshape(3, *shape) + noise
    u, a, a_in = (v.reshape(2, *shape) for v in (u, a, a_in))
    truth = np.concatenate([X[:4], np.broadcast_to(D[:, None], shape)[None], u, a])
    slack = (Phi_S(flat[2:4], c) == 0).reshape(2, *shape)
    return Run(model.p, t, X, u, D, a, a_in, flags.reshape(4, 2, *shape), y, estimates, limited, truth, slack, model)


# ---------------------------------------------------------------- measures


def masked(run: Run, quantities: Array) -> Array:
    """Copies with NaN where the muscle is slack: its tendon length, u and a are not determined there."""
    out = quantities.copy()
    for j in (0, 1):
        for i in (2 + j, 5 + j, 7 + j):
            out[i][run.slack[j]] = np.nan
    return out


def errors(run: Run, name: str) -> Array:
    return masked(run, run.truth - run.estimates[name])


def rmse(error: Array, t: Array, start: float = 2.0) -> Array:
    """√mean of the squared error over all nodes in [start, T], both ends; axis −2 is time; masked NaN do not count."""
    window = error[..., t >= start - 1e-9, :]
    count = (~np.isnan(window)).sum(-2)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.sqrt(np.nansum(window**2, -2) / count)


def peak(error: Array) -> Array:
    """max |error| over [0, T]."""
    return np.where(np.isnan(error).all(-2), np.nan, np.nanmax(np.where(np.isnan(error), -np.inf, abs(error)), axis=-2))


def settling(error: Array, t: Array, tolerances: Sequence[float] = TOLERANCES) -> Array:
    """Last time |error| exceeds its tolerance, 0 if never, NaN if the last unmasked sample does; error (9, n_t, n)."""
    out = np.zeros((error.shape[0], error.shape[2]))
    for i, j in np.ndindex(out.shape):
        valid = np.flatnonzero(~np.isnan(error[i, :, j]))
        above = valid[abs(error[i, valid, j]) > tolerances[i]]
        if valid.size == 0 or (above.size and above[-1] == valid[-1]):
            out[i, j] = np.nan
        elif above.size:
            out[i, j] = t[above[-1]]
    return out


def chattering(run: Run, name: str) -> Array:
    """mean |v̂((k+1)T_s) − v̂(kT_s)| over [start, T] for Δ, u₁, u₂, a₁, a₂: shape (5, n)."""
    hold = round(value(run.p, "noise.period") / value(run.p, "step"))
    sampled = masked(run, run.estimates[name])[4:, ::hold]
    sampled = sampled[:, run.t[::hold] >= value(run.p, "score.start") - 1e-9]
    return np.nanmean(abs(np.diff(sampled, axis=1)), axis=1)


def baselines(run: Run) -> dict[str, Array]:
    """RMSE without an observer: Δ̂ = offset, x̂₂ = 0, û = 0 (every step), â from raw y with û = 0 (every sample)."""
    start, m, c = value(run.p, "score.start"), run.model, run.model.curves["plant"]
    truth = masked(run, run.truth)
    hold = round(value(run.p, "noise.period") / value(run.p, "step"))
    y, t = run.y[:, ::hold], run.t[::hold]
    L = Phi_S_inv(y[1:].reshape(2, -1), c)
    # â = (Φ_S(Φ_S⁻¹(y)) − Φ_P(L̂_C))/f(L̂_C), projected to [0, 1]
    a = np.clip(activation(y[0].ravel(), L, np.zeros_like(L), m.C["plant"], c), 0, 1).reshape(y[1:].shape)
    return {
        "x2": rmse(truth[1], run.t, start),
        "Delta": rmse(truth[4] - value(run.p, "uncertainty.offset"), run.t, start),
        "u": rmse(truth[5:7], run.t, start),
        "a": rmse(truth[7:9, ::hold] - a, t, start),
    }
