"""What a result must have to be estimates, and to be repeated."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from ..files.datasets.schema import FLOATS, TEXTS, WHOLES, Schema, read_json, rising
from ..files.errors import ResultError
from ..laboratory.subject import subject_again
from .dataset import PER_MUSCLE, TRUE
from .scores import ESTIMATED

_TIME, _OF_OBSERVERS = ("time",), ("observer", "time")


def _schema(joint: tuple[str, ...]) -> Schema:
    """Of estimates whose joints have this dimension: none of a pair."""
    both, alone = (*_OF_OBSERVERS, "muscle"), (*_OF_OBSERVERS, *joint)
    names = TEXTS if joint else WHOLES
    return Schema(
        variables={
            "time": (_TIME, FLOATS),
            "muscle": (("muscle",), names),
            **{name: ((name,), TEXTS) for name in joint},
            "observer": (("observer",), TEXTS),
            "position": ((*_TIME, *joint), FLOATS),
            "force": ((*_TIME, "muscle"), FLOATS),
            **{f"{name}_hat": (both if name in PER_MUSCLE else alone, FLOATS) for name in ESTIMATED},
            "position_innovation": (alone, FLOATS),
            "tendon_innovation": (both, FLOATS),
            "velocity_limited": (both, WHOLES),
            "activation_limited": (both, WHOLES),
            "slack": ((*_TIME, "muscle"), WHOLES),
            "bridged": (_TIME, WHOLES),
            "muscle_file": ((), TEXTS),
        },
        optional={
            **{f"true_{name}": ((*_TIME, *(("muscle",) if name in PER_MUSCLE else joint)), FLOATS) for name in TRUE},
            **{
                f"{name}_sd{part}": (both if name in PER_MUSCLE else alone, FLOATS)
                for name in ESTIMATED
                for part in ("", "_state", "_muscle")
            },
        },
        labels={"muscle": None if joint else (1, 2), **dict.fromkeys(joint), "observer": None},
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


_PAIR, _MECHANISM = _schema(()), _schema(("joint",))


def _checked(dataset: xr.Dataset) -> dict[str, Any]:
    return (_MECHANISM if "joint" in dataset.dims else _PAIR).check(dataset)


def check_estimates(dataset: xr.Dataset) -> None:
    """ResultError says why a Dataset is no estimates."""
    _checked(dataset)
    rising(dataset, "time")
    for name in ("position", "force"):
        if not np.isfinite(dataset[name].values).all():
            raise ResultError(f"its {name} is not finite")


def arguments(dataset: xr.Dataset) -> dict[str, Any]:
    """What `estimate` needs beside the recording to repeat the result `dataset`, by the names of its arguments.

    ResultError or ScenarioError if the Dataset has no estimates, or muscles that are none.

    >>> estimates = hillobs.estimate("run.csv", "pair.toml", "high_gain", mapping={"position": "block x[mm]"})
    >>> again = hillobs.estimate("run.csv", **hillobs.arguments(estimates))
    >>> again.activation_hat.equals(estimates.activation_hat)
    True
    """
    attributes = _checked(dataset)
    # a result holds the points of a user's curves, and names no file of them
    muscles = subject_again(read_json("muscle_file", str(dataset.muscle_file.values), dict)).described
    # all that was in doubt, whatever is usual by now
    doubt = {"doubt": attributes["doubt"], "usual_doubt": False}
    return {"muscles": muscles, "observers": dataset.observer.values.tolist(), **attributes["settings"], **doubt}
