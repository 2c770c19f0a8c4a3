"""Markers of a model as points of its links."""

from __future__ import annotations

from collections.abc import Container

from ....model.skeleton.points import Point
from .document import Component, Document
from .frames import vector
from .names import plain

# the frame in versions 4, and the body before
_FRAMES = ("socket_parent_frame", "body", "socket_parent_frame_connectee_name")


def markers(document: Document, links: Container[str], taken: Container[str]) -> dict[str, Point]:
    """The markers on links that have a name of their own; those on other frames, and of names taken, are left out.

    ScenarioError for one whose location is none.
    """
    points: dict[str, Point] = {}
    for marker in document.members("Marker"):
        link, name = _frame(marker).rpartition("/")[2], plain(marker.name)
        if marker.element.tag == "Marker" and link in links and name not in taken:
            points[name] = Point(link, vector(marker.numbers("location", 3)))
    return points


def _frame(marker: Component) -> str:
    return next((words for tag in _FRAMES if (words := marker.words(tag))), "")
