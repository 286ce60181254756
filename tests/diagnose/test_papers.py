"""`rotorwise papers`: what it prints, the files it writes and those it leaves alone, the page in a browser."""

from __future__ import annotations

import io
import json
import math
import re
import stat
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console
from rotorwise.diagnose import papers, papers_files
from rotorwise.diagnose.report import papers_000, papers_page
from rotorwise.diagnose.report.papers_figure import spectrum
from rotorwise.simulators.effects.coupling_misalignment import CouplingMisalignment
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.papers.claim import VERDICTS, Claim, paper_modules
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

from .command import Done, run

CLAIMS = [
    Claim("000", "Fig 1", "1X | 2X <b>", "f_r1 *absent*", "2X -> 3 um, see [1]", "", "partly"),
    Claim("000", "Fig 2", "Nothing.", "", "x" * 200, "with `it`", "reproduced"),
    Claim("002", "Abstract", "An expression.", "None.", "", "", "cannot be checked"),
]
MARKED = f"before\n{papers_files.BEGIN}\nold\n{papers_files.END}\nafter\n"


def rotorwise(*arguments: object) -> Done:
    done = run("papers", *arguments)
    assert "Traceback" not in done.stderr + done.stdout, done.stderr
    return done


# ---- theory ----


def test_spectrum_reads_the_amplitude_of_a_sine_and_nothing_beside_it() -> None:
    t = np.arange(4000) / 1000
    frequencies, lines = spectrum(5.0 + 2.5 * np.cos(2 * math.pi * 20 * t + 0.3), rate_hz=1000)
    peak = int(np.argmax(lines))
    assert frequencies[peak] == pytest.approx(20)
    assert lines[peak] == pytest.approx(2.5, rel=1e-12)
    assert np.delete(lines, [peak - 1, peak, peak + 1]).max() < 1e-12


@pytest.fixture(scope="module")
def figures() -> list[Any]:
    return papers_000.figures()


def test_bars_are_the_solver_s_lines_and_need_stiffness_harmonics(figures: list[Any]) -> None:
    bars = figures[0].variants
    effect = CouplingMisalignment(offset_m=5e-4, angle_rad=0.0, offset_phase_rad=0.0, angle_phase_rad=0.0)
    motion = harmonic_balance(find_machine("amb_rotor").with_effects(effect), speed_rpm=4000.0)
    lines = 1e6 * np.abs(motion.amplitudes[:, 1:6]).max(axis=0)
    assert json.loads(bars["with stiffness harmonics"][1]["y"]) == pytest.approx(lines.tolist(), rel=1e-3)
    for bare in bars["without stiffness harmonics"]:
        first, *others = json.loads(bare["y"])
        assert max(others) < 1e-9 * first


def test_maps_are_solutions_of_their_own(figures: list[Any]) -> None:
    """One cell of a map against the waveform of a machine with that misalignment."""
    for figure, speed_rpm in zip(figures[2:], (2580.0, 4000.0), strict=True):
        panels = figure.variants[""]
        assert len(panels) == 4
        offsets, angles = (json.loads(panels[0][axis]) for axis in "xy")
        assert (len(offsets), len(angles), offsets[-1], angles[-1]) == (101, 101, 0.5, 2.0)
        effect = CouplingMisalignment(
            offset_m=offsets[40] * 1e-3, angle_rad=math.radians(angles[70]), offset_phase_rad=0.0, angle_phase_rad=0.0
        )
        motion = harmonic_balance(find_machine("amb_rotor").with_effects(effect), speed_rpm=speed_rpm)
        peaks = 1e6 * np.abs(motion.waveform(np.linspace(0, 2 * math.pi, 2000))).max(axis=1)
        assert [json.loads(panel["z"][70])[40] for panel in panels] == pytest.approx(peaks.tolist(), rel=2e-3)
        assert panels[0]["limits"] == pytest.approx([37.5, 50.0, 62.5])
        assert panels[0]["contact"] == pytest.approx(125.0)


# ---- words and files ----


