"""The site of all pages: it is made without a warning, its tutorials run, and every page of it opens whole."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from hillobs.studies.scenarios.loops import all_paths
from places import DOCS, ROOT
from tools import CHROMIUM, needs_chromium

pytest.importorskip("sphinx", reason="the extra `docs` is not installed")
sync_api = pytest.importorskip("playwright.sync_api")

PHONE = {"width": 390, "height": 844}
BROKEN = """---
file_format: mystnb
kernelspec:
  name: python3
---
# A page

```{code-cell}
assert 1 == 2
```
"""

pytestmark = pytest.mark.chaos


def made(pages: Path, folder: Path) -> subprocess.CompletedProcess[str]:
    """The site of some pages, as `make docs` makes it."""
    sphinx = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-c", DOCS / "_site", "-b", "html"]
    return subprocess.run([*sphinx, pages, folder], cwd=ROOT, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("site") / "html"
    done = made(DOCS, folder)
    assert done.returncode == 0, done.stderr
    return folder


@needs_chromium
def test_every_page_opens_without_a_word_and_fits_a_phone(site: Path) -> None:
    with sync_api.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"])
        opened = 0
        # the theme has templates of its own among what it brings
        for file in sorted(file for file in site.rglob("*.html") if "_static" not in file.parts):
            complaints: list[str] = []
            page = browser.new_page(viewport=PHONE)
            page.on("console", lambda message, said=complaints: message.type == "error" and said.append(message.text))
            page.on("pageerror", lambda error, said=complaints: said.append(str(error)))
            page.on("requestfailed", lambda request, said=complaints: said.append(request.url))
            page.on("request", lambda request, said=complaints: "://" in request.url[6:] and said.append(request.url))
            page.goto(file.as_uri())
            pictures = page.evaluate("[...document.images].filter((one) => !one.naturalWidth).map((one) => one.src)")
            width = page.evaluate("document.documentElement.scrollWidth")
            assert (complaints, pictures, width) == ([], [], PHONE["width"]), file.name
            page.close()
            opened += 1
        browser.close()
    assert opened > len(list(DOCS.glob("*.md")))


def test_the_tables_name_all_numbers_and_all_variables(site: Path) -> None:
    numbers, results = ((site / f"{name}.html").read_text(encoding="utf-8") for name in ("parameters", "datasets"))
    named = re.findall(r"<td>.*?<span class=\"pre\">(.*?)</span>", numbers)
    assert {path for path, about in all_paths().parameters.items() if about.shared in ("", path)} <= set(named)
    for variable in ("x_hat", "failed_at", "activation_sd"):
        assert re.search(rf"<td>.*?<span class=\"pre\">{variable}</span>", results)


def test_a_broken_block_fails_the_build(tmp_path: Path) -> None:
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "index.md").write_text(BROKEN, encoding="utf-8")
    done = made(tmp_path / "docs", tmp_path / "html")
    assert done.returncode != 0
    assert "AssertionError" in done.stderr + done.stdout
