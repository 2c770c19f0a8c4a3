"""The Python of all pages runs as printed, their commands parse, their links lead somewhere, and they are shipped."""

import ast
import doctest
import gzip
import inspect
import itertools
import os
import re
import shlex
import subprocess
import sys
import tomllib
from fnmatch import fnmatch
from importlib.util import find_spec
from pathlib import Path

import click
import matplotlib.pyplot as plt
import pytest

import hillobs
from hillobs.model.curves import CURVES, NGUYEN2019, THELEN2003
from hillobs.observers import OBSERVERS
from hillobs.studies import conformance
from hillobs.studies.cli.main import commands
from hillobs.studies.files.pages import documentation
from hillobs.studies.scenarios.layers import shipped
from hillobs.studies.scenarios.loops import all_paths
from hillobs.studies.scenarios.prepare import prepare
from hillobs.studies.scenarios.scenario import VALID_CHOICES
from places import DATA, DOCS, FENCED, RECORDINGS, ROOT, anchors

README = ROOT / "README.md"
TUTORIALS = sorted((DOCS / "tutorials").glob("*.md"))
PAGES = [README, *sorted(DOCS.glob("*.md")), *sorted((DOCS / "how-to").glob("*.md"))]
# pages in other folders, for their links and commands
OTHERS = [
    *TUTORIALS,
    ROOT / "CHANGELOG.md",
    ROOT / "CONTRIBUTING.md",
    ROOT / "SECURITY.md",
    ROOT / "build" / "README.md",
    ROOT / "codegen" / "kernel" / "README.md",
    RECORDINGS / "README.md",
    ROOT / "tests" / "data" / "README.md",
]


def python_of(page: Path) -> str:
    return "\n".join(re.findall(r"^```python\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE))


def pages_with_python() -> list[Path]:
    return [page for page in PAGES if python_of(page)]


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A reader's folder: the sources, and a recording and its muscles under the names that pages give theirs."""
    (tmp_path / "studies").symlink_to(ROOT / "studies")
    with gzip.open(RECORDINGS / "dgf_smooth_noisy.csv.gz", "rt", encoding="utf-8") as file:
        table = [line.rstrip("\n").split(",") for line in file]
    at = table[0].index("position_measured")
    table[0][at] = "block x"
    for row in table[1:]:
        row[at] = str(float(row[at]) * 1e3)  # millimetres, as the pages say
    (tmp_path / "run.csv").write_text("\n".join(map(",".join, table)), encoding="utf-8")
    (tmp_path / "fitted-run.csv.toml").write_text("kalman.s_D = 0.01\n", encoding="utf-8")
    (tmp_path / "hour.csv.gz").symlink_to(RECORDINGS / "dgf_smooth_noisy.csv.gz")
    for name in ("stretch.toml", "stretch.csv.gz", "maximal.toml", "maximal.csv.gz", "guess.toml"):
        (tmp_path / name).symlink_to(RECORDINGS / name)
    (tmp_path / "pair.toml").symlink_to(RECORDINGS / "dgf_smooth.toml")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("page", pages_with_python(), ids=lambda page: page.name)
def test_the_python_of_a_page_runs(
    page: Path, desk: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    code = python_of(page)
    # an observer of one's own conforms beside the one that the page has compiled it with; beside all in the long run
    monkeypatch.setattr(conformance, "OBSERVERS", {name: OBSERVERS[name] for name in ("high_gain",)})
    if "estimates/estimates.nc" in code:
        # what the page's command has left
        made = "estimate run.csv --muscles pair.toml --map 'position=block x[mm]' --out estimates --no-figures"
        commands(shlex.split(made), standalone_mode=False)
    exec(compile(code, page.name, "exec"), {})  # noqa: S102  the pages are ours
    plt.close("all")
    if page.name == "observers.md":
        assert "conforms" in capsys.readouterr().out.splitlines()


# those that take seconds, for they fit or compile
LONG = ("conformance", "verdict")
FUNCTIONS = [name for name in hillobs.__all__ if inspect.isfunction(getattr(hillobs, name))]


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.chaos] * (name in LONG)) for name in [*FUNCTIONS, "Range"]]
)
def test_the_example_of_a_function_runs_as_printed(name: str, desk: Path) -> None:
    (example,) = doctest.DocTestFinder(recurse=False).find(getattr(hillobs, name), name, globs={"hillobs": hillobs})
    assert example.examples
    said: list[str] = []
    doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE).run(example, out=said.append)
    assert "".join(said) == ""


# ---------------------------------------------------------------- commands

