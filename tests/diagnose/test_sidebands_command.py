"""``rotorwise sidebands`` on a gear of known modulation: attribution, asked families, page, refusals."""

from __future__ import annotations

import json

import numpy as np
import pytest

from .look_files import RATE, expanded, payload, run, write_csv

TIME = np.arange(40_000) / RATE
PINION = 24.7
WHEEL = PINION * 21 / 42


@pytest.fixture(scope="module")
def gear(tmp_path_factory):
    """Mesh of 21 teeth, modulated by the 42-tooth wheel with index 0.3; pinion orders; noise."""
    modulation = 1 + 0.3 * np.cos(2 * np.pi * WHEEL * TIME) + 0.1 * np.cos(4 * np.pi * WHEEL * TIME)
    mesh = sum(np.cos(2 * np.pi * 21 * k * PINION * TIME) / k for k in (1, 2, 3)) * modulation
    shaft = 0.5 * np.cos(2 * np.pi * PINION * TIME) + 0.3 * np.cos(4 * np.pi * PINION * TIME)
    noise = np.random.default_rng(0).normal(0, 0.1, TIME.size)
    return write_csv(tmp_path_factory.mktemp("gear") / "gear.csv", {"a (g)": mesh + shaft + noise})


def test_blind_families_are_attributed(gear, monkeypatch, capsys):
    assert run(monkeypatch, "sidebands", gear, "--speed", "1480", "--teeth", "21/42", "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["modulators_hz"]["42-tooth shaft"] == pytest.approx(WHEEL, rel=1e-3)
    families = answer["channels"][0]["families"]
    wheel = [one for one in families if one["modulator"] == "42-tooth shaft"]
    carriers = sorted(one["carrier_hz"] for one in wheel)
    assert carriers == pytest.approx([21 * k * PINION for k in (1, 2, 3)], rel=1e-4)
    for one in wheel:
        assert one["modulation_index"] == pytest.approx(0.3, rel=0.1)
        assert one["spacing_hz"] == pytest.approx(WHEEL, rel=1e-3)
        assert max(side["signal_to_noise_db"] for side in one["sidebands"]) > 20


def test_a_family_may_be_asked_for(gear, monkeypatch, capsys):
    arguments = ("--carrier", 21 * PINION, "--spacing", WHEEL, "--speed", "1480", "--teeth", "21/42", "--json")
    assert run(monkeypatch, "sidebands", gear, *arguments) == 0
    (one,) = json.loads(capsys.readouterr().out)["channels"][0]["families"]
    assert one["modulator"] == "42-tooth shaft"
    assert one["modulation_index"] == pytest.approx(0.3, rel=0.1)
    assert [side["number"] for side in one["sidebands"]] == [-4, -3, -2, -1, 1, 2, 3, 4]


def test_without_teeth_the_spacing_has_no_owner(gear, monkeypatch, capsys):
    assert run(monkeypatch, "sidebands", gear, "--speed", "1480", "--json") == 0
    families = json.loads(capsys.readouterr().out)["channels"][0]["families"]
    assert families
    assert all(one["modulator"] is None for one in families if abs(one["spacing_hz"] - WHEEL) < 0.1)


def test_table_and_page(gear, monkeypatch, capsys, tmp_path):
    page = tmp_path / "s.html"
    assert run(monkeypatch, "sidebands", gear, "--speed", "1480", "--teeth", "21/42", "--report", page) == 0
    out = capsys.readouterr().out
    assert all(len(line) <= 80 for line in out.splitlines() if not line.startswith("report"))
    assert "42-tooth shaft" in out
    drawn = payload(page)
    assert drawn["spectrum"][0]["lines"]
    assert drawn["graph-1"][0]["traces"][0]["name"] == "cepstrum"
    # Beside it the carriers, each with its sidebands: 0.3 of modulation are two of 0.15.
    zoom = next(one for one in drawn["graph-2"] if f"{21 * PINION:.1f} Hz" in one["name"])
    frequency, amplitude = expanded(zoom["traces"][0]["curve"])
    top = int(amplitude.argmax())
    assert frequency[top] == pytest.approx(21 * PINION, abs=0.02)
    for side in (-1, 1):
        beside = np.abs(frequency - 21 * PINION - side * WHEEL) < 0.3
        assert amplitude[beside].max() == pytest.approx(0.15 * amplitude[top], rel=0.1)
    assert "42-tooth shaft" in page.read_text("utf-8").split("</h1>")[0]


def test_noise_has_no_families(tmp_path, monkeypatch, capsys):
    path = write_csv(tmp_path / "noise.csv", {"x (g)": np.random.default_rng(1).normal(size=TIME.size)})
    assert run(monkeypatch, "sidebands", path) == 0
    assert "No sideband family" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (("--carrier", "500"), 2),
        (("--spacing", "10"), 2),
        (("--carrier", "10", "--spacing", "20"), 2),
        (("--carrier", "4000", "--spacing", "20"), 3),
        # Carrier and sidebands in one line of the spectrum: this once was a modulation of 200 %.
        (("--carrier", "500", "--spacing", "1e-9"), 3),
    ],
)
def test_wrong_options(gear, monkeypatch, capsys, arguments, code):
    assert run(monkeypatch, "sidebands", gear, *arguments) == code
    assert "allowed" in capsys.readouterr().err