def test_examples_of_the_simulators_readme_run(capsys: pytest.CaptureFixture[str]) -> None:
    text = (Path(__file__).resolve().parents[2] / "simulators" / "README.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)
    assert len(blocks) == 3
    names: dict[str, Any] = {}
    for block in blocks:
        exec(compile(block, "simulators/README.md", "exec"), names)
    assert names["acceleration"].shape == (10000,)
    assert names["run_up"].signals.shape == (4, 10000)
    assert [run.signals.shape[1] for run in names["runs"]] == [10000] * 3
    assert "unbalance - " in capsys.readouterr().out


def test_papers_are_chosen_by_number_and_every_one_has_a_title_and_figures() -> None:
    everyone = [module.removeprefix("paper_") for module in paper_modules()]
    assert papers.choose([]) == everyone == list(papers.TITLES)
    assert papers.choose(["2", "000", "2"]) == ["000", "002"]
    with pytest.raises(InvalidValueError, match="'007' is unknown; allowed: 000, 001, 002"):
        papers.choose(["7", "1"])
    folder = Path(papers_page.__file__).parent
    assert all((folder / f"papers_{number}.py").exists() for number in everyone)


def test_terminal_blocks_fit_80_columns_and_end_with_the_count() -> None:
    screen = io.StringIO()
    papers.show(CLAIMS, Console(file=screen, width=80))
    text = screen.getvalue()
    assert max(map(len, text.splitlines())) <= 80
    for claim in CLAIMS:
        for part in (claim.place, claim.says, claim.verdict, claim.as_printed, claim.with_effect):
            assert part in text
    assert text.rstrip().endswith("3 claims: 1 reproduced, 1 partly, 1 cannot be checked.")


def test_verdicts_have_a_colour_each() -> None:
    assert set(papers._COLOURS) == set(VERDICTS)


def test_markdown_rows_have_four_cells_whatever_the_words() -> None:
    rows = [line for line in papers_files.markdown(CLAIMS).splitlines() if line.startswith("|")]
    assert len(rows) == 2 * 2 + len(CLAIMS)
    for row in rows:
        assert len(re.findall(r"(?<!\\)\|", row)) == 5
    assert "<b>" not in "".join(rows)


def test_table_goes_between_the_markers_and_nothing_else_changes(tmp_path: Path) -> None:
    path = tmp_path / "README.md"
    for newline in ("\n", "\r\n"):
        path.write_bytes(MARKED.replace("\n", newline).encode())
        path.chmod(0o640)
        papers_files.write_table(CLAIMS, path)
        once = path.read_bytes()
        assert once.startswith(f"before{newline}".encode())
        assert once.endswith(f"{newline}after{newline}".encode())
        assert b"old" not in once
        assert b"Fig 2" in once
        assert stat.S_IMODE(path.stat().st_mode) == 0o640
        papers_files.write_table(CLAIMS, path)
        assert path.read_bytes() == once
    assert list(tmp_path.iterdir()) == [path]


def test_a_new_table_has_its_markers_and_a_link_stays_a_link(tmp_path: Path) -> None:
    path, link = tmp_path / "new.md", tmp_path / "link.md"
    link.symlink_to(path)
    papers_files.write_table(CLAIMS, link)
    assert link.is_symlink()
    text = path.read_text(encoding="utf-8")
    assert text.startswith(papers_files.BEGIN)
    assert text.rstrip().endswith(papers_files.END)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"no marker\n", "0 begin and 0 end"),
        (MARKED.replace(papers_files.END, "").encode(), "1 begin and 0 end"),
        ((MARKED * 2).encode(), "2 begin and 2 end"),
        (f"{papers_files.END}\n{papers_files.BEGIN}\n".encode(), "in this order"),
        (b"\xff\xfe\x00", "no text in UTF-8"),
    ],
)
def test_a_file_that_cannot_take_the_table_is_left_alone(tmp_path: Path, content: bytes, words: str) -> None:
    path = tmp_path / "notes.md"
    path.write_bytes(content)
    with pytest.raises(papers_files.TableFileError, match=words):
        papers_files.write_table(CLAIMS, path)
    assert path.read_bytes() == content


