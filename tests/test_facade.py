"""`import hillobs` is the door: it shows what there is, opens quickly, and nothing else is needed."""

import dataclasses
import inspect
import pydoc
import re
import subprocess
import sys

import pytest

import hillobs
from places import DOCS, ROOT


def test_every_public_name_is_there_and_shown() -> None:
    assert dir(hillobs) == sorted(hillobs.__all__)
    shown = pydoc.plain(pydoc.render_doc(hillobs))
    for name in hillobs.__all__:
        assert getattr(hillobs, name) is not None
        assert name in shown or name == "__version__"


def test_a_name_that_is_not_there_is_answered_with_those_that_are() -> None:
    with pytest.raises(AttributeError, match=r"no attribute 'simulat'; there are .*simulate"):
        hillobs.simulat  # noqa: B018  the question is what it answers


def test_it_opens_without_the_heavy_modules() -> None:
    code = "import sys, hillobs; sys.exit(any(m in sys.modules for m in ('casadi', 'numpy', 'xarray', 'matplotlib')))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_every_error_is_a_hillobs_error_and_says_what_it_is() -> None:
    errors = [getattr(hillobs, name) for name in hillobs.__all__ if name.endswith("Error")]
    assert len(errors) > 5
    assert all(issubclass(error, hillobs.Error) for error in errors)
    for wrong in (
        lambda: hillobs.simulate("nothing"),
        lambda: hillobs.sweep("paper-clean", {"plant.mass": [1.0]}),
        lambda: hillobs.estimate("nothing.csv", "nothing.toml"),
        lambda: hillobs.observability(sensors=["x9"]),
        lambda: hillobs.load("nothing.nc"),
        lambda: hillobs.read_recording("nothing.csv"),
        lambda: hillobs.read_muscles("nothing.toml"),
        lambda: hillobs.Block("a block", x=hillobs.symbols("x")),
    ):
        with pytest.raises(hillobs.Error):
            wrong()


# "The other arguments are those of `simulate`": what a docstring leaves to another one
THOSE_OF = re.compile(r"arguments are those of `(\w+)`")
# what cannot go wrong
SURE = ("symbols", "constant_moment_arms")


def described(name: str) -> str:
    text = inspect.getdoc(getattr(hillobs, name)) or ""
    return " ".join([text, *(described(other) for other in THOSE_OF.findall(text))])


def test_no_signature_shows_an_address() -> None:
    for name in hillobs.__all__:
        if inspect.isfunction(thing := getattr(hillobs, name)):
            assert " at 0x" not in str(inspect.signature(thing)), name


def test_every_argument_and_field_is_described_and_every_function_says_how_it_fails() -> None:
    for name in hillobs.__all__:
        thing = getattr(hillobs, name)
        if inspect.isfunction(thing):
            parts = list(inspect.signature(thing).parameters)
            assert name in SURE or re.search(r"\b[A-Z]\w+Error\b", described(name)), name
        else:
            parts = [part.name for part in dataclasses.fields(thing)] if dataclasses.is_dataclass(thing) else []
        assert [part for part in parts if not re.search(rf"\b{part}\b", described(name))] == [], name


# what makes a table and is not shown to the reader
UNSHOWN = re.compile(r"^```\{code-cell\}\n:tags: \[remove-input\].*?^```", re.MULTILINE | re.DOTALL)


def test_the_pages_import_nothing_else() -> None:
    for page in (ROOT / "README.md", *DOCS.glob("*.md"), *DOCS.glob("tutorials/*.md")):
        shown = UNSHOWN.sub("", page.read_text(encoding="utf-8"))
        inner = re.findall(r"^\s*(?:from|import) (hillobs\.\S+)", shown, re.MULTILINE)
        assert inner == [], page


def test_every_public_name_is_in_the_reference() -> None:
    reference = (DOCS / "reference.md").read_text(encoding="utf-8")
    described = re.findall(r"^\.\. (?:auto\w+|py:data):: hillobs\.(\w+)$", reference, re.MULTILINE)
    assert sorted(described) == sorted(set(hillobs.__all__) - {"__version__"})
