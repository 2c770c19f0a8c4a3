"""Filters of one joint and of one muscle: against another text of filter and smoother, and a score's meaning."""

import itertools

import numpy as np
import pytest
from scipy.linalg import expm

from hillobs.model.arrays import Array
from hillobs.observers.behind.spread import entry
from hillobs.observers.kalman.apart.activations import LAW_MODEL
from hillobs.observers.kalman.apart.integrators import JOINT_MODEL, MUSCLE_MODEL
from hillobs.observers.kalman.model import Model
from hillobs.studies.kalman.passes import Filtered, Smoothed, compiled, log_likelihood, table

pytestmark = pytest.mark.numerics

SAMPLES = 120
MODELS = {"joint": JOINT_MODEL, "muscle": MUSCLE_MODEL, "law": LAW_MODEL}
# which state is measured, and in which the unknown input begins
UNKNOWN = {"joint": 3, "muscle": 1, "law": 1}


def columns() -> dict[str, Array]:
    """Of nothing in particular, with uneven steps, and some samples that nobody has seen."""
    random = np.random.default_rng(4)
    t = np.cumsum(random.uniform(0.3, 1.7, SAMPLES)) * 0.05
    noise, seen = 1e-3 * random.normal(size=SAMPLES), np.ones(SAMPLES)
    seen[50:54] = 0
    known = {"t": t, "y": 0.4 * np.sin(t) + noise, "acc": -0.4 * np.sin(t), "white": 1e-5 * (2 + np.sin(t))}
    known |= {"lasting": 3e-5 * (2 + np.cos(t)), "pole": 5 + np.sin(t), "z": 2 + 0.1 * np.sin(2 * t) + noise}
    known |= {"slope": 20 + 3 * np.sin(t), "rate": 0.1 * np.cos(t), "u": 0.1 * np.cos(2 * t), "b_x3": -20 + np.sin(t)}
    known |= {"b_a": 0.8 + 0.1 * np.sin(t), "x3_hat": 2 + 0.1 * np.sin(2 * t), "a_hat": 0.3 + 0 * t}
    return {**known, "seen": seen, "counted": np.ones(SAMPLES)}


def values(model: Model, order: int) -> dict[str, float]:
    defaults = {name: parameter.default for name, parameter in model.parameters.items()}
    # the noise of the columns, of forces where tendons have the slope 20
    noise = {name: value for name, value in (("sigma_1", 1e-3), ("sigma_F1", 0.02)) if name in defaults}
    return defaults | noise | {name: float(order) for name in defaults if name.startswith("order")}


def passed(model: Model, numbers: dict[str, float]) -> tuple[Filtered, Smoothed, Array]:
    passes, rows = compiled(model), table(model, columns())
    motions = passes.motions(numbers, rows)
    filtered = passes.filtered(numbers, passes.start(numbers, rows[0]), rows, motions)
    return filtered, passes.smoothed(numbers, rows, motions, filtered), rows


