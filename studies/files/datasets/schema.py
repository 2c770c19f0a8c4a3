"""What a kind of result must have, so that reports and figures can rely on it: a file may have been made by others."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, get_args, get_origin

import numpy as np
import xarray as xr

from ....model.arrays import is_number
from ..errors import ResultError
from ..quote import short, shown

# kinds of arrays of NumPy
FLOATS, WHOLES, FLAGS, TEXTS = "f", "iu", "iub", "UO"
# what observers and the like may be called, as Blocks are
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")


@dataclass(frozen=True)
class Schema:
    """Variables: name → dimensions and kinds of numbers; attributes: name → the type of the text or, as JSON, in it.

    labels: coordinate → all labels it must have; None for any different names.
    """

    variables: Mapping[str, tuple[tuple[str, ...], str]]
    attributes: Mapping[str, Any]
    labels: Mapping[str, tuple[object, ...] | None] = field(default_factory=dict)
    optional: Mapping[str, tuple[tuple[str, ...], str]] = field(default_factory=dict)

    def check(self, dataset: xr.Dataset) -> dict[str, Any]:
        """The attributes, those in JSON read. ResultError says what is missing or of another form."""
        there = {name: about for name, about in self.optional.items() if name in dataset}
        for name, (dimensions, kinds) in {**self.variables, **there}.items():
            if name not in dataset.variables:
                raise ResultError(f"it has no {name}")
            variable = dataset.variables[name]
            texts = variable.dtype.kind != "O" or all(isinstance(text, str) for text in variable.values.ravel())
            if variable.dims != dimensions or variable.dtype.kind not in kinds or not texts:
                raise ResultError(f"its {name} has other dimensions, or other values, than a result of hillobs")
        for name, labels in self.labels.items():
            _check_labels(dataset, name, labels)
        return {name: _attribute(dataset, name, form) for name, form in self.attributes.items()}


def rising(dataset: xr.Dataset, name: str) -> None:
    """ResultError unless a coordinate has finite numbers, at least one, that rise strictly."""
    values = dataset[name].values
    if not len(values) or not np.isfinite(values).all() or not (np.diff(values) > 0).all():
        raise ResultError(f"its {name} does not rise")


def read_json(name: str, text: str, form: Any) -> Any:  # noqa: ANN401 — what JSON holds
    """The JSON in `text`, of the type `form`. ResultError if it is none, or of another."""
    try:
        value = json.loads(text)
        fine = _has_form(value, form)
    except (ValueError, RecursionError, OverflowError) as error:
        raise ResultError(f"its {name} cannot be read: {short(str(error))}") from error
    if not fine:
        raise ResultError(f"its {name} has another form than a result of hillobs")
    return value


def _check_labels(dataset: xr.Dataset, name: str, labels: tuple[object, ...] | None) -> None:
    if name not in dataset.variables or dataset[name].dims != (name,):
        raise ResultError(f"it has no {name}")
    there = dataset[name].values.tolist()
    if labels is None:
        fine = there and all(isinstance(label, str) and _NAME.fullmatch(label) for label in there)
        if not fine or len(set(there)) < len(there):
            raise ResultError(f"its {name} must be different names, not {shown(there)}")
    elif there != list(labels):
        raise ResultError(f"its {name} must be {', '.join(map(str, labels))}, not {shown(there)}")


def _attribute(dataset: xr.Dataset, name: str, form: Any) -> Any:  # noqa: ANN401 — as declared
    value = dataset.attrs.get(name)
    if not isinstance(value, str):
        raise ResultError(f"it has no text {name}")
    return value if form is str else read_json(name, value, form)


def _has_form(value: object, form: Any) -> bool:  # noqa: ANN401 — a type such as dict[str, float]
    """Whether a value of JSON is of a type; float stands for every finite number, a table of types for its names."""
    if isinstance(form, dict):
        if not isinstance(value, dict) or value.keys() != form.keys():
            return False
        return all(_has_form(value[key], form[key]) for key in form)
    if get_origin(form) is dict:
        return isinstance(value, dict) and all(_has_form(inner, get_args(form)[1]) for inner in value.values())
    if get_origin(form) is list:
        return isinstance(value, list) and all(_has_form(inner, get_args(form)[0]) for inner in value)
    if form is float:
        return is_number(value) and math.isfinite(value)
    return type(value) is form
