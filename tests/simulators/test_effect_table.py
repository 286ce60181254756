"""The table of the catalogue: complete, its words true of the declarations, its pictures those of the spectra."""

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from rotorwise.simulators.assembly import Probe
from rotorwise.simulators.effect import Line, effect_catalogue
from rotorwise.simulators.effect_exhibit import Exhibit, exhibit, picture, sees
from rotorwise.simulators.effect_table import lines_cell, rise_cell, row, rows_of
from rotorwise.simulators.effect_text import growth_text, line_text, prior_text, signature_on
from rotorwise.simulators.machine import machine_catalogue

ROOT = Path(__file__).resolve().parents[2]
CATALOGUE = effect_catalogue()
MACHINES = machine_catalogue()


@pytest.mark.parametrize("name", CATALOGUE)
def test_readme_has_the_effect_as_it_is_declared(name):
    text = (ROOT / "simulators" / "effects" / "README.md").read_text(encoding="utf-8")
    own = [line for line in text.splitlines() if f"**[{name}]({name}.py)**" in line]
    assert len(own) == 1, "run python -m rotorwise.simulators.effect_table"
    assert CATALOGUE[name].MEANING.replace("|", "/") in own[0], "run python -m rotorwise.simulators.effect_table"
    if "no machine shows it" not in own[0]:
        picture_file = ROOT / "docs" / "effects" / f"{name}.svg"
        assert ElementTree.fromstring(picture_file.read_text(encoding="utf-8")).tag.endswith("svg")


@pytest.mark.parametrize("name", CATALOGUE)
def test_row_begins_its_test_with_the_figure(name):
    rows = rows_of((ROOT / "simulators" / "effects" / "README.md").read_text(encoding="utf-8"))
    cell = rows[name].split(" | ")[-1]
    assert re.match(r"\*\*[^*]{5,70}: [^*]+\*\*<br>\[", cell), "run python -m rotorwise.simulators.effect_table --tests"


@pytest.mark.parametrize(
    ("line", "text"),
    [
        (Line(2.0), "2X"),
        (Line(0.0), "mean"),
        (Line(0.0, frequency_hz=100.0), "100 Hz"),
        (Line(23.0, frequency_hz=-5.0), "23X - 5 Hz"),
    ],
)
def test_line_in_words(line, text):
    assert line_text(line) == text


def test_growth_in_words():
    assert growth_text(Line(1.0, speed_exponent=2.0, load_exponent=0.0)) == "speed^2, not with load"
    assert growth_text(Line(1.0)) == ""


def test_order_of_a_fixed_frequency_falls_with_speed():
    line = Line(23.0, frequency_hz=-5.0)
    assert line.order_at(600.0) == pytest.approx(22.5)
    assert Line(0.0, frequency_hz=100.0).order_at(6000.0) == pytest.approx(1.0)


def test_exhibit_of_an_unbalance_is_the_growth_of_1x():
    rotor = {"amb_rotor": MACHINES["amb_rotor"]}
    shown = exhibit(CATALOGUE["unbalance"], rotor)
    assert shown is not None
    assert shown.line == Line(1.0, speed_exponent=2.0, load_exponent=0.0)
    # The rotor has an unbalance of 1.25e-4 kg.m at 0 degrees, the effect's default adds 1e-4 there.
    assert shown.rise == pytest.approx(1 + 1e-4 / 1.25e-4, rel=0.25)
    assert "1X" in rise_cell(shown)


def test_machine_without_the_part_is_left_out():
    assert exhibit(CATALOGUE["gear_eccentricity"], {"amb_rotor": MACHINES["amb_rotor"]}) is None
    assert signature_on(CATALOGUE["gear_eccentricity"], MACHINES["amb_rotor"]) is None
    assert "no machine shows it" in row(CATALOGUE["gear_eccentricity"], None, "contract only")


def made(after):
    orders = np.arange(0, 10, 0.05)
    probe = Probe("p", "acceleration", "m/s2", "here", "y", {})
    before = np.full(orders.size, 1e-3)
    return Exhibit("rig", probe, orders, before, np.full(orders.size, after), (Line(2.0),), Line(2.0), after / 1e-3)


def test_picture_has_both_curves_on_one_scale_of_five_decades():
    drawn = ElementTree.fromstring(picture(made(1e-1)))
    curves = [p for p in drawn.iter() if p.tag.endswith("polyline")]
    heights = [{float(point.split(",")[1]) for point in curve.get("points").split()} for curve in curves]
    assert [len(own) for own in heights] == [1, 1]
    after, before = (own.pop() for own in heights)
    # Two decades of five, on 110 - 18 - 14 points of height.
    assert before - after == pytest.approx(78 * 2 / 5, abs=0.15)


def test_picture_says_what_is_on_its_axes():
    drawn = ElementTree.fromstring(picture(made(1e-1)))
    texts = [t.text for t in drawn.iter() if t.tag.endswith("text")]
    assert "1e-06 to 0.1 m/s2" in texts
    assert any(text.startswith("orders") for text in texts)
    assert {"0.1X", "6X"} <= set(texts)


def test_rise_in_words():
    assert rise_cell(made(5e-3)) == "2X × 5"
    assert rise_cell(made(1e3)) == "2X is new"


def test_lines_of_one_law_stand_together():
    cell = lines_cell((Line(1.0, speed_exponent=2.0), Line(2.0, speed_exponent=2.0), Line(3.0)))
    assert cell == "1X, 2X (lateral; speed^2)<br>3X (lateral; no simple law)"


def test_probes_see_their_directions():
    probe = Probe("p", "acceleration", "m/s2", "here", "axial", {})
    assert sees(probe, Line(1.0, "any"))
    assert sees(probe, Line(1.0, "axial"))
    assert not sees(probe, Line(1.0))


def test_priors_in_words():
    texts = {prior_text(p) for effect in CATALOGUE.values() for p in effect.parameters()}
    assert "given" in texts
    assert any("factor" in text for text in texts)
    assert all(len(text) < 60 for text in texts)