# on a line of its own, and within a sentence
SHOWN = re.compile(r"^ {4}(?:\.venv/bin/)?hillobs( .*)?$", re.MULTILINE)
SHELL = re.compile(r"^```(?:sh|bash|console)\n(.*?)^```", re.DOTALL | re.MULTILINE)
NAMED = re.compile(r"`(?:\.venv/bin/)?hillobs ([^`]+)`")


def arguments(line: str) -> list[str]:
    """The words after `hillobs`, without remarks, optional words in brackets and what the shell reads or writes."""
    given = itertools.takewhile(lambda word: word not in ("<", ">", "|"), shlex.split(line, comments=True))
    return [word for word in given if not word.startswith("[")]


def command_of(given: list[str]) -> tuple[click.Command, list[str]]:
    """The command, which may be one of a group, and the words after its name; the group itself before an option."""
    command: click.Command = commands
    words = list(given)
    while isinstance(command, click.Group) and not words[0].startswith("-"):
        name = words.pop(0)
        inner = command.get_command(click.Context(command), name)
        assert inner is not None, f"there is no `hillobs {name}`"
        command = inner
    return command, words


def parsed(given: list[str]) -> click.Context:
    """The command as click understands it; click.UsageError if it does not."""
    command, rest = command_of(given)
    return command.make_context(given[0], rest, parent=click.Context(commands))


def commands_of(page: Path) -> list[list[str]]:
    text = page.read_text(encoding="utf-8").replace("\\\n", " ")
    shells = "\n".join(f"    {line.removeprefix('$ ')}" for shell in SHELL.findall(text) for line in shell.split("\n"))
    return [given for given in map(arguments, SHOWN.findall(f"{FENCED.sub('', text)}\n{shells}")) if given]


@pytest.mark.parametrize("page", [*PAGES, *OTHERS], ids=lambda page: str(page.relative_to(ROOT)))
def test_the_commands_of_a_page_exist_with_their_options(page: Path, desk: Path) -> None:
    for given in commands_of(page):
        parsed(given)
    for line in NAMED.findall(page.read_text(encoding="utf-8")):
        command, rest = command_of(arguments(" ".join(line.split())))
        options = {option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)}
        assert {word.partition("=")[0] for word in rest if word.startswith("-")} <= options | {"--help"}, line


# what a page asks for that is not here: another host, OpenSim, and what changes the reader's own Python
ELSEWHERE = re.compile(
    r"HOST|^(?:pip install|git clone|openssl) " + ("" if find_spec("opensim") else "|--fit "), re.MULTILINE
)
# a step on a command line, with the lines that it goes on in
INDENTED = re.compile(r"^ {4}((?:zcat\b.*\| *|for\b.*; do )?hillobs\b.*)$", re.MULTILINE)


def scripts_of(page: Path) -> list[str]:
    """What a reader would type, in the order of the page; brackets in a command are words that may be left out."""
    text = page.read_text(encoding="utf-8").replace("\\\n", " ")
    typed = [(found.start(), found[1]) for found in (*SHELL.finditer(text), *INDENTED.finditer(text))]
    lines = [line for _, block in sorted(typed) for line in block.splitlines()]
    return [re.sub(r" \[[A-Z]+\]", "", line) for line in lines if line.strip() and not ELSEWHERE.search(line)]


