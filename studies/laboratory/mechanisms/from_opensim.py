"""An OpenSim model as a mechanism."""

from __future__ import annotations

from ..opensim.model import OpenSimModel
from .mechanism import Mechanism, is_name
from .paths import path_over
from .reading import mechanism_of
from .writing import mechanism_file


def mechanism_from(model: OpenSimModel, source: str) -> Mechanism:
    """The mechanism of a model that was read from a file of this name. ScenarioError says what is wrong.

    Its numbers are within the ranges of a mechanism file, and it is what is read from such a file.
    """
    words = " ".join(model.credits.split())
    mechanism = Mechanism(
        model.tree,
        model.muscles,
        {name: path_over(name, path, model.joints, model.held) for name, path in model.polynomials.items()},
        f"{model.name or 'a model'} from {source}" + (f"; credits: {words}" if words else ""),
        {name: point for name, point in model.points.items() if is_name(name)},
    )
    return mechanism_of(mechanism_file(mechanism))
