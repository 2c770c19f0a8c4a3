"""The rank and the null directions are those of simulated outputs, by an empirical Gramian."""

from collections.abc import Sequence

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from hillobs.model.arrays import Array
from independent import muscle
from observed_systems import REGIONS, SENSORS, block, kernel_of, same_space, sizes, verdict


def outputs_of(unknown: str, start: Array, duration: float, sensors: Sequence[str]) -> Array:
    """Simulated outputs at 12 times for the columns of `start`, (Δ, w₁, w₂) constant, by docs/model.md#plant."""

    def rhs(_: float, flat: Array) -> Array:
        x1, x2, x3, x4, Delta, *w = X = flat.reshape(7, -1)
        tendons = np.stack([x3, x4])
        force = muscle.Phi_S(tendons)
        u = np.stack(w)
        if unknown == "a":
            L_C = muscle.fibres(x1, tendons, 5.54)
            z = (force - muscle.Phi_P(L_C)) / (np.clip(u, 0.01, 1) * muscle.f(L_C))
            u = muscle.g_inv(np.clip(z, 0, 1.45))
        rates = np.zeros_like(X)
        rates[:4] = x2, force[1] - force[0] + Delta, x2 + u[0], -x2 + u[1]
        return rates.ravel()

    times = np.linspace(0, duration, 12)
    run = solve_ivp(rhs, (0, duration), start.ravel(), method="DOP853", t_eval=times, rtol=1e-12, atol=1e-13)
    x1, x2, x3, x4 = run.y.reshape(7, -1, len(times))[:4]
    signals = {
        "x1": x1, "x2": x2, "Phi_S1": muscle.Phi_S(x3), "Phi_S2": muscle.Phi_S(x4),
        "L_C1": x1 - x3, "L_C2": 5.54 - x1 - x4,
    }  # fmt: skip
    return np.concatenate([signals[name].T for name in sensors])


@pytest.mark.parametrize("sensors", [SENSORS, ("Phi_S1", "Phi_S2"), ("L_C1", "L_C2"), ("x2", "Phi_S1")], ids=str)
@pytest.mark.parametrize(("unknown", "duration"), [("u", 0.5), ("a", 0.3)])
@pytest.mark.parametrize("region", ["both taut", "1 slack", "2 slack", "both slack"])
def test_simulated_outputs_see_the_same(unknown: str, duration: float, region: str, sensors: tuple[str, ...]) -> None:
    """Empirical Gramian W = Σ ΔyᵀΔy: its rank and its kernel."""
    # so far below 2 that the tendons stay slack; a slack muscle driven by a shortens with u = 1
    point = {name: value if value > 2 or name not in ("x3", "x4") else 1.6 for name, value in REGIONS[region].items()}
    b = block(unknown)
    x = np.array([point[name] for name in b.x])
    scale = np.array(list(sizes(b).values()))
    step = 1e-3 * np.diag(scale)
    y = outputs_of(unknown, x[:, None] + np.hstack([step, -step]), duration, sensors)
    # ∂y/∂x by central differences
    sensitivity = (y[:, :7] - y[:, 7:]) / 2e-3
    _, values, right = np.linalg.svd(sensitivity, full_matrices=False)
    v = verdict(unknown, point, sensors)
    if unknown == "a" and sensors in (("L_C1", "L_C2"), ("x2", "Phi_S1")):
        # what f carries only is faint: no kernel of ours may be seen, the converse is not decided by differences
        kernel = kernel_of(v)
        assert np.all(np.abs(sensitivity @ kernel) < 1e-5 * values[0])
        return
    assert np.sum(values > 1e-6 * values[0]) == v.rank
    assert same_space(kernel_of(v), right[v.rank :].T, 1e-3)
