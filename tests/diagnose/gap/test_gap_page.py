"""The gap report: the verdict first, every number in it, no network, and in a browser it draws and fits a phone."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.diagnose.gap.lines import LineKind, OrderLines
from rotorwise.diagnose.gap.result import KINDS
from rotorwise.diagnose.gap.words import headline, hypothesis_words, sentence_of
from rotorwise.diagnose.report.encode import to_json
from rotorwise.diagnose.report.gap_blocks import printed, residual_table
from rotorwise.diagnose.report.gap_figures import gap_payload
from rotorwise.diagnose.report.gap_page import render_gap, write_gap_page
from rotorwise.diagnose.report.text import escape
from rotorwise.diagnose.report.write import ReportFileError
from rotorwise.simulators.machine import find_machine

from .made_results import CONDITIONS, ORDERS, PROBES, made


def bare(page: str) -> str:
    return re.sub(r"<(script|style)\b.*?</\1>", "", page, flags=re.DOTALL)


def test_pictures_hold_the_lines_in_readable_units() -> None:
    result = made("one cause")
    payload = json.loads(to_json(gap_payload(result)))
    assert [one["name"] for one in payload["probes"]] == list(PROBES)
    assert [one["heldOut"] for one in payload["conditions"]] == [False, True, False, False]
    assert payload["orders"] == ["0.5X", "1X", "2X", "3X"]
    for p, probe in enumerate(payload["probes"]):
        assert probe["unit"] == "µm"
        np.testing.assert_allclose(probe["before"], 1e6 * np.abs(result.before[:, p]), rtol=1e-3)
        np.testing.assert_allclose(probe["after"], 1e6 * np.abs(result.after[:, p]), rtol=1e-3)
        left = 1e6 * np.abs(result.measured.amplitudes[:, p] - result.before[:, p])
        seen = result.measured.seen[:, p]
        np.testing.assert_allclose(np.array(probe["leftBefore"], float)[seen], left[seen], rtol=1e-3, atol=1e-12)
        np.testing.assert_allclose(probe["phases"][1], np.degrees(np.angle(result.before[:, p])), atol=0.1)
    # A line that cannot be seen is not drawn.
    assert payload["probes"][0]["measured"][0][3] is None
    assert payload["probes"][0]["noise"][0][3] is None


def test_two_lines_of_one_order_are_told_apart_and_one_without_phase_has_none() -> None:
    result = made("one cause")
    kinds = (LineKind(), LineKind(), LineKind(phase=False, envelope=True), LineKind(phase=False, frequency_hz=5.0))
    lines = replace(result.measured, orders=(0.5, 2.0, 2.0, 0.0), kinds=kinds)
    worst = replace(result.residuals[0], order=2.0, column=2)
    result = replace(result, measured=lines, residuals=(worst, replace(worst, column=1)))
    payload = json.loads(to_json(gap_payload(result)))
    assert payload["orders"] == ["0.5X", "2X", "envelope, 2X", "5 Hz"]
    assert payload["phased"] == [True, True, False, False]
    for phases in payload["probes"][0]["phases"]:
        assert all((one[2], one[3]) == (None, None) and one[0] is not None for one in phases)
    table = residual_table(result)
    for name, column in (("envelope, 2X", 2), ("2X", 1)):
        row = next(one for one in table.split("<tr>") if f">{name}</th>" in one)
        after = abs(result.after[worst.condition, PROBES.index(worst.probe), column])
        assert f'data-v="{after:.9g}"' in row
    page = bare(render_gap(result))
    assert '<option value="2" selected>envelope, 2X</option>' in page


@pytest.mark.parametrize(
    ("machine", "probe", "size", "unit", "factor"),
    [
        ("amb_rotor", "path_1", 2e-6, "µm", 1e6),
        ("amb_rotor", "path_1", 2e-2, "mm", 1e3),
        ("gearbox", "pinion velocity y", 2e-3, "mm/s", 1e3),
        ("gearbox", "pinion velocity y", 2.0, "m/s", 1.0),
        ("gearbox", "pinion torsional velocity", 2.0, "rad/s", 1.0),
        ("gearbox", "accelerometer", 2.0, "m/s²", 1.0),
    ],
)
def test_unit_and_number_belong_together(machine: str, probe: str, size: float, unit: str, factor: float) -> None:
    lines = np.full((1, 1, 1), size * 1j)
    result = replace(
        made("none"),
        machine=find_machine(machine),
        measured=OrderLines((CONDITIONS[0],), (probe,), (1.0,), lines, 1e-3 * abs(lines)),
        before=lines,
        after=lines,
    )
    drawn = json.loads(to_json(gap_payload(result)))["probes"][0]
    assert (drawn["unit"], drawn["measured"]) == (unit, [[pytest.approx(factor * size, rel=1e-3)]])


@pytest.mark.parametrize("kind", KINDS)
def test_page_says_the_verdict_first_and_holds_the_rest(kind: str) -> None:
    result = made(kind)
    page = render_gap(result, title="<pump>", notes=("Channel Z is not compared: no such probe.",))
    words = bare(page)
    assert words.index(printed(headline(result))) < words.index("<h2")
    assert "&lt;pump&gt;" in words
    assert "Channel Z is not compared" in words
    assert "speed wander, rub: nothing at constant speed." in words
    assert "1 of 48 lines" in words
    assert words.count('<th scope="row" data-v="1">1X</th>') == len(result.residuals)
    assert result.next_measurement in words
    for names, probability in result.probabilities.items():
        assert f"<span>{hypothesis_words(names)}</span>" in words
        assert f"width:{100 * probability:.1f}%" in words
    assert escape(result.extended.to_toml()) in words


def test_verdict_is_told_once_and_whole() -> None:
    words = bare(render_gap(made("one cause")))
    head, lead = (
        re.search(rf'<{tag} class="{css}">(.*?)</{tag}>', words) for tag, css in (("h1", "verdict"), ("p", "lead"))
    )
    assert head
    assert lead
    said = sorted(f"{head[1]} {lead[1]}".split())
    assert said == sorted(printed(sentence_of(made("one cause"))).split())


def test_units_are_printed_as_read_and_words_left_alone() -> None:
    assert (
        printed("bow 50 um (40 to 60), angle 30 deg, 2 m/s2 <b>") == "bow 50 µm (40 to 60), angle 30°, 2 m/s² &lt;b&gt;"
    )
    assert printed("5 degrees umpteen deg") == "5 degrees umpteen deg"


def test_page_needs_no_network_and_runs_only_its_own_scripts() -> None:
    page = render_gap(made("one cause"))
    assert page.count("plotly.js v") == 1
    assert not re.search(r'(src|href)="(https?:)?//', bare(page))
    assert "default-src 'none'" in page


@given(st.text(max_size=80))
@settings(max_examples=15, deadline=None)
def test_no_text_becomes_markup(text: str) -> None:
    hostile = f"</script><img src=x>{text}"
    result = replace(made("one cause"), remarks=(hostile,), next_measurement=hostile, not_compared={hostile: hostile})
    page = render_gap(result, title=hostile, notes=(hostile,))
    assert "<img" not in page
    assert page.count("</script>") == 3


def test_only_a_page_is_replaced(tmp_path: Path) -> None:
    path, mine = tmp_path / "gap.html", tmp_path / "notes.html"
    mine.write_text("mine")
    write_gap_page(made("none"), path)
    with pytest.raises(ReportFileError, match="exists already"):
        write_gap_page(made("none"), path)
    write_gap_page(made("unknown"), path, force=True)
    assert printed(headline(made("unknown"))) in path.read_text(encoding="utf-8")
    with pytest.raises(ReportFileError, match="no HTML page"):
        write_gap_page(made("none"), mine, force=True)
    assert mine.read_text() == "mine"


# ---- in a browser ----

READY = "return document.querySelector('article.file').dataset.ready"
BARS = (
    "return document.querySelector('[data-plot=gap-orders] .canvas').data.filter((t) => t.name === arguments[0])"
    ".map((t) => t.y)"
)
CHOOSE = "const s = document.querySelector(arguments[0]); s.value = arguments[1]; s.dispatchEvent(new Event('change'))"


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "gap.html"
    write_gap_page(made("one cause"), path, title="pump 3", notes=("No tacho in 1 of 4 recordings.",))
    return path


@pytest.mark.browser
@pytest.mark.parametrize(("width", "dark"), [(1280, False), (390, False), (390, True)])
def test_page_draws_every_condition_and_fits(page: Path, browser: Any, width: int, dark: bool) -> None:
    shown = opened(browser, page, width, dark)
    titles = shown.execute_script(
        "return document.querySelector('[data-plot=gap-orders] .canvas')._fullLayout.annotations.map((a) => a.text)"
    )
    assert len(titles) == len(CONDITIONS)
    assert sum("held out" in title for title in titles) == 1
    drawn = shown.execute_script(
        "return document.querySelectorAll('[data-plot=gap-orders] .barlayer .trace.bars').length"
    )
    assert drawn == 2 * len(CONDITIONS)
    assert shown.execute_script("return document.documentElement.scrollWidth") <= width
    assert shown.execute_script("return document.querySelector('h1').getBoundingClientRect().top") < 200
    assert browser.get_log("browser") == []


@pytest.mark.browser
def test_switches_show_other_probes_what_is_left_and_phases(page: Path, browser: Any) -> None:
    shown, result = opened(browser, page, 1280, False), made("one cause")
    for probe in range(len(PROBES)):
        shown.execute_script(CHOOSE, "[data-plot=gap-orders] [data-role=channel]", str(probe))
        np.testing.assert_allclose(shown.execute_script(BARS, "after"), 1e6 * np.abs(result.after[:, probe]), rtol=1e-3)
    shown.execute_script(CHOOSE, "[data-plot=gap-orders] [data-role=series]", "1")
    left = 1e6 * np.abs(result.measured.amplitudes - result.after)[:, 2]
    np.testing.assert_allclose(shown.execute_script(BARS, "after"), left, rtol=1e-3)
    assert shown.execute_script("return document.querySelector('.key-measured').textContent") == "noise"
    shown.execute_script(CHOOSE, "[data-plot=gap-conditions] [data-role=series]", str(ORDERS.index(2.0)))
    shown.execute_script(CHOOSE, "[data-plot=gap-conditions] [data-role=axis]", "phase")
    phases = shown.execute_script(
        "return document.querySelector('[data-plot=gap-conditions] .canvas').data.find((t) => t.name === 'simulated "
        "before').y"
    )
    np.testing.assert_allclose(phases, np.degrees(np.angle(result.before[:, 0, 2])), atol=0.1)
    assert browser.get_log("browser") == []


@pytest.mark.browser
def test_residuals_sort_by_a_click(page: Path, browser: Any) -> None:
    shown = opened(browser, page, 1280, False)
    sigma = "return [...document.querySelector('.gap-table').tBodies[0].rows].map((r) => Number(r.cells[6].dataset.v))"
    ranked = shown.execute_script(sigma)
    assert ranked == sorted(ranked, reverse=True)
    shown.execute_script("document.querySelector('.gap-table thead th:nth-child(7) button').click()")
    assert shown.execute_script(sigma) == sorted(ranked)
    assert browser.get_log("browser") == []


def opened(browser: Any, page: Path, width: int, dark: bool) -> Any:
    from selenium.webdriver.support.ui import WebDriverWait

    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [scheme]})
    browser.get_log("browser")
    browser.get(page.as_uri())
    WebDriverWait(browser, 30).until(lambda one: one.execute_script(READY))
    return browser