# ---- the command ----


def test_refusals_come_before_the_work(tmp_path: Path) -> None:
    notes, page = tmp_path / "notes.md", tmp_path / "page.html"
    notes.write_text("mine")
    page.write_text("<!DOCTYPE html>mine")
    begun = time.monotonic()
    for arguments, code, words in (
        (("003",), 2, "allowed: 000, 001, 002"),
        (("--table", notes), 4, papers_files.BEGIN),
        (("--table", tmp_path), 4, "is a folder"),
        (("--table", tmp_path / "none" / "a.md"), 4, "does not exist"),
        (("--report", page), 4, "--force"),
        (("--report", notes, "--force"), 4, "no HTML page"),
    ):
        done = rotorwise(*arguments)
        assert done.returncode == code, done.stderr
        assert words in done.stderr
        assert done.stdout == ""
    assert time.monotonic() - begun < 20
    assert (notes.read_text(), page.read_text()) == ("mine", "<!DOCTYPE html>mine")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Done, Path]:
    folder = tmp_path_factory.mktemp("papers")
    arguments = ("--report", folder / "page.html", "--table", folder / "table.md")
    return rotorwise("2", "--json", *arguments), folder


def test_json_has_every_claim_of_the_chosen_paper(made: tuple[Any, Path]) -> None:
    done, _ = made
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert {one["paper"] for one in found} == {"002"}
    assert set(found[0]) == {"paper", "place", "says", "as_printed", "corrected", "with_effect", "verdict"}
    assert all(one["verdict"] in VERDICTS and one["says"].endswith(".") for one in found)
    assert "paper 002 (1 of 1)" in done.stderr


def test_table_and_page_hold_the_same_claims(made: tuple[Any, Path]) -> None:
    done, folder = made
    claims = [Claim(**one) for one in json.loads(done.stdout)]
    page, table = ((folder / name).read_text(encoding="utf-8") for name in ("page.html", "table.md"))
    assert papers.count(claims) in page
    assert papers.count(claims) in table
    assert page.count("<article") == len(claims)
    assert page.count("plotly.js v") == 1
    bare = re.sub(r"<script>.*?</script>", "", page, flags=re.DOTALL)
    assert not re.search(r'(src|href)="(https?:)?//', bare)
    assert "default-src 'none'" in bare
    for claim in claims:
        assert papers_files._cell(claim.says) in table


@pytest.fixture(scope="module")
def page(figures: list[Any], tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("page") / "page.html"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(papers_000, "figures", lambda: figures)
        papers_page.write_page(CLAIMS, path, force=False)
    return path


@pytest.mark.browser
@pytest.mark.parametrize(("width", "dark"), [(1280, False), (390, False), (1280, True)])
def test_page_draws_and_fits(page: Path, browser: Any, width: int, dark: bool) -> None:
    from selenium.webdriver.support.ui import WebDriverWait

    size = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
    scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [scheme]})
    browser.get(page.as_uri())
    WebDriverWait(browser, 30).until(lambda page: page.execute_script("return document.body.dataset.ready"))
    drawn = browser.execute_script(
        "return [...document.querySelectorAll('figure.plot')].map((f) => [f.dataset.figure, f.querySelectorAll("
        "'.scatterlayer path.js-line, .heatmaplayer image, .barlayer path').length])"
    )
    assert dict(drawn) == {"p000-0": 20, "p000-1": 4, "p000-2": 4, "p000-3": 4, "p002-0": 3}
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    # Choosing another figure of paper 002 draws other curves.
    heights = "return document.querySelector('[data-figure=p002-0] .canvas').data.map((t) => Math.max(...t.y))"
    before = browser.execute_script(heights)
    browser.execute_script(
        "const s = document.querySelector('[data-figure=p002-0] select'); s.value = '2';"
        "s.dispatchEvent(new Event('change'))"
    )
    assert all(abs(a - b) > 1e-3 * b for a, b in zip(before, browser.execute_script(heights), strict=True))
    assert browser.get_log("browser") == []
