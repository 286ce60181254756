"""The page in headless Chromium: it draws, its switches work, and it fits a phone."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rotorwise.diagnose.report import render_report, write_report
from rotorwise.diagnose.result import OrderPart

pytestmark = pytest.mark.browser

FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
)
READY = "return [...document.querySelectorAll('.file:not(details)')].every((a) => a.dataset.ready)"
PAGE_WIDTH = "return document.documentElement.scrollWidth"
CURSORS = (
    "return document.querySelector(arguments[0] + ' .canvas')._fullLayout.shapes"
    ".filter((s) => s.name === arguments[1]).length"
)
CURVE = (
    "return document.querySelector(arguments[0] + ' .canvas').data" + ".find((t) => t.name === 'curve').y.slice(0, 50)"
)
SPECTRUM = "[data-plot=spectrum]"


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    if not chromium or not driver:
        pytest.skip(f"no headless browser: chromium {chromium}, chromedriver {driver}")
    options = webdriver.ChromeOptions()
    options.binary_location = chromium
    for flag in (*FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}", "--window-size=1280,900"):
        options.add_argument(flag)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    running = webdriver.Chrome(options=options, service=webdriver.ChromeService(driver))
    yield running
    running.quit()


@pytest.fixture
def show(browser: Any, tmp_path: Path) -> Iterator[Callable[..., Any]]:
    """Return a function that writes a report, opens it and waits until it is drawn."""
    from selenium.webdriver.support.ui import WebDriverWait

    def _show(*analyses: Any, width: int = 1280, mobile: bool = False, dark: bool = False, hash_: str = "") -> Any:
        size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": mobile}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [scheme]})
        for log in ("browser", "performance"):
            browser.get_log(log)
        path = tmp_path / "report.html"
        write_report(analyses, path, force=True)
        browser.get(path.as_uri() + hash_)
        WebDriverWait(browser, 30).until(lambda page: page.execute_script(READY))
        return browser

    yield _show
    assert browser.get_log("browser") == []


def click(page: Any, selector: str) -> None:
    page.execute_script("document.querySelector(arguments[0]).click()", selector)


def choose(page: Any, selector: str, value: str) -> None:
    page.execute_script(
        "const s = document.querySelector(arguments[0]); s.value = arguments[1]; s.dispatchEvent(new Event('change'))",
        selector,
        value,
    )


def column(page: Any, table: str, index: int) -> list[str]:
    return page.execute_script(
        "return [...document.querySelector(arguments[0]).tBodies[0].rows]"
        ".map((r) => r.cells[arguments[1]].textContent)",
        table,
        index,
    )


def test_every_figure_is_drawn(show: Callable[..., Any], make: Any) -> None:
    page = show(make())
    drawn = page.execute_script(
        "return Object.fromEntries([...document.querySelectorAll('figure.plot')].map((f) => [f.dataset.plot,"
        " f.querySelectorAll('.scatterlayer path.js-line, .heatmaplayer image').length]))"
    )
    assert set(drawn) == {"spectrum", "map", "envelope", "orbit", "waveform"}
    assert min(drawn.values()) >= 1
    assert drawn["spectrum"] == 3  # recording, baseline, noise floor


@pytest.mark.slow
def test_orders_within_a_turn_are_drawn_when_they_are_opened(show: Callable[..., Any], make: Any) -> None:
    from selenium.webdriver.support.ui import WebDriverWait

    turns = np.arange(2000) / 50
    wave = np.cos(2 * np.pi * turns) + 0.5 * np.cos(4 * np.pi * turns)
    part = OrderPart(wave, 1000.0, turns, (1.0, 2.0), "m/s2", "a", has_mark=True)
    whole = make()
    page = show(replace(whole, pictures=replace(whole.pictures, order_part=part)))
    traces = "return (document.querySelector('[data-plot=turn] .canvas').data || []).length"
    assert page.execute_script(traces) == 0
    click(page, "details.fold:has([data-plot=turn]) summary")
    WebDriverWait(page, 10).until(lambda drawn: drawn.execute_script(traces))
    assert page.execute_script(traces) == 4  # signal, both orders together, each alone
    caption = page.execute_script("return document.querySelector('[data-plot=turn] figcaption').textContent")
    assert "Zero is the tacho's mark" in caption
    # The drawing fills its place: it was made after the fold had opened.
    width = "const c = document.querySelector('[data-plot=turn] .canvas'); return c._fullLayout.width / c.clientWidth"
    assert page.execute_script(width) == pytest.approx(1.0, abs=0.02)


def test_nothing_is_requested_but_the_file_itself(show: Callable[..., Any], make: Any) -> None:
    page = show(make())
    requests = [
        entry["message"] for entry in page.get_log("performance") if 'Network.requestWillBeSent"' in entry["message"]
    ]
    assert requests
    assert not [message for message in requests if '"url":"http' in message]


def test_cursor_box_hides_and_shows_its_group(show: Callable[..., Any], make: Any) -> None:
    page = show(make())
    assert page.execute_script(CURSORS, SPECTRUM, "cursor-0") == 10
    click(page, f"{SPECTRUM} input[data-group='0']")
    assert page.execute_script(CURSORS, SPECTRUM, "cursor-0") == 0
    assert page.execute_script(CURSORS, SPECTRUM, "cursor-1") == 5
    click(page, f"{SPECTRUM} input[data-group='2']")
    assert page.execute_script(CURSORS, SPECTRUM, "cursor-2") == 5


@pytest.mark.slow
def test_cursor_box_works_from_the_keyboard(show: Callable[..., Any], make: Any) -> None:
    from selenium.webdriver.common.keys import Keys

    page = show(make())
    page.find_element("css selector", f"{SPECTRUM} input[data-group='0']").send_keys(Keys.SPACE)
    assert page.execute_script(CURSORS, SPECTRUM, "cursor-0") == 0


@pytest.mark.slow
def test_switching_on_cursors_out_of_sight_brings_them_into_sight(show: Callable[..., Any], make: Any) -> None:
    page = show(make())
    end = f"return document.querySelector('{SPECTRUM} .canvas')._fullLayout.xaxis.range[1]"
    before = page.execute_script(end)
    assert before < 23 * 29.532
    click(page, f"{SPECTRUM} input[data-group='2']")
    assert page.execute_script(end) == before
    click(page, f"{SPECTRUM} input[data-group='3']")
    assert page.execute_script(end) > 23 * 29.532


@pytest.mark.parametrize("width", [390, 1280])
def test_cursors_stand_at_their_frequency_and_labels_do_not_overlap(
    show: Callable[..., Any], make: Any, width: int
) -> None:
    page = show(make(), width=width)
    for group in (2, 3, 4):
        click(page, f"{SPECTRUM} input[data-group='{group}']")
    click(page, f"{SPECTRUM} [data-zoom=near]")
    places = page.execute_script(
        f"return document.querySelector('{SPECTRUM} .canvas').layout.shapes"
        ".filter((s) => s.name === 'cursor-0').map((s) => s.x0)"
    )
    assert places == pytest.approx([29.532 * n for n in range(1, 11)])
    boxes = page.execute_script(
        f"return [...document.querySelectorAll('{SPECTRUM} .annotation-text-g')]"
        ".map((e) => e.getBoundingClientRect().toJSON())"
    )
    assert len(boxes) > width / 60
    for index, one in enumerate(boxes):
        for other in boxes[index + 1 :]:
            beside = one["right"] <= other["left"] or other["right"] <= one["left"]
            above = one["bottom"] <= other["top"] + 2 or other["bottom"] <= one["top"] + 2
            assert beside or above


def test_channel_selector_changes_the_curve(show: Callable[..., Any], make: Any) -> None:
    page = show(make())
    first = page.execute_script(CURVE, SPECTRUM)
    choose(page, f"{SPECTRUM} select[data-role=channel]", "1")
    second = page.execute_script(CURVE, SPECTRUM)
    expected = make.pictures().spectra[1].y[:50] * 1e3
    assert first != second
    assert second == pytest.approx(list(expected), rel=1e-3)


@pytest.mark.slow
def test_spectrum_opens_on_the_channel_that_carries_the_evidence(show: Callable[..., Any], make: Any) -> None:
    pictures = make.pictures()
    page = show(make(pictures=replace(pictures, spectra=pictures.spectra[::-1])))
    assert page.execute_script(f"return document.querySelector('{SPECTRUM} [data-role=channel]').value") == "2"
    expected = pictures.spectra[0].y[:50] * 1e3
    assert page.execute_script(CURVE, SPECTRUM) == pytest.approx(list(expected), rel=1e-3)


def test_scale_axis_and_range_switches(show: Callable[..., Any], make: Any) -> None:
    page = show(make())
    state = f"const l = document.querySelector('{SPECTRUM} .canvas')._fullLayout; return "
    assert page.execute_script(state + "l.yaxis.type") == "log"
    choose(page, f"{SPECTRUM} select[data-role=scale]", "linear")
    assert page.execute_script(state + "l.yaxis.type") == "linear"
    click(page, f"{SPECTRUM} [data-zoom=all]")
    assert page.execute_script(state + "l.xaxis.range[1]") == pytest.approx(0.39 * 25600)
    choose(page, f"{SPECTRUM} select[data-role=axis]", "order")
    assert page.execute_script(state + "l.xaxis.range[1]") == pytest.approx(0.39 * 25600 / 29.532)


@pytest.mark.slow
def test_zooming_keeps_the_frequency_range_in_both_units(show: Callable[..., Any], make: Any) -> None:
    page = show(make())
    canvas = f"document.querySelector('{SPECTRUM} .canvas')"
    page.execute_async_script(
        f"Plotly.relayout({canvas}, {{'xaxis.range[0]': 50, 'xaxis.range[1]': 150}}).then(arguments[0])"
    )
    choose(page, f"{SPECTRUM} select[data-role=axis]", "order")
    assert page.execute_script(f"return {canvas}._fullLayout.xaxis.range") == pytest.approx([50 / 29.532, 150 / 29.532])


@pytest.mark.slow
def test_evidence_sorts_both_ways_by_number(show: Callable[..., Any], make: Any) -> None:
    page = show(make())
    click(page, ".evidence thead th:nth-child(3) button")
    rising = [float(text) for text in column(page, ".evidence", 2)]
    assert rising == sorted(rising)
    assert len(set(rising)) == 5
    click(page, ".evidence thead th:nth-child(3) button")
    assert [float(text) for text in column(page, ".evidence", 2)] == rising[::-1]
    assert page.execute_script("return document.querySelector('.evidence th[aria-sort]').ariaSort") == "descending"


@pytest.mark.parametrize("kind", ["one", "folder", "bare"])
def test_a_phone_does_not_scroll_sideways(show: Callable[..., Any], make: Any, kind: str) -> None:
    long = make("/data/" + "very_long_name" * 12 + ".wav", verdict="Word" * 40 + " is damaged.")
    analyses = {"one": [long], "folder": [long, *make.folder(3)], "bare": [make.bare()]}[kind]
    page = show(*analyses, width=390, mobile=True, hash_="#file-0" if kind == "folder" else "")
    assert page.execute_script(PAGE_WIDTH) == 390


def test_folder_draws_a_file_only_when_it_is_opened(show: Callable[..., Any], make: Any) -> None:
    from selenium.webdriver.support.ui import WebDriverWait

    page = show(*make.folder(4))
    count = "return document.querySelectorAll('#file-2 .main-svg').length"
    assert page.execute_script(count) == 0
    click(page, "a[href='#file-2']")
    WebDriverWait(page, 20).until(
        lambda now: now.execute_script("return document.querySelector('#file-2').dataset.ready")
    )
    assert page.execute_script(count) >= 5
    assert page.execute_script("return document.querySelectorAll('#file-1 .main-svg').length") == 0
    top = page.execute_script("return document.querySelector('#file-2').getBoundingClientRect().top")
    assert abs(top) < 50


@pytest.mark.slow
def test_trend_selector_shows_the_chosen_feature(show: Callable[..., Any], make: Any) -> None:
    page = show(*make.folder(4))
    trend = "[data-payload=all] [data-role=series]"
    options = page.execute_script(f"return [...document.querySelector('{trend}').options].map((o) => o.text)")
    choose(page, trend, str(options.index("velocity_rms")))
    drawn = page.execute_script("return document.querySelector('[data-payload=all] .canvas').data[0].y")
    assert drawn == pytest.approx([1.5e-3, 2e-3, 2.5e-3, 3e-3])


@pytest.mark.slow
def test_dark_and_light_follow_the_system(show: Callable[..., Any], make: Any) -> None:
    from selenium.webdriver.support.ui import WebDriverWait

    paper = f"return document.querySelector('{SPECTRUM} .canvas')._fullLayout.paper_bgcolor"
    page = show(make(), dark=True)
    assert page.execute_script(paper) == "#191f26"
    scheme = {"name": "prefers-color-scheme", "value": "light"}
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [scheme]})
    WebDriverWait(page, 20).until(lambda now: now.execute_script(paper) == "#ffffff")


@pytest.mark.slow
def test_printing_turns_a_dark_page_light(show: Callable[..., Any], make: Any) -> None:
    page = show(make(), dark=True)
    back = "return document.querySelector('.canvas')._fullLayout.paper_bgcolor"
    page.execute_script("window.dispatchEvent(new Event('beforeprint'))")
    assert page.execute_script(back) == "#ffffff"
    page.execute_script("window.dispatchEvent(new Event('afterprint'))")
    assert page.execute_script(back) == "#191f26"


def test_hostile_names_run_nothing(show: Callable[..., Any], make: Any) -> None:
    bad = (
        "</script><script>window.hit=1</script><img src=x onerror=window.hit=1><a href='javascript:window.hit=1'>x</a>"
    )
    pictures = make.pictures()
    pictures = replace(
        pictures,
        spectra=tuple(replace(curve, channel=bad, name=bad, y_unit=bad) for curve in pictures.spectra),
        cursors=tuple(replace(cursor, label=bad, group="shaft " + bad) for cursor in pictures.cursors),
    )
    analysis = make(bad, verdict=bad, warnings=(bad,), pictures=pictures, features={bad: 1.0})
    page = show(analysis, replace(analysis, path="b" + bad))
    click(page, "a[href='#file-0']")
    page.execute_async_script("setTimeout(arguments[0], 1500)")
    assert page.execute_script("return window.hit") is None
    assert page.execute_script("return document.querySelectorAll('main img, main a[href^=javascript]').length") == 0


def test_injected_script_is_blocked_by_the_policy(browser: Any, make: Any, tmp_path: Path) -> None:
    page = render_report([make.bare()]).replace("<main>", "<main><script>window.hit=1</script>")
    (tmp_path / "page.html").write_text(page, encoding="utf-8")
    browser.get((tmp_path / "page.html").as_uri())
    assert browser.execute_script("return window.hit") is None
    assert [entry for entry in browser.get_log("browser") if "Content Security Policy" in entry["message"]]
