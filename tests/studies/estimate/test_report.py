"""The report for a browser: whole in one file, loads and runs nothing, shows the words of others as words."""

import base64
import hashlib
import json
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path

import pytest
import xarray as xr

from hillobs.studies.cli.reports.estimates.estimate_page import estimate_page
from hillobs.studies.cli.reports.number import number
from hillobs.studies.estimate.scores import scores
from places import contents
from shipped_recording import MUSCLES, SHIPPED

PNG = b"\x89PNG not a picture"
HOSTILE = "</title><script>alert(1)</script>\x1b[31m\u202e\"'&$body<img src=//x.example/>"


class Page(HTMLParser):
    """Tags with their attributes, and the words in each kind of tag."""

    def __init__(self, page: bytes) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.words: dict[str, list[str]] = {}
        self._open: list[str] = []
        self.feed(page.decode())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag not in ("meta", "img"):
            self._open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self._open:
            self.words.setdefault(self._open[-1], []).append(data)

    def attributes(self, tag: str) -> list[dict[str, str | None]]:
        return [attributes for name, attributes in self.tags if name == tag]


@pytest.fixture(scope="module")
def two(noisy: xr.Dataset) -> xr.Dataset:
    return noisy.sel(observer=["high_gain", "kalman"])


def test_the_page_says_verdict_scores_settings_and_versions(two: xr.Dataset) -> None:
    page = Page(estimate_page(two, scores(two), ["The data prefer a longer tendon.", "  by 2 %"], PNG))
    assert page.words["h1"] == ["Estimates from dgf_smooth_noisy.csv.gz"]
    assert page.words["h2"][0] == "Verdict"
    assert page.words["li"][:2] == ["The data prefer a longer tendon.", "by 2 %"]
    cells = [*page.words["th"], *page.words["td"]]
    errors = [number(s.rmse) for s in scores(two) if (s.quantity, s.muscle) == ("activation", "both")]
    for word in ("HGO", "KF", "activation", *errors, "optimal_fibre_length", "corrected", "casadi"):
        assert word in cells
    (picture,) = page.attributes("img")
    assert base64.b64decode(picture["src"].removeprefix("data:image/png;base64,")) == PNG
    # nobody has judged, and nothing is known
    alone = two.drop_vars([name for name in two if str(name).startswith("true_")])
    assert "Verdict" not in Page(estimate_page(alone, [], [], PNG)).words["h2"]


def test_the_page_loads_and_runs_nothing_and_its_policy_allows_no_more(two: xr.Dataset) -> None:
    page = Page(estimate_page(two, scores(two), [HOSTILE], PNG))
    (policy,) = (a["content"] for a in page.attributes("meta") if a.get("http-equiv") == "Content-Security-Policy")
    (style,) = page.words["style"]
    digest = base64.b64encode(hashlib.sha256(style.encode()).digest()).decode()
    allowed = dict(rule.split(" ", 1) for rule in policy.split("; "))
    assert allowed.pop("img-src") == "data:"
    assert allowed.pop("style-src") == f"'sha256-{digest}'"
    assert allowed["default-src"] == "'none'"
    assert set(allowed.values()) == {"'none'"}
    assert {tag for tag, _ in page.tags}.isdisjoint({"script", "link", "iframe", "object", "base", "form", "a"})
    for tag, attributes in page.tags:
        assert not [name for name in attributes if name.startswith("on") or name in ("style", "href")]
        assert attributes.get("src", "data:").startswith("data:"), tag
    assert "url(" not in style
    assert "@import" not in style


def test_words_of_others_stay_words(two: xr.Dataset) -> None:
    plain = Page(estimate_page(two, scores(two), ["fine"], PNG))
    settings = {**json.loads(two.attrs["settings"]), "mapping": {"<i>": "<b>"}}
    hostile = two.assign_attrs(source=HOSTILE, settings=json.dumps(settings))
    written = estimate_page(hostile, scores(hostile), [HOSTILE], PNG)
    page = Page(written)
    seen = HOSTILE.replace("\x1b", "\\x1b").replace("\u202e", "\\u202e")
    assert page.words["title"] == [f"Estimates from {seen}"]
    assert page.words["li"][0] == seen
    assert "mapping.<i>" in page.words["th"]
    assert "<b>" in page.words["td"]
    kinds = {tag for tag, _ in plain.tags}
    assert {tag for tag, _ in page.tags} == kinds
    assert len(page.attributes("img")) == 1
    assert written.decode().replace("\n", "").isprintable()


def test_a_report_is_written_like_all_files_and_none_is_left_that_is_of_before(
    command: Callable[..., tuple[int, str, str]],
) -> None:
    arguments = ("estimate", str(SHIPPED), "--muscles", str(MUSCLES), "--every", "40", "--observer", "high_gain")
    report = Path("estimates", "estimates.html")
    code, out, _ = command(*arguments, "--no-figures", "--report")
    assert code == 0
    assert "estimates.html" in out
    assert not [name for name in contents(report.parent) if name.endswith(".png")]
    # an older report would pass for one of the new estimates
    assert command(*arguments, "--no-figures")[0] == 0
    assert not report.exists()
    report.write_text("mine")
    code, _, err = command(*arguments, "--no-figures", "--report")
    assert (code, report.read_text()) == (2, "mine")
    assert "estimates.html is there already, and not as hillobs wrote it" in err
    assert command(*arguments, "--no-figures")[0] == 0
    assert report.read_text() == "mine"
