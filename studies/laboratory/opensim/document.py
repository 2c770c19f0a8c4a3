"""An OpenSim document: its model, its default objects, and properties of its components by their tags."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from ...files.errors import ScenarioError
from ...files.numbers import parse_number
from ...files.quote import short, shown
from .xml import Element, read_xml

_ROOT = "OpenSimDocument"
# what classes of a kind end with
_KINDS: Mapping[str, tuple[str, ...]] = {
    "Body": ("Body",),
    "Joint": ("Joint",),
    "Constraint": ("Constraint",),
    "Force": ("Muscle", "Force"),
    "Marker": ("Marker",),
}


def listed(names: Iterable[str]) -> str:
    """Names of others with commas between, of many only the first and the last."""
    return short(", ".join(names))


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
        return f"{short(self.element.tag)} {shown(self.name)}, line {self.element.line}"

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

    def flag(self, tag: str, default: bool = False) -> bool:
        """Whether a property says true; `default` if it is missing or empty."""
        words = self.words(tag)
        return words.lower() in ("true", "1") if words else default


@dataclass(frozen=True)
class Document:
    """The model of a file, and default objects by their class."""

    model: Element
    defaults: dict[str, Element]

    def component(self, element: Element) -> Component:
        """An object with its defaults."""
        return Component(element, self.defaults.get(element.tag))

    def members(self, kind: str) -> list[Component]:
        """The objects of one of the model's sets, such as BodySet for the kind Body, and those of the kind beside."""
        objects = self.model.within(f"{kind}Set", "objects")
        found = list(objects.children) if objects else []
        for place in (self.model.child("components"), self.model.within("ComponentSet", "objects")):
            found += [element for element in (place.children if place else []) if element.tag.endswith(_KINDS[kind])]
        return [self.component(element) for element in found]


def read_document(path: Path) -> Document:
    """The model of an .osim file. ScenarioError says why it has none."""
    root = read_root(path)
    model = root.child("Model")
    if model is None:
        raise ScenarioError(f"has no Model, but {listed(child.tag for child in root.children) or 'nothing'}")
    # older versions keep them in the model
    holders = [found for place in (root, model) if (found := place.child("defaults")) is not None]
    return Document(model, {default.tag: default for holder in holders for default in holder.children})


def read_root(path: Path) -> Element:
    """The root of a file that OpenSim has written. ScenarioError if it is something else."""
    root = read_xml(path)
    if root.tag != _ROOT:
        raise ScenarioError(f"is no OpenSim file: it holds {shown(root.tag)}, not {_ROOT}")
    return root
