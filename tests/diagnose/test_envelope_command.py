"""``rotorwise envelope`` on impacts of a known bearing: names, bands, preparation, page, refusals."""

from __future__ import annotations

import json

import numpy as np
import pytest
from rotorwise.diagnose.envelopes import Rhythm, _names
from rotorwise.diagnose.look import Shaft
from rotorwise.simulators.rotor_dynamics.rolling_bearing import find_bearing

from .look_files import RATE, payload, run, write_csv

TIME = np.arange(40_000) / RATE
SPEED = 24.7
INNER = find_bearing("6205").defect_orders().inner_race


@pytest.fixture(scope="module")
def damaged(tmp_path_factory):
    """Impacts at BPFI ringing at 1700 Hz, stronger once a turn, over shaft lines and noise."""
    rng = np.random.default_rng(0)
    gaps = (1 + 0.003 * rng.normal(size=2000)) / (INNER * SPEED)
    starts = np.cumsum(gaps)
    starts = starts[starts < TIME[-1]]
    height = 1 + 0.8 * np.cos(2 * np.pi * SPEED * starts)
    last = np.maximum(np.searchsorted(starts, TIME, side="right") - 1, 0)
    after = np.maximum(TIME - starts[last], 0)
    ring = height[last] * np.exp(-700 * after) * np.sin(2 * np.pi * 1700 * after)
    shaft = sum(np.cos(2 * np.pi * k * SPEED * TIME) / k for k in (1, 2, 3))
    signal = 4 * ring + shaft + rng.normal(0, 0.3, TIME.size)
    return write_csv(tmp_path_factory.mktemp("envelope") / "inner.csv", {"de (g)": signal})


def answer(monkeypatch, capsys, *arguments) -> dict:
    assert run(monkeypatch, "envelope", *arguments, "--json") == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("prepare", ["none", "random", "prewhiten"])
def test_the_rhythm_is_named_with_its_sidebands(damaged, monkeypatch, capsys, prepare):
    found = answer(monkeypatch, capsys, damaged, "--speed", "1480", "--bearing", "6205", "--prepare", prepare)
    assert found["speed"]["mean_rpm"] == pytest.approx(60 * SPEED, rel=1e-3)
    (channel,) = found["channels"]
    low, high = channel["band_hz"]
    assert low < 1900
    assert high > 1500
    named = {line["name"]: line for line in channel["lines"]}
    line = next(line for name, line in named.items() if name and name.startswith("1 x BPFI") and name[-2:] != "1X")
    assert line["order"] == pytest.approx(INNER, rel=0.01)
    assert line["signal_to_noise_db"] > 15
    assert any(name and "BPFI" in name and name.endswith("1 x 1X") for name in named)


def test_a_band_may_be_given(damaged, monkeypatch, capsys):
    found = answer(monkeypatch, capsys, damaged, "--speed", "1480", "--bearing", "6205", "--band", "1400-2000")
    assert found["channels"][0]["band_hz"] == [1400, 2000]


def test_page_and_table(damaged, monkeypatch, capsys, tmp_path):
    page = tmp_path / "e.html"
    assert run(monkeypatch, "envelope", damaged, "--speed", "1480", "--bearing", "6205", "--report", page) == 0
    assert all(len(line) <= 80 for line in capsys.readouterr().out.splitlines() if not line.startswith("report"))
    drawn = payload(page)
    assert drawn["heat-1"]["unit"] == "kurtosis"
    assert drawn["envelope"][0]["lines"]
    assert any(group["on"] and "BPFI" in group["group"] for group in drawn["cursors"])
    assert "BPFI" in page.read_text("utf-8").split("</h1>")[0]


def test_noise_says_so(tmp_path, monkeypatch, capsys):
    path = write_csv(tmp_path / "noise.csv", {"x (g)": np.random.default_rng(1).normal(size=TIME.size)})
    assert run(monkeypatch, "envelope", path) == 0
    out = capsys.readouterr().out
    assert "speed  not found" in out
    assert "no more than noise" in out
    assert "No line of the envelopes" in out


def test_a_family_takes_its_sidebands_before_another_bearing_may():
    """BPFO of one bearing at 107.6 Hz less 1X is near twice another's BPFO."""
    time = np.array([0.0, 1.0])
    shaft = Shaft("tacho", 29.93, 29.93, 29.93, 1.0, time, True, time, time, time)
    rhythms = (Rhythm("BPFO one", 107.3, None, "1X"), Rhythm("BPFO two", 92.0, None, "1X"))
    names = _names([107.64, 185.36, 215.28], rhythms, shaft, 0.1)
    assert names == ["1 x BPFO one", "2 x BPFO one - 1 x 1X", "2 x BPFO one"]


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("--band", "2000"), 2, "Write 2000-4000"),
        (("--band", "3000-2000"), 2, "lower one first"),
        (("--band", "2000-9000"), 3, "half the sampling rate"),
        (("--band", "2000-2000.001"), 3, "Hz wide or wider"),
        (("--prepare", "magic"), 2, "none, random, prewhiten"),
    ],
)
def test_wrong_options(damaged, monkeypatch, capsys, arguments, code, message):
    assert run(monkeypatch, "envelope", damaged, *arguments) == code
    assert message in capsys.readouterr().err
