"""How good estimates are: RMSE, peak, settling time, chattering, and what needs no observer."""

from collections.abc import Sequence

import numpy as np

from .muscle import Phi_S_inv, activation
from .parameters import value
from .run import Run
from .states import Array

TOLERANCES = (2e-3, 5e-3, 5e-4, 5e-4, 5e-3, 5e-3, 5e-3, 2e-2, 2e-2)  # of the settling time


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
