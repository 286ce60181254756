"""The page as text: self-contained, escaped, complete."""

from __future__ import annotations

import hashlib
import json
import math
import re
import time
from base64 import b64encode
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.datasets.errors import RotorwiseError
from rotorwise.diagnose.report import assets, render_report
from rotorwise.diagnose.report.text import FAULT_WORDS, number, percent
from rotorwise.diagnose.result import FAULTS, Curve, Finding, Line, Pictures, Severity, SpeedEstimate

HOSTILE = (
    "</script><script>alert(1)</script>",
    '"><img src=x onerror=alert(1)>',
    "'><svg onload=alert(1)>",
    "<!--<script>",
    "a\u202egpj.exe",
    "bad\udc80name\x00.wav",
    "&lt;b&gt; %{x} \\u003c",
)
ALLOWED_TAGS = {
    "html",
    "head",
    "meta",
    "title",
    "style",
    "body",
    "main",
    "article",
    "section",
    "header",
    "p",
    "b",
    "strong",
    "h1",
    "h2",
    "h3",
    "h4",
    "h5",
    "div",
    "span",
    "i",
    "em",
    "ul",
    "ol",
    "li",
    "dl",
    "dt",
    "dd",
    "figure",
    "figcaption",
    "label",
    "select",
    "option",
    "optgroup",
    "button",
    "fieldset",
    "legend",
    "input",
    "table",
    "caption",
    "thead",
    "tbody",
    "tr",
    "th",
    "td",
    "a",
    "details",
    "summary",
    "noscript",
    "script",
}


class Page(HTMLParser):
    """Collects elements, attributes and the text of scripts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: list[tuple[dict[str, str | None], str]] = []
        self.words: list[str] = []
        self._open: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        self._open.append(tag)
        if tag == "script":
            self.scripts.append((dict(attrs), ""))

    def handle_endtag(self, tag: str) -> None:
        self._open.append("/" + tag)

    def handle_data(self, data: str) -> None:
        if self._open and self._open[-1] == "script":
            attrs, text = self.scripts[-1]
            self.scripts[-1] = (attrs, text + data)
        elif not (self._open and self._open[-1] == "style"):
            self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join(self.words)

    @property
    def payloads(self) -> dict[str, dict]:
        return {
            str(attrs["id"]): json.loads(text)
            for attrs, text in self.scripts
            if attrs.get("type") == "application/json"
        }


@pytest.fixture(scope="module")
def page(make) -> str:
    return render_report([make()])


@pytest.fixture
def short_plotly(monkeypatch: pytest.MonkeyPatch) -> None:
    """Put a stand-in for plotly's five megabytes, so that hostile names can be tried by the hundred."""
    monkeypatch.setattr("rotorwise.diagnose.report.whole_page.plotly_script", lambda: "/* plotly */")


def test_nothing_is_fetched(page: str) -> None:
    for tag, attrs in Page(page).elements:
        assert tag in ALLOWED_TAGS
        assert not {"src", "srcset", "data", "poster", "action"} & set(attrs)
        assert "href" not in attrs or str(attrs["href"]).startswith("#")
    assert not re.search(r"url\(|@import", assets.style_sheet())
    assert "default-src 'none'" in page


def test_plotly_is_inlined_exactly_once(page: str) -> None:
    assert page.count("plotly.js v") == page.count(assets.plotly_script()[:60]) == 1
    assert page.count(assets.plotly_script()) == 1


def test_policy_allows_exactly_the_scripts_of_the_page(page: str) -> None:
    parsed = Page(page)
    policy = next(a["content"] for t, a in parsed.elements if t == "meta" and "http-equiv" in a)
    run = [text for attrs, text in parsed.scripts if "type" not in attrs]
    hashes = {"sha256-" + b64encode(hashlib.sha256(text.encode()).digest()).decode() for text in run}
    assert len(run) == 2
    assert set(re.findall(r"'(sha256-[^']+)'", str(policy))) == hashes


def test_verdict_comes_first_then_warnings(page: str) -> None:
    text = Page(page).text
    places = [
        text.index(words)
        for words in (
            "Outer race of the drive-end",
            "clips in 0.4 %",
            "Probability 96 %",
            "Spectrum",
            "Lines behind",
        )
    ]
    assert places == sorted(places)


def test_page_says_what_the_analysis_says(page: str, make) -> None:
    text = re.sub(r"\s+", " ", Page(page).text)
    for words in (
        "Rolling bearing: outer race damaged",
        "Check:",
        "Bent shaft; Shaft misalignment",
        "unverified table",
        "ISO 20816-3:2022, table A.2; confidence high",
        "1771.9 rpm",
        "1770.7 to 1773.1 rpm",
        "found in the vibration, near the stated speed",
        "184",
        "points drawn",
    ):
        assert words in text or words in page
    for finding in make.findings():
        for line in finding.lines:
            assert f"{line.frequency_hz:.2f}" in text


