"""What a result must have to be estimates, and to be repeated."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..files.datasets.schema import FLOATS, TEXTS, WHOLES, Schema, read_json, rising
from ..files.errors import ResultError
from ..laboratory.muscles import muscle_pair
from .dataset import PER_MUSCLE, TRUE
from .scores import ESTIMATED

_TIME, _ALONE = ("time",), ("observer", "time")
_BOTH = (*_ALONE, "muscle")

ESTIMATES = Schema(
    variables={
        "time": (_TIME, FLOATS),
        "muscle": (("muscle",), WHOLES),
        "observer": (("observer",), TEXTS),
        "position": (_TIME, FLOATS),
        "force": ((*_TIME, "muscle"), FLOATS),
        **{f"{name}_hat": (_ALONE, FLOATS) for name in ("position", "velocity", "disturbance")},
        **{
            f"{name}_hat": (_BOTH, FLOATS) for name in ("tendon_length", "fibre_length", "fibre_velocity", "activation")
        },
        "position_innovation": (_ALONE, FLOATS),
        "tendon_innovation": (_BOTH, FLOATS),
        "velocity_limited": (_BOTH, WHOLES),
        "activation_limited": (_BOTH, WHOLES),
        "slack": ((*_TIME, "muscle"), WHOLES),
        "bridged": (_TIME, WHOLES),
        "muscle_file": ((), TEXTS),
    },
    optional={
        **{f"true_{name}": ((*_TIME, "muscle") if name in PER_MUSCLE else _TIME, FLOATS) for name in TRUE},
        **{
            f"{name}_sd{part}": (_BOTH if name in PER_MUSCLE else _ALONE, FLOATS)
            for name in ESTIMATED
            for part in ("", "_state", "_muscle")
        },
    },
    labels={"muscle": (1, 2), "observer": None},
    attributes={
        "source": str,
        "doubt": dict[str, float],
        "settings": {
            "mapping": dict[str, str],
            "corrected": bool,
            "changes": dict[str, float],
            "keep_every": int,
            "form": str,
            "smooth": bool,
            "lag": float,
        },
    },
)


def check_estimates(dataset: xr.Dataset) -> None:
    """ResultError says why a Dataset is no estimates."""
    ESTIMATES.check(dataset)
    rising(dataset, "time")
    for name in ("position", "force"):
        if not np.isfinite(dataset[name].values).all():
            raise ResultError(f"its {name} is not finite")


def arguments(dataset: xr.Dataset) -> dict[str, Any]:
    """What `estimate` needs beside the recording to repeat a result, by the names of its arguments.

    ResultError or ScenarioError if the Dataset has no estimates, or muscles that are none.
    """
    attributes = ESTIMATES.check(dataset)
    # a result holds the points of a user's curves, and names no file of them
    muscles = muscle_pair(read_json("muscle_file", str(dataset.muscle_file.values), dict), None)
    # all that was in doubt, whatever is usual by now
    doubt = {"doubt": attributes["doubt"], "usual_doubt": False}
    return {"muscles": muscles, "observers": dataset.observer.values.tolist(), **attributes["settings"], **doubt}