@pytest.mark.chaos
@pytest.mark.parametrize(
    "page", [page for page in (*PAGES, *TUTORIALS) if scripts_of(page)], ids=lambda page: str(page.relative_to(ROOT))
)
def test_the_commands_of_a_page_run(page: Path, desk: Path) -> None:
    with gzip.open(DATA / "arm26.osim.gz") as model:
        (desk / "arm26.osim").write_bytes(model.read())
    for name in ("arm26_paths.xml", "arm26_paths_order5.xml"):
        (desk / name).symlink_to(DATA / "arm26_paths_order5.xml")
    (desk / "other.csv").write_bytes((desk / "run.csv").read_bytes())
    (desk / "runs").mkdir()
    (desk / "runs" / "one.csv").symlink_to(desk / "run.csv")
    (desk / "my.py").write_text(python_of(DOCS / "observers.md").partition("run = ")[0], encoding="utf-8")
    with gzip.open(RECORDINGS / "dgf_smooth_noisy.csv.gz", "rt", encoding="utf-8") as file:
        measured = [",".join(line.split(",")[:4]).replace("_measured", "") for line in file]
    (desk / "samples.csv").write_text("\n".join(measured), encoding="utf-8")
    clock = [
        f"{float(t) * 1e3:.12g},{float(x) * 1e3},{rest}" for t, x, rest in (line.split(",", 2) for line in measured[1:])
    ]
    named = "clock,block x,biceps,/forceset/triceps|tendon_force"
    (desk / "lab.csv").write_text("\n".join([named, *clock]), encoding="utf-8")
    program = re.search(r"^```py\n(.*?)^```", page.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    (desk / "meet.py").write_text(program[1] if program else "", encoding="utf-8")
    tools = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    for line in scripts_of(page):
        done = subprocess.run(["bash", "-c", line], cwd=desk, env=tools, capture_output=True, text=True, check=False)
        # of observability 1 is the answer that the rank is deficient
        assert done.returncode in ((0, 1) if "hillobs observability" in line else (0,)), (line, done.stderr)


def test_the_numbers_that_shown_commands_change_exist() -> None:
    # the last one is of the pages' own observer
    paths = {"seed", *VALID_CHOICES, "mine.gain"}
    for of in (all_paths((), NGUYEN2019), all_paths((), THELEN2003), all_paths((), NGUYEN2019, corrected=True)):
        paths |= of.parameters.keys() | of.groups().keys()
    of_arm = prepare("arm", "high_gain", {}).paths
    paths |= of_arm.parameters.keys() | of_arm.groups().keys()
    text = "\n".join(page.read_text(encoding="utf-8") for page in (*PAGES, *OTHERS))
    changed = set(re.findall(r"--(?:set|over|zip|design) +([a-z_]\w*(?:\.\w+)*)=", text))
    assert len(changed) > 5
    assert changed <= paths


def test_a_wrong_command_is_found() -> None:
    with pytest.raises(AssertionError, match="no `hillobs nonsense`"):
        parsed(["nonsense"])
    with pytest.raises(click.UsageError, match="--nonsense"):
        parsed(arguments("simulate paper-clean --nonsense 3  # a remark"))


def test_every_scenario_observer_and_curve_set_is_told_of() -> None:
    text = "\n".join(page.read_text(encoding="utf-8") for page in PAGES)
    for name in (*shipped(), *OBSERVERS, *CURVES):
        assert f"`{name}`" in text, name


def test_the_messages_that_a_page_explains_are_those_that_are_said() -> None:
    said = set[str]()
    for file in (file for part in ("codegen", "hillobs", "studies") for file in (ROOT / part).rglob("*.py")):
        constants = (
            node.value
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
            if isinstance(node, ast.Constant)
        )
        said |= {words for words in constants if isinstance(words, str)}
    page = (DOCS / "how-to" / "messages.md").read_text(encoding="utf-8")
    explained = re.findall(r"^\| `(.*?)` \|", page, re.MULTILINE)
    assert len(explained) > 20
    for message in explained:
        for part in filter(None, map(str.strip, message.split("…"))):
            assert any(part in words for words in said), (message, part)


def test_the_targets_of_make_that_pages_name_exist() -> None:
    targets = set(re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    text = "\n".join(page.read_text(encoding="utf-8") for page in (*PAGES, *OTHERS))
    assert set(re.findall(r"(?:`|^    )make ([a-z]+)", text, re.MULTILINE)) <= targets


# ---------------------------------------------------------------- links


def links(page: Path) -> list[str]:
    """The targets of links and pictures that are not elsewhere."""
    found = re.findall(r"\]\(([^)\s]+)\)", FENCED.sub("", page.read_text(encoding="utf-8")))
    return [target for target in found if not re.match(r"[a-z]+:", target)]


@pytest.mark.parametrize("page", [*PAGES, *OTHERS], ids=lambda page: str(page.relative_to(ROOT)))
def test_the_links_of_a_page_lead_somewhere(page: Path) -> None:
    for target in links(page):
        path, _, anchor = target.partition("#")
        there = page.parent / path if path else page
        assert there.exists(), target
        assert not anchor or anchor in anchors(there), target


# ---------------------------------------------------------------- an installed copy


def test_the_documentation_is_where_an_installed_copy_looks_for_it() -> None:
    assert documentation() == DOCS
    assert {"model.md", "observers.md", "errata.md"} <= {path.name for path in documentation().iterdir()}


def test_an_installed_copy_has_all_pages_and_their_pictures() -> None:
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    assert settings["package-dir"]["hillobs.docs"] == DOCS.name
    assert "hillobs.docs" in settings["packages"]
    patterns = settings["package-data"]["hillobs.docs"]
    pages = [page for page in PAGES if page != README] + TUTORIALS
    pictures = {(page.parent / link).name for page in pages for link in links(page) if link.endswith(".png")}
    missing = [
        name
        for name in (*(str(page.relative_to(DOCS)) for page in pages), *pictures)
        if not any(fnmatch(name, pattern) for pattern in patterns)
    ]
    assert missing == []
