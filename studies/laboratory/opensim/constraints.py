"""Constraints of a model: none is taken; a coupled coordinate may be locked, which cuts the coupling."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from ...files.errors import ScenarioError
from ...files.quote import shown
from .document import Document

_COUPLER = "CoordinateCouplerConstraint"


def cut(document: Document, held: Collection[str]) -> Iterator[str]:
    """A sentence for each coupling that a lock has cut. ScenarioError for all that still constrains."""
    for constraint in document.members("Constraint"):
        if not constraint.flag("isEnforced", True) or constraint.flag("isDisabled"):
            continue
        name = constraint.words("dependent_coordinate_name") or ""
        if constraint.element.tag != _COUPLER:
            raise ScenarioError(f"{constraint.where}: closes a loop; only trees of joints are read")
        if name not in held:
            raise ScenarioError(
                f"{constraint.where}: {shown(name)} follows other coordinates, which is not read; "
                f"hold it at a number with --lock {name}=…"
            )
        yield f"{name} is locked, which cuts its coupling {shown(constraint.name)}"
