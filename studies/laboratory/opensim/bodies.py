"""Bodies of a model as links, in the forms of both versions."""

from __future__ import annotations

from ....model.skeleton.tree import GROUND, Link
from ...files.errors import ScenarioError
from ...files.quote import shown
from .document import Component, Document
from .frames import vector

# an older version has the six of them one by one
_INERTIA = ("inertia_xx", "inertia_yy", "inertia_zz", "inertia_xy", "inertia_xz", "inertia_yz")


def bodies(document: Document) -> dict[str, Component]:
    """The bodies by name, without the ground. ScenarioError if two have one name."""
    found: dict[str, Component] = {}
    for body in document.members("Body"):
        if body.element.tag == "Body" and body.name != GROUND:
            if body.name in found:
                raise ScenarioError(f"{body.where}: there is another body {shown(body.name)}")
            found[body.name] = body
    if not found:
        raise ScenarioError("has no bodies")
    return found


def link(body: Component) -> Link:
    """Mass, its centre, and the inertia about that. ScenarioError if one is no number or missing."""
    single = body.child("inertia") is None and body.child(_INERTIA[0]) is not None
    inertia = [body.number(tag) for tag in _INERTIA] if single else body.numbers("inertia", 6)
    return Link(body.number("mass"), vector(body.numbers("mass_center", 3, (0.0, 0.0, 0.0))), tuple(inertia))
