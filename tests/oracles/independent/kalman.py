"""The Kalman filter in dense matrices, with the states of its orders only; and others of the plant itself."""

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.linalg import expm

from .muscle import Curves, Phi_S, Phi_S_inv, dPhi_S

TENDON = Curves()


@dataclass(frozen=True)
class Model:
    """Order of the chains of Δ and of u, mass, noise of y₁, y₂, y₃, √densities of Δ, u₁, u₂."""

    order_D: int = 2
    order_u: int = 2
    m: float = 1.0
    sigma: tuple[float, float, float] = (1e-3, 1e-3, 1e-3)
    s: tuple[float, float, float] = (0.01, 0.05, 0.05)

    @property
    def chains(self) -> list[slice]:
        """Where Δ, u₁, u₂ and their derivatives are among the states; x₁ … x₄ come first."""
        ends = 4 + np.cumsum([0, self.order_D, self.order_u, self.order_u])
        return [slice(int(a), int(b)) for a, b in itertools.pairwise(ends)]

    @property
    def n(self) -> int:
        return self.chains[-1].stop

    def drift(self) -> np.ndarray:
        """Everything but the tendons: ẋ = A x."""
        A = np.zeros((self.n, self.n))
        A[0, 1], A[2, 1], A[3, 1] = 1, 1, -1
        for row, chain in zip((1, 2, 3), self.chains, strict=True):
            A[row, chain.start] = 1
            for i in range(chain.start, chain.stop - 1):
                A[i, i + 1] = 1
        return A

    def noise(self) -> np.ndarray:
        Q = np.zeros((self.n, self.n))
        for s, chain in zip(self.s, self.chains, strict=True):
            Q[chain.stop - 1, chain.stop - 1] = s**2
        return Q

    def start(self, y: np.ndarray, R: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x, sd = np.zeros(self.n), np.zeros(self.n)
        x[[0, 2, 3]] = y[0], *Phi_S_inv(y[1:, None], TENDON)[:, 0]
        sd[[0, 2, 3]], sd[1] = 2 * np.sqrt(R), 0.3
        for first, chain in zip((0.5, 0.3, 0.3), self.chains, strict=True):
            sd[chain] = first * 3.0 ** np.arange(chain.stop - chain.start)
        return x, np.diag(sd**2)


def tendon_slopes(z: np.ndarray) -> np.ndarray:
    return np.maximum(dPhi_S(z[:, None], TENDON)[:, 0], 0.05 * TENDON.k)


def kalman(model: Model, t: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means (samples × n) and covariances (samples × n × n) after each sample."""
    steps = filtered(model, t, y)
    return np.array([step.x for step in steps]), np.array([step.P for step in steps])


@dataclass(frozen=True)
class Step:
    """The motion to a sample, what is expected there, and what it is after the measurement; log L of that."""

    F: np.ndarray
    x_before: np.ndarray
    P_before: np.ndarray
    x: np.ndarray
    P: np.ndarray
    log_likelihood: float


def filtered(model: Model, t: np.ndarray, y: np.ndarray) -> list[Step]:
    """All steps of the filter."""
    x = P = before = None
    steps = []
    for now, measured in zip(t, y, strict=True):
        z = Phi_S_inv(measured[1:, None], TENDON)[:, 0]
        p = tendon_slopes(z)
        R = np.array([model.sigma[0], *(np.array(model.sigma[1:]) / p)]) ** 2
        acc = (measured[2] - measured[1]) / model.m
        F = np.eye(model.n)
        if before is None:
            x, P = model.start(measured, R)
        else:
            t0, p0, z0, acc0 = before
            T, slope = now - t0, (p + p0) / 2 / model.m
            # ẋ₂ = acc + [p₂(x₄ − z₂) − p₁(x₃ − z₁)]/m + Δ
            A = model.drift()
            A[1, 2], A[1, 3] = -slope[0], slope[1]
            known = [a - (slope[1] * at[1] - slope[0] * at[0]) for a, at in ((acc0, z0), (acc, z))]
            # the known part goes in a straight line: two more states
            whole = np.zeros((model.n + 2, model.n + 2))
            whole[: model.n, : model.n] = A
            whole[1, model.n] = whole[model.n, model.n + 1] = 1
            moved = expm(whole * T)
            F = moved[: model.n, : model.n]
            x = F @ x + moved[: model.n, model.n :] @ [known[0], (known[1] - known[0]) / T]
            QT = model.noise() * T
            P = F @ (P + QT / 2) @ F.T + QT / 2
        x_before, P_before = x, P
        H = np.zeros((3, model.n))
        H[[0, 1, 2], [0, 2, 3]] = 1
        S = H @ P @ H.T + np.diag(R)
        nu = np.array([measured[0], *z]) - H @ x
        K = P @ H.T @ np.linalg.inv(S)
        x = x + K @ nu
        # Joseph's form
        rest = np.eye(model.n) - K @ H
        P = rest @ P @ rest.T + K @ np.diag(R) @ K.T
        before = now, p, z, acc
        value = -0.5 * (nu @ np.linalg.solve(S, nu) + np.linalg.slogdet(2 * np.pi * S)[1])
        steps.append(Step(F, x_before, P_before, x, P, float(value)))
    return steps


def smoothed(steps: list[Step]) -> tuple[np.ndarray, np.ndarray]:
    """Means and covariances that know all samples, by Rauch, Tung and Striebel."""
    x, P = steps[-1].x, steps[-1].P
    means, covariances = [x], [P]
    for now, after in zip(steps[-2::-1], steps[:0:-1], strict=True):
        C = np.linalg.solve(after.P_before, after.F @ now.P).T
        x = now.x + C @ (x - after.x_before)
        P = now.P + C @ (P - after.P_before) @ C.T
        means.append(x)
        covariances.append(P)
    return np.array(means[::-1]), np.array(covariances[::-1])


class Plant:
    """The plant as it is: ẋ₂ = (Φ_S(x₄) − Φ_S(x₃))/m + Δ, measured forces Φ_S(x₃), Φ_S(x₄)."""

    def __init__(self, model: Model) -> None:
        self.model, self.A = model, model.drift()

    def moved(self, x: np.ndarray, T: float, n: int = 40) -> np.ndarray:
        return rk4(self.rates, x, T, n)

    def rates(self, x: np.ndarray) -> np.ndarray:
        d = self.A @ x
        forces = Phi_S(x[2:4], TENDON)
        d[1] += (forces[1] - forces[0]) / self.model.m
        return d

    def seen(self, x: np.ndarray) -> np.ndarray:
        return np.concatenate([x[:1], Phi_S(x[2:4], TENDON)])

    def tangents(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """∂ẋ/∂x and ∂y/∂x."""
        p, A, H = dPhi_S(x[2:4], TENDON), self.A.copy(), np.zeros((3, len(x)))
        A[1, 2], A[1, 3] = -p[0] / self.model.m, p[1] / self.model.m
        H[0, 0], H[1, 2], H[2, 3] = 1, *p
        return A, H


def extended(model: Model, t: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The extended Kalman filter of the plant."""
    plant, R = Plant(model), np.diag(np.square(model.sigma))
    x, P = model.start(y[0], np.diag(R) / np.array([1, TENDON.k, TENDON.k]) ** 2)
    every = []
    for i, measured in enumerate(y):
        if i:
            T = t[i] - t[i - 1]
            F, QT = expm(plant.tangents(x)[0] * T), model.noise() * T
            x, P = plant.moved(x, T), F @ (P + QT / 2) @ F.T + QT / 2
        H = plant.tangents(x)[1]
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        x, P = x + K @ (measured - plant.seen(x)), (np.eye(model.n) - K @ H) @ P
        every.append((x, P))
    return np.array([x for x, _ in every]), np.array([P for _, P in every])


def unscented(model: Model, t: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The unscented Kalman filter of the plant."""
    plant = Plant(model)
    R = np.array([model.sigma[0], *(np.array(model.sigma[1:]) / TENDON.k)]) ** 2
    x, P = model.start(y[0], R)
    every = []
    for i, measured in enumerate(y):
        if i:
            T = t[i] - t[i - 1]
            QT = model.noise() * T
            points = plant.moved(sigma_points(x, P + QT / 2), T)
            x, P = points.mean(1), covariance(points, points) + QT / 2
        points = sigma_points(x, P)
        outputs = plant.seen(points)
        S = covariance(outputs, outputs) + np.diag(np.square(model.sigma))
        K = covariance(points, outputs) @ np.linalg.inv(S)
        x = x + K @ (measured - outputs.mean(1))
        P = P - K @ S @ K.T
        every.append((x, P))
    return np.array([x for x, _ in every]), np.array([P for _, P in every])


def sigma_points(x: np.ndarray, P: np.ndarray) -> np.ndarray:
    """2n points (n × 2n) of equal weight."""
    root = np.linalg.cholesky(len(x) * P)
    return np.hstack([x[:, None] + root, x[:, None] - root])


def covariance(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a - a.mean(1, keepdims=True)) @ (b - b.mean(1, keepdims=True)).T / a.shape[1]


def rk4(rates: Callable[[Any], Any], x: np.ndarray, T: float, n: int) -> np.ndarray:
    h = T / n
    for _ in range(n):
        k1 = rates(x)
        k2 = rates(x + h / 2 * k1)
        k3 = rates(x + h / 2 * k2)
        k4 = rates(x + h * k3)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return x


def steady_gains(n: int, s: float, sigma: float, T: float) -> np.ndarray:
    """K of a chain of n integrators, by its Riccati recursion run until it stands still."""
    F = expm(np.diag(np.ones(n - 1), 1) * T)
    QT = np.zeros((n, n))
    QT[-1, -1] = s**2 * T
    P = np.eye(n)
    K = np.zeros(n)
    for _ in range(1_000_000):
        P = F @ (P + QT / 2) @ F.T + QT / 2
        last, K = K, P[:, 0] / (P[0, 0] + sigma**2)
        P = P - np.outer(K, P[0])
        P = (P + P.T) / 2
        if np.abs(K - last).max() <= 1e-13 * np.abs(K).max():
            break
    return K


def numbers(model: Model) -> Mapping[str, float]:
    """The same model by the names of the filter's parameters."""
    return dict(
        zip(
            ("order_D", "order_u", "m", "sigma_1", "sigma_F1", "sigma_F2", "s_D", "s_u1", "s_u2"),
            (model.order_D, model.order_u, model.m, *model.sigma, *model.s),
            strict=True,
        )
    )
