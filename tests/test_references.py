"""Labels of the paper that the sources name are labels of the paper, and pages that they name have that heading."""

import io
import itertools
import re
import tokenize
from collections.abc import Iterator
from pathlib import Path

import pytest

from hillobs.model.curves import CURVES
from hillobs.studies.scenarios.loops import all_paths
from labels import homes, linked
from places import DATA, DOCS, ROOT, anchors

FOLDERS = ("model", "observers", "codegen", "studies", "hillobs", "benchmarks", "tests", "docs", "build")
WRITTEN = {".py", ".md", ".toml", ".hpp", ".cpp", ".c", ".cff"}
# where equations stand: a word in brackets is a label of the paper there, and no unit or table of TOML
EQUATIONS = ("model", "observers", "studies/errata", "tests/oracles", "tests/studies/errata")
PAGES = ("model.md", "observers.md", "errata.md", "gains.md")

LABELS = set((DATA / "paper_labels.txt").read_text(encoding="utf-8").split())
# [load1], or several, [dotla, rhoa0]; [low, high] is an interval
LABEL = re.compile(r"(?<![\w\])])\[([A-Za-z]\w*(?:, [A-Za-z]\w*)*)\](?!\()")
PAGE = re.compile(r"docs/([\w-]+\.md)(?:#([\w-]+)| ([CO]\d+))?")


def written() -> Iterator[Path]:
    """All that people have written in this repository."""
    tops = (path for path in ROOT.iterdir() if path.is_file())
    inside = (path for folder in FOLDERS for path in (ROOT / folder).rglob("*") if "cache" not in path.parts)
    return (path for path in itertools.chain(tops, inside) if path.suffix in WRITTEN or path.name == "Makefile")


def words(path: Path) -> str:
    """What is said in a file: comments and strings of Python, all of a page."""
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        return text
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    return "\n".join(token.string for token in tokens if token.type in (tokenize.COMMENT, tokenize.STRING))


def names(page: Path) -> set[str]:
    """What a source may name of a page: its headings, and errata by their number."""
    return anchors(page) | set(re.findall(r"^\*\*([CO]\d+)\.\*\*", page.read_text(encoding="utf-8"), re.MULTILINE))


def unknown_references(text: str) -> list[str]:
    """Pages, headings and errata that a text names and that are not there."""
    return [
        found[0]
        for found in PAGE.finditer(text)
        for page, name in [(DOCS / found[1], found[2] or found[3])]
        if not page.is_file() or (name and name not in names(page))
    ]


def test_every_label_is_one_of_the_paper() -> None:
    sources = [path for folder in EQUATIONS for path in sorted((ROOT / folder).rglob("*.py"))]
    named = {
        (path.name, label)
        for path in (*sources, *(DOCS / page for page in PAGES))
        for group in (found.split(", ") for found in LABEL.findall(words(path)))
        for label in group
        if len(group) == 1 or LABELS.intersection(group)
    }
    assert {entry for entry in named if entry[1] not in LABELS} == set()
    # the plant and all three observers are among them
    assert {"load1", "lsdot2", "HO3b", "SO3b", "AO3b", "draj"} <= {label for _, label in named}


def test_every_label_of_the_sources_leads_to_its_equation() -> None:
    sources = [path for folder in EQUATIONS[:3] for path in sorted((ROOT / folder).rglob("*.py"))]
    named = {label for path in sources for group in LABEL.findall(words(path)) for label in group.split(", ")} & LABELS
    home = homes()
    assert named - set(home) == set()
    # those of the system and of the observers where these are, not where their errata are
    assert {home[label][0] for label in ("x2d", "kappa", "HO1a", "HO2b", "rhoa0", "SO3b")} == {"model", "observers"}
    text = linked("[HO1a]–[HO3b] and `[HO1a]`, [x2d], [low, high]", "gains", home)
    assert text == (
        '[<a class="equation" href="observers.html#eq-HO1a">HO1a</a>]–[<a class="equation" '
        'href="observers.html#eq-HO3b">HO3b</a>] and `[HO1a]`, [<a class="equation" '
        'href="model.html#eq-x2d">x2d</a>], [low, high]'
    )


def test_every_page_that_is_named_has_that_heading() -> None:
    unknown = {(str(path.relative_to(ROOT)), name) for path in written() for name in unknown_references(words(path))}
    assert unknown == set()


def test_an_unknown_page_heading_or_erratum_is_found() -> None:
    folder = "docs"
    wrong = [f"{folder}/nowhere.md", f"{folder}/model.md#nothing", f"{folder}/errata.md C99"]
    right = [f"{folder}/model.md", f"{folder}/model.md#noise", f"{folder}/errata.md C11"]
    assert unknown_references(", ".join((*right, *wrong))) == wrong


def test_sections_are_those_of_the_paper() -> None:
    # Roman numbers: any other section is one of a text that is not here
    sections = {(path.name, number) for path in written() for number in re.findall(r"§\s*(\w+)", words(path))}
    assert {(name, number) for name, number in sections if not re.fullmatch(r"[IVX]+", number)} == set()


@pytest.mark.parametrize("curves", CURVES.values(), ids=CURVES)
def test_every_number_names_where_it_comes_from(curves) -> None:
    known = ("paper", "chosen", "derived", "docs/", "OpenSim")
    sources = {path: parameter.source for path, parameter in all_paths((), curves).parameters.items()}
    assert {path: source for path, source in sources.items() if not source.startswith(known)} == {}