class Plain:
    """ẋ = A x + w, dense; of the chain in use, without derivatives that are not."""

    def __init__(self, kind: str, order: int, numbers: dict[str, float]) -> None:
        self.kind, self.n = kind, UNKNOWN[kind] + order
        self.s = numbers[{"joint": "s_D", "muscle": "s_u1", "law": "s_a1"}[kind]]
        self.numbers, self.first = numbers, UNKNOWN[kind]

    def between(self, was: dict[str, float], now: dict[str, float]) -> tuple[Array, Array, Array]:
        """F, b and the noise QT of a step; what is known goes in straight lines."""
        T, n, A, ends = now["t"] - was["t"], self.n, np.zeros((self.n, self.n)), np.zeros((2, self.n))
        for i in range(self.first, n - 1):
            A[i, i + 1] = 1
        Q = np.zeros(n)
        Q[-1] = self.s**2
        if self.kind == "joint":
            pole = (was["pole"] + now["pole"]) / 2
            A[0, 1] = A[1, 2] = A[1, 3] = 1
            A[2, 2] = -pole
            ends[:, 1] = was["acc"], now["acc"]
            Q[1] += (was["white"] + now["white"]) / 2
            Q[2] += pole**2 * (was["lasting"] + now["lasting"]) / 2
        elif self.kind == "muscle":
            A[0, 1] = 1
            ends[:, 0] = was["rate"], now["rate"]
        else:
            A[0, :2] = [(was[b] + now[b]) / 2 for b in ("b_x3", "b_a")]
            ends[:, 0] = [at["rate"] + at["u"] - A[0, 0] * at["x3_hat"] - A[0, 1] * at["a_hat"] for at in (was, now)]
            Q[0] += self.numbers["s_x3"] ** 2
        whole = np.zeros((n + 2, n + 2))
        whole[:n, :n], whole[:n, n], whole[:n, n + 1], whole[n + 1, n] = A * T, ends[0] * T, (ends[1] - ends[0]) * T, 1
        moved = expm(whole)
        return moved[:n, :n], moved[:n, n], np.diag(Q) * T

    def measured(self, at: dict[str, float]) -> tuple[float, float]:
        if self.kind == "joint":
            return at["y"], self.numbers["sigma_1"] ** 2
        return at["z"], (self.numbers["sigma_F1"] / at["slope"]) ** 2

    def start(self, at: dict[str, float]) -> tuple[Array, Array]:
        x, sd = np.zeros(self.n), np.zeros(self.n)
        x[0], sd[0] = at["y"] if self.kind == "joint" else at["z"], 2 * np.sqrt(self.measured(at)[1])
        first = {"joint": 0.5, "muscle": 0.3, "law": 0.3}[self.kind]
        sd[self.first :] = first * 3.0 ** np.arange(self.n - self.first)
        if self.kind == "joint":
            sd[1], sd[2] = 0.3, np.sqrt(at["pole"] * at["lasting"] / 2)
        if self.kind == "law":
            x[1] = at["a_hat"]
        return x, np.diag(sd**2)

    def smoothed(self, known: dict[str, Array]) -> tuple[Array, Array, float]:
        """Rauch, Tung and Striebel: means, covariances, and log L of what was seen."""
        samples = [{name: float(column[k]) for name, column in known.items()} for k in range(SAMPLES)]
        x, P = self.start(samples[0])
        steps, total = [], 0.0
        for k, now in enumerate(samples):
            F = np.eye(self.n)
            if k:
                F, b, QT = self.between(samples[k - 1], now)
                x, P = F @ x + b, F @ (P + QT / 2) @ F.T + QT / 2
            before = x, P
            value, R = self.measured(now)
            S = P[0, 0] + R
            if now["seen"]:
                K, total = P[:, 0] / S, total - 0.5 * (np.log(2 * np.pi * S) + (value - x[0]) ** 2 / S)
                rest = np.eye(self.n) - np.outer(K, np.eye(self.n)[0])
                x, P = x + K * (value - x[0]), rest @ P @ rest.T + R * np.outer(K, K)
            steps.append((F, *before, x, P))
        means, covariances = [steps[-1][3]], [steps[-1][4]]
        for (_, _, _, x, P), (F, x_next, P_next, _, _) in zip(reversed(steps[:-1]), reversed(steps[1:]), strict=True):
            # correlations are better to invert
            sds = np.sqrt(np.outer(np.diag(P_next), np.diag(P_next)))
            G = P @ F.T @ (np.linalg.inv(P_next / sds) / sds)
            means.append(x + G @ (means[-1] - x_next))
            covariances.append(P + G @ (covariances[-1] - P_next) @ G.T)
        return np.array(means[::-1]), np.array(covariances[::-1]), total


@pytest.mark.parametrize(("kind", "order"), list(itertools.product(MODELS, (1, 2, 3))))
def test_the_smoother_is_that_of_rauch_tung_and_striebel(kind: str, order: int) -> None:
    model, known = MODELS[kind], columns()
    numbers = values(model, order)
    plain = Plain(kind, order, numbers)
    x, P, likelihood = plain.smoothed(known)
    filtered, smoothed, rows = passed(model, numbers)
    told = dict(zip(compiled(model).told, smoothed.told.T, strict=True))
    first = {"joint": {"x1": 0, "x2": 1, "Delta": 3}, "muscle": {"x3": 0, "u1": 1}, "law": {"x3": 0, "a1": 1}}[kind]
    sds = {name: np.sqrt(P[:, i, i]) for name, i in first.items()}
    # theirs inverts correlations, and both lose digits at the start: a rate of sd 0.9 over R is 1e6 after a step, 1e12
    # after two, of 1e16
    for name, i in first.items():
        np.testing.assert_allclose(told[name] / sds[name], x[:, i] / sds[name], atol=1e-5)
    for a, b in itertools.combinations_with_replacement(first, 2):
        scale = sds[a] * sds[b]
        np.testing.assert_allclose(told[entry(a, b)] / scale, P[:, first[a], first[b]] / scale, atol=1e-5)
    assert log_likelihood(filtered, rows) == pytest.approx(likelihood, rel=1e-10)


@pytest.mark.parametrize("kind", MODELS)
def test_the_score_is_the_derivative_of_the_likelihood(kind: str) -> None:
    model = MODELS[kind]
    numbers = values(model, 2)
    _, smoothed, _ = passed(model, numbers)
    for name, (found, expected) in zip(compiled(model).densities, smoothed.score, strict=True):
        q, step = numbers[name] ** 2, 1e-4

        def at(factor: float, name: str = name, q: float = q) -> float:
            filtered, _, rows = passed(model, {**numbers, name: np.sqrt(q * factor)})
            return log_likelihood(filtered, rows)

        difference = (at(1 + step) - at(1 - step)) / (2 * step)
        # rounding of log L ~ 1e3 over the step, and its third derivative times the step squared
        assert q * (found - expected) / 2 == pytest.approx(difference, rel=1e-5, abs=1e-5)
