"""An OpenSim document: its model, its default objects, and properties of its components by their tags."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ...files.errors import ScenarioError
from ...files.numbers import parse_number
from ...files.quote import shown
from .xml import Element, read_xml

_ROOT = "OpenSimDocument"


@dataclass(frozen=True)
class Component:
    """An object of a document; what it does not say itself, the default object of its class says."""

    element: Element
    default: Element | None = None

    @property
    def name(self) -> str:
        """As the document has it."""
        return self.element.name

    @property
    def where(self) -> str:
        """How a sentence names it."""
        return f"{self.element.tag} {shown(self.name)}, line {self.element.line}"

    def child(self, tag: str) -> Element | None:
        """The first element with this tag that it or the default object holds."""
        own = self.element.child(tag)
        return own if own is not None or self.default is None else self.default.child(tag)

    def words(self, tag: str) -> str | None:
        """The words of a property without blanks around them, or None if it has none."""
        found = self.child(tag)
        return (found.words.strip() or None) if found else None

    def number(self, tag: str, default: float | None = None) -> float:
        """A number. ScenarioError if it is none, or missing without a default."""
        return default if default is not None and self.words(tag) is None else self.numbers(tag, 1)[0]

    def numbers(self, tag: str, count: int | None = None, default: tuple[float, ...] | None = None) -> list[float]:
        """So many numbers, or as many as there are. ScenarioError as above."""
        words = self.words(tag)
        if words is None:
            if default is None:
                raise ScenarioError(f"{self.where} has no {tag}")
            return list(default)
        found = [parse_number(f"{self.where}: {tag}", word) for word in words.split()]
        if count is not None and len(found) != count:
            raise ScenarioError(f"{self.where}: {tag} must be {count} numbers, not {shown(words)}")
        return found

    def flag(self, tag: str) -> bool:
        """Whether a property says true; what is missing does not."""
        return (self.words(tag) or "").lower() in ("true", "1")


@dataclass(frozen=True)
class Document:
    """The model of a file, and default objects by their class."""

    model: Element
    defaults: dict[str, Element]

    def component(self, element: Element) -> Component:
        """An object with its defaults."""
        return Component(element, self.defaults.get(element.tag))

    def members(self, set_tag: str) -> list[Component]:
        """The objects of one of the model's sets, such as BodySet."""
        objects = self.model.within(set_tag, "objects")
        return [self.component(element) for element in (objects.children if objects else [])]


def read_document(path: Path) -> Document:
    """The model of an .osim file. ScenarioError says why it has none."""
    root = read_root(path)
    model = root.child("Model")
    if model is None:
        raise ScenarioError(f"has no Model, but {', '.join(child.tag for child in root.children) or 'nothing'}")
    # older versions keep them in the model
    holders = [found for place in (root, model) if (found := place.child("defaults")) is not None]
    return Document(model, {default.tag: default for holder in holders for default in holder.children})


def read_root(path: Path) -> Element:
    """The root of a file that OpenSim has written. ScenarioError if it is something else."""
    root = read_xml(path)
    if root.tag != _ROOT:
        raise ScenarioError(f"is no OpenSim file: it holds {shown(root.tag)}, not {_ROOT}")
    return root