def test_evidence_row_holds_the_line_in_display_units(page: str) -> None:
    row = re.search(r'<tr><th scope="row">1X</th>.*?</tr>', page)
    assert row
    words = re.sub(r"<[^>]+>", "|", row.group())
    for expected in ("1.000", "29.53", "1.90", "mm/s", "0.0360", "34.4", "0.950", "+6.0", "Unbalance"):
        assert f"|{expected}" in words


def test_unknown_unit_is_said(make) -> None:
    line = Line("1X", "a", 25.0, 1.0, 3.0, 0.1, None)
    finding = Finding("unbalance", 0.7, "Because.", (line,))
    curve = Curve("spectrum", np.arange(50.0), np.arange(50.0), "Hz", None, "a")
    text = render_report([make.bare(findings=(finding,), pictures=Pictures(spectra=(curve,)))])
    assert '3.00 <span class="unit">unit unknown</span>' in text
    assert Page(text).payloads["data-f0"]["spectrum"][0]["unit"] == "unit unknown"


@pytest.mark.usefixtures("short_plotly")
@given(st.sampled_from(HOSTILE) | st.text(max_size=30))
@settings(max_examples=60, deadline=None)
def test_no_text_can_break_out(make, name: str) -> None:
    line = Line(name, name, 25.0, 1.0, 3.0, 0.1, name, "spectrum", 1.0, 1.0)
    curve = Curve(name, np.arange(50.0), np.arange(50.0), name, name, name, note=name)
    hostile = make.bare(
        path=name,
        verdict=name,
        findings=(Finding(name, 0.5, name, (line,), name, (name,)),),
        severity=(Severity(name, name, name, 3.0, name, name, (1.0, 2.0, 3.0), name, name, name, False),),
        severity_refusal=name,
        speed=SpeedEstimate(25.0, 24.0, 26.0, 0.9, name),
        warnings=(name,),
        channels=(name,),
        features={name: 1.0},
        label=name,
        reader=name,
        baseline_path=name,
        blocks=({name: 1.0, "top": name}, {name: 2.0, "top": name}),
        pictures=Pictures(
            spectra=(curve,),
            waveforms=(curve,),
            orbit={"x": [1.0, 2.0], "y": [1.0, 2.0], "unit": name, "channels": [name, name]},
        ),
    )
    plain = make.bare()
    for analyses in ([hostile], [hostile, plain]):
        text = render_report(analyses, title=name)
        text.encode("utf-8")
        parsed = Page(text)
        assert {tag for tag, _ in parsed.elements} <= ALLOWED_TAGS
        assert not [attr for _, attrs in parsed.elements for attr in attrs if attr.startswith("on")]
        assert len([1 for attrs, _ in parsed.scripts if "type" not in attrs]) == 2
        assert len(parsed.payloads) == (1 if len(analyses) == 1 else 3)
        assert "\u202e" not in text


@pytest.mark.usefixtures("short_plotly")
def test_values_that_are_not_numbers_do_not_reach_the_page(make) -> None:
    y = np.arange(100.0)
    y[10:20], y[30] = np.nan, np.inf
    curve = Curve("spectrum", np.arange(100.0), y, "Hz", "m/s", "a", noise_floor=np.full(100, np.nan))
    line = Line("1X", "a", math.nan, math.nan, math.nan, 0.0, "m/s", "spectrum", 0.0, None)
    analysis = make.bare(
        findings=(Finding("rub", math.nan, "Because.", (line,)),),
        speed=SpeedEstimate(math.nan, math.nan, math.nan, math.nan, "hint only"),
        features={"crest": math.nan, "peak": math.inf},
        pictures=Pictures(spectra=(curve,)),
    )
    for analyses in ([analysis], [analysis, analysis]):
        parsed = Page(render_report(analyses))
        assert not re.search(r"\b(nan|NaN|inf)\b", parsed.text)
        drawn = parsed.payloads["data-f0"]["spectrum"][0]["curve"]["y"]
        assert drawn[10:20] == [None] * 10
        assert drawn[30] is None


def test_nothing_evident_and_refusal_are_stated(make) -> None:
    text = Page(render_report([make.bare(tests=40)])).text
    for words in (
        "Nothing evident in this measurement",
        "40 spectral lines were tested",
        "No severity stated.",
    ):
        assert words in text
    for words in ("The unit is unknown.", "Speed unknown", "holds no curves"):
        assert words in text


def test_no_analysis_is_refused() -> None:
    with pytest.raises(RotorwiseError, match="0 analyses"):
        render_report([])


