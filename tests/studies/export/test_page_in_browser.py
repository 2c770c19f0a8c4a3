"""Pages in Chromium: what people see, press, move and link to."""

import re
from pathlib import Path
from statistics import median

import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from hillobs.codegen.targets import page as writer
from hillobs.studies.export.pages import export_page
from tools import CHROMIUM, needs_chromium, needs_zig

DESKTOP, PHONE = {"width": 1360, "height": 900}, {"width": 390, "height": 844}
# so many positions of a slider, one after the other
DRAGGED = 60
# the gains that a sweep is about
GAINS = {
    "high_gain.eps_h": "high_gain",
    "sliding_mode.delta_s": "sliding_mode",
    "adaptive_sliding_mode.delta_a": "adaptive_sliding_mode",
}

pytestmark = [
    pytest.mark.chaos,
    needs_chromium,
    # of Playwright's own, when an event loop is closed
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]


@pytest.fixture(scope="module")
def browser():
    with sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox", "--disable-gpu"])
        yield chromium
        chromium.close()


@pytest.fixture(scope="module", params=["javascript", pytest.param("webassembly", marks=needs_zig)])
def file(request, tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        if request.param == "javascript":
            patch.setattr(writer, "webassembly", lambda calls: None)
        return export_page("paper-noisy", tmp_path_factory.mktemp(request.param) / "page.html")


def opened(browser: Browser, file: Path, link: str = "", viewport=DESKTOP) -> Page:
    """A page that is ready. Whatever its console says is a failure."""
    page = browser.new_page(viewport=viewport)
    page.on("console", lambda message: pytest.fail(message.text))
    page.on("pageerror", lambda error: pytest.fail(str(error)))
    page.goto(f"{file.as_uri()}{link}")
    page.wait_for_selector("body:not(.loading)")
    return page


def settled(page: Page) -> None:
    """Two pictures later all that was asked for is shown."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def slider(page: Page, path: str):
    return page.locator(f'input[type=range][aria-label^="{path}:"]')


def shown(page: Page) -> dict:
    """What charts and table show: a number for each line."""
    return page.evaluate(
        """() => {
            const { study, runner } = hillobs, names = study.quantities.map(({ name }) => name), lines = {};
            const sum = (values) => values.reduce((a, b) => a + (b === b ? b * b : 1e9), 0);
            lines.truth = names.map((name) => sum(runner.truth(name)));
            for (const one of Object.keys(study.observers))
                lines[one] = names.map((name) => sum(runner.estimate(one, name)));
            lines.table = document.getElementById("measures").innerText;
            return lines;
        }"""
    )


@pytest.mark.parametrize("viewport", [DESKTOP, PHONE])
def test_it_fits_the_screen_and_every_control_has_a_name(browser, file, viewport) -> None:
    page = opened(browser, file, viewport=viewport)
    page.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
    width = page.evaluate("document.documentElement.scrollWidth")
    assert width <= viewport["width"]
    nameless = page.evaluate(
        """() => [...document.querySelectorAll("input, button, select")]
            .filter((one) => !one.labels?.length && !one.getAttribute("aria-label") && !one.innerText.trim())
            .map((one) => one.outerHTML)"""
    )
    assert nameless == []
    assert page.locator("#charts figure:visible").count() == 4
    page.close()


def test_a_chart_goes_from_where_to_where_its_lines_go(browser, file) -> None:
    page = opened(browser, file)

    def scale_and_lines(name: str) -> tuple[float, float, float, float]:
        settled(page)
        return page.evaluate(
            """(name) => {
                const { study, runner, charts } = hillobs, { min, max } = charts.scaleOf(name);
                const truth = [...runner.truth(name)], times = runner.times(), late = (_, i) => times[i] >= 2;
                const shown = Object.keys(study.observers).filter((one) => !location.hash.includes(one));
                const all = truth.concat(...shown.map((one) => [...runner.estimate(one, name)].filter(late)));
                return [min, max, Math.min(...all), Math.max(...all)];
            }""",
            name,
        )

    for press in ("SMO", "ASMO", None):
        low, high, least, largest = scale_and_lines("Delta")
        assert low < least < largest < high
        assert high - low < 1.2 * (largest - least)
        if press:
            page.get_by_role("button", name=press, exact=True).click()
    page.close()


@pytest.mark.parametrize("path", GAINS)
def test_a_gain_changes_its_observer_alone_and_the_table_follows(browser, file, path) -> None:
    page = opened(browser, file)
    page.evaluate("document.querySelectorAll('details').forEach((one) => { one.open = true; })")
    before = shown(page)
    slider(page, path).evaluate("(one) => { one.value = 700; one.dispatchEvent(new Event('change')); }")
    settled(page)
    after = shown(page)
    assert {name for name in before if before[name] != after[name]} == {GAINS[path], "table"}
    assert path in page.url
    page.close()


def test_keys_move_a_slider_and_a_box_takes_a_number(browser, file) -> None:
    page = opened(browser, file)
    slider(page, "high_gain.eps_h").focus()
    page.keyboard.press("ArrowRight")
    settled(page)
    moved = page.evaluate("hillobs.settings.value('high_gain.eps_h')")
    assert moved > 0.1
    box = page.get_by_label("eps_h", exact=True).first
    box.fill("0.25")
    box.press("Tab")
    settled(page)
    assert page.evaluate("hillobs.settings.value('high_gain.eps_h')") == 0.25
    box.fill("-1")
    box.press("Tab")
    assert "must be above 0" in page.locator(".number.wrong").inner_text()
    assert page.evaluate("hillobs.settings.value('high_gain.eps_h')") == 0.25
    page.get_by_role("button", name="reset").click()
    settled(page)
    assert page.evaluate("hillobs.settings.value('high_gain.eps_h')") == 0.1
    assert page.locator(".number.wrong").count() == 0
    page.close()


def test_a_link_carries_what_was_set_and_what_is_shown(browser, file) -> None:
    page = opened(browser, file)
    page.get_by_role("button", name="another").click()
    page.get_by_role("button", name="activation of muscle 2").click()
    page.get_by_role("button", name="SMO", exact=True).click()
    slider(page, "high_gain.eps_h").evaluate("(one) => { one.value = 600; one.dispatchEvent(new Event('change')); }")
    page.locator("#measure").select_option("peak")
    settled(page)
    link = re.sub("^[^#]*", "", page.url)
    again = opened(browser, file, link)
    assert shown(again) == shown(page)
    assert again.url == page.url
    assert again.locator("#charts figure:visible").count() == 5
    page.close()
    again.close()


def test_a_link_that_makes_no_sense_is_told_and_the_page_runs(browser, file) -> None:
    page = opened(
        browser, file, "#high_gain.eps_h=-1&nothing=3&seed=x&measure=none&show=,,&a=<img src=x onerror=alert(1)>"
    )
    words = page.locator("#status").inner_text()
    assert "high_gain.eps_h=-1" in words
    assert "nothing=3" in words
    assert "<img src=x" in words
    assert page.locator("#status img").count() == 0
    assert page.locator("#charts figure:visible").count() == 4
    page.close()


def test_what_fails_is_told_in_words(browser, file) -> None:
    page = opened(browser, file, "#high_gain.eps_h=0.0001")
    assert re.match(
        r"HGO failed at τ = \d+(\.\d+)?e?[−\d]*: \w+ is beyond its limit", page.locator("#failures").inner_text()
    )
    page.close()
    page = opened(browser, file, "#muscle1.k=40")
    assert "must be below 2.5 F_toe" in page.locator("#failures").inner_text()
    page.close()


def test_how_soon_a_slider_is_answered(browser, file) -> None:
    """Reported, not judged: a machine may be slow."""
    page = opened(browser, file)
    for path in (*GAINS, "noise.x1", "plant.m"):
        times = slider(page, path).evaluate(
            """async (one, n) => {
                const before = hillobs.times.length;
                for (let i = 0; i < n; ++i) {
                    one.value = 300 + 5 * i;
                    one.dispatchEvent(new Event("input"));
                    await new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
                }
                return hillobs.times.slice(before);
            }""",
            DRAGGED,
        )
        print(f"{file.parent.name}: {path} {median(times):.1f} ms in the median of {len(times)}")
        assert len(times) == DRAGGED
    page.close()
