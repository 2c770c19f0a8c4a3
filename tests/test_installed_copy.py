"""An installed copy has all that the repository has: pyproject.toml names each package and its data by hand."""

import tomllib
from fnmatch import fnmatch
from pathlib import Path

import pytest

from places import ROOT

SETTINGS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
# folder → package
ROOTS = {folder: name for name, folder in SETTINGS["package-dir"].items() if name != "hillobs.docs"}


def package_of(folder: Path) -> str:
    first, *rest = folder.relative_to(ROOT).parts
    return ".".join([ROOTS[first], *rest])


def test_every_package_is_named() -> None:
    there = {package_of(file.parent) for folder in ROOTS for file in (ROOT / folder).rglob("__init__.py")}
    assert there == {*SETTINGS["packages"]} - {"hillobs.docs"}


@pytest.mark.parametrize("folder", ROOTS)
def test_every_file_beside_the_code_is_its_data(folder: str) -> None:
    """Of the nearest package above it."""
    missing = []
    for file in (ROOT / folder).rglob("*"):
        if not file.is_file() or file.suffix in (".py", ".pyc"):
            continue
        package = next(above for above in file.parents if (above / "__init__.py").exists())
        patterns = SETTINGS["package-data"].get(package_of(package), [])
        if not any(fnmatch(str(file.relative_to(package)), pattern) for pattern in patterns):
            missing.append(file.relative_to(ROOT))
    # an explanation for who reads the code
    assert [file for file in missing if file.name != "README.md"] == []