def test_cursor_groups_start_as_the_findings_need_them(page: str) -> None:
    groups = {g["group"]: g["on"] for g in Page(page).payloads["data-f0"]["cursors"]}
    assert groups == {
        "shaft orders": True,
        "BPFO 6205": True,
        "BPFI 6205": False,
        "mesh": False,
        "mesh sidebands": False,
    }


def test_gauge_places_the_value_between_its_boundaries(make) -> None:
    severity = replace(make.severity()[0], value=2.0, boundaries=(1.0, 3.0, 4.0))
    text = render_report([make.bare(severity=(severity,))])
    ends = [float(place) for place in re.findall(r'class="tick" style="left:([\d.]+)%', text)]
    marker = re.search(r'class="marker \w+" style="left:([\d.]+)%', text)
    assert marker
    assert float(marker.group(1)) == pytest.approx((ends[0] + ends[1]) / 2, abs=0.02)


def test_gauge_says_when_the_value_is_off_its_scale(make) -> None:
    severity = replace(make.severity()[0], value=50.0, zone="D")
    text = render_report([make.bare(severity=(severity,))])
    assert "50.0 ▸ off the scale" in text
    assert 'class="marker right" style="left:100.00%"' in text


def test_folder_has_a_row_a_section_and_a_point_for_every_file(make) -> None:
    analyses = make.folder(4)
    text = render_report(analyses)
    parsed = Page(text)
    trend = parsed.payloads["data-all"]["trend"]
    names = {series["name"]: series["traces"] for series in trend["series"]}
    assert {"velocity_rms", "order_1x", "Speed (rpm)", "Probability of the findings"} <= set(names)
    assert names["velocity_rms"][0]["y"] == pytest.approx([1.5e-3, 2e-3, 2.5e-3, 3e-3])
    race = names["Probability of the findings"][0]
    assert race["name"] == "Rolling bearing: outer race damaged"
    assert race["y"] == pytest.approx([0, 0.25, 0.5625, 1.0])
    for index in range(4):
        assert f'href="#file-{index}"' in text
        assert f'id="file-{index}"' in text
        assert f"data-f{index}" in parsed.payloads
    assert trend["labels"][3] == "P-101_003.wav"


def test_feature_that_only_some_files_have_leaves_gaps(make) -> None:
    analyses = [make.bare(features={"a": 1.0}), make.bare(features={"b": 2.0})]
    series = Page(render_report(analyses)).payloads["data-all"]["trend"]["series"]
    assert {s["name"]: s["traces"][0]["y"] for s in series} == {"a": [1, None], "b": [None, 2]}


def test_blocks_become_a_trend_over_time(make) -> None:
    blocks = tuple({"time_s": 5.0 * i, "velocity_rms": 1.0 + i, "top_finding": "rub"} for i in range(3))
    trend = Page(render_report([make.bare(blocks=blocks)])).payloads["data-f0"]["trend"]
    assert trend["x"] == [0, 5, 10]
    assert trend["labels"] == ["Rotor rub"] * 3
    assert [(s["name"], s["traces"][0]["y"]) for s in trend["series"]] == [("velocity rms", [1, 2, 3])]


def test_rendering_is_fast(make) -> None:
    analysis = make()
    render_report([make.bare()])
    times = []
    for _ in range(3):
        start = time.process_time()
        render_report([analysis])
        times.append(time.process_time() - start)
    assert min(times) < 0.5


def test_plotly_script_is_found_in_older_and_newer_layouts(tmp_path: Path) -> None:
    with pytest.raises(RotorwiseError, match="pip install plotly"):
        assets.find_plotly_script((tmp_path,))
    moved = tmp_path / "data" / "js" / "plotly-basic.min.js"
    moved.parent.mkdir(parents=True)
    moved.write_text("//")
    assert assets.find_plotly_script((tmp_path,)) == moved
    usual = tmp_path / "package_data" / "plotly.min.js"
    usual.parent.mkdir()
    usual.write_text("//")
    assert assets.find_plotly_script((tmp_path,)) == usual


def test_script_cannot_end_its_element() -> None:
    assert "</script" not in assets.safe_script("a='</script><!--'\r\n").lower()
    assert assets.safe_script("a\r\nb\rc") == "a\nb\nc"


def test_every_fault_has_plain_words() -> None:
    assert set(FAULT_WORDS) == set(FAULTS)


@given(st.floats(1e-5, 1e5))
def test_printed_numbers_are_right_to_three_digits(value: float) -> None:
    assert float(number(value)) == pytest.approx(value, rel=0.00501)


@given(st.floats(0, 1))
def test_percentages_never_round_to_certainty(probability: float) -> None:
    assert (percent(probability) == "100 %") == (probability == 1)
    assert (percent(probability) == "0 %") == (probability == 0)
