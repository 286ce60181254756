"""``rotorwise envelope`` on impacts of a known bearing: names, bands, preparation, page, refusals."""

from __future__ import annotations

import json

import numpy as np
import pytest
from rotorwise.diagnose.envelope_zoom import EnvelopeLine, Rhythm, ZoomPlace, zoom_places, zoomed
from rotorwise.diagnose.envelopes import _names
from rotorwise.diagnose.look import Shaft
from rotorwise.diagnose.signal.spectrum import Spectrum
from rotorwise.simulators.rotor_dynamics.rolling_bearing import find_bearing

from .look_files import RATE, expanded, payload, run, write_csv

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


def test_the_page_zooms_on_the_defect_and_its_sidebands(damaged, monkeypatch, capsys, tmp_path):
    page = tmp_path / "z.html"
    options = ("--speed", "1480", "--bearing", "6205")
    lines = answer(monkeypatch, capsys, damaged, *options)["channels"][0]["lines"]
    assert run(monkeypatch, "envelope", damaged, *options, "--report", page) == 0
    parts = {part["name"].split(": ")[1].split(" 6205")[0]: part for part in payload(page)["graph-1"]}
    assert list(parts) == ["1 x BPFI", "2 x BPFI", "3 x BPFI"]
    for harmonic, part in enumerate(parts.values(), start=1):
        envelope, _, marks = part["traces"]
        frequency, depth = expanded(envelope["curve"])
        line = next(one for one in lines if one["name"].startswith(f"{harmonic} x BPFI") and one["name"][-2:] != "1X")
        # The table takes a line that slip has spread for a tone's: height to 2 %, place to a sixth of a bin.
        assert frequency[depth.argmax()] == pytest.approx(line["frequency_hz"], abs=0.02)
        assert depth.max() == pytest.approx(line["depth"], rel=0.02)
        assert np.diff(marks["x"]) == pytest.approx(SPEED, rel=1e-3)
        at_first_pair = [np.interp(place, frequency, depth) for place in (marks["x"][1], marks["x"][3])]
        assert min(at_first_pair) > 0.3 * depth.max()  # struck harder once a turn, 1 + 0.8 cos: 0.4 of the carrier
        assert marks["text"][1] == f"{harmonic} x BPFI - 1 x 1X"


def test_a_zoom_has_the_height_that_theory_says():
    """(1 + m cos)^2 over its mean 1 + m^2/2 has lines 2 m and m^2/2 over that mean.

    Ten points to a bin: the nearest is a 20th of a bin off at most, where a Hann line is down by
    (pi^2/6 - 1) / 400 = 1.6e-3.
    """
    m, beat = 0.4, 20.125
    signal = (1 + m * np.cos(2 * np.pi * beat * TIME)) * np.cos(2 * np.pi * 1200 * TIME)
    places = tuple(ZoomPlace(f"{k}", k * beat - 3, k * beat + 3, ()) for k in (1, 2))
    first, second = zoomed(signal, RATE, (1000.0, 1400.0), places)
    assert first.depth.max() == pytest.approx(2 * m / (1 + m**2 / 2), rel=1.7e-3)
    assert second.depth.max() == pytest.approx(m**2 / 2 / (1 + m**2 / 2), rel=1.7e-3)
    assert first.frequency_hz[first.depth.argmax()] == pytest.approx(beat, abs=0.02)


def spectrum_up_to(highest_hz: float) -> Spectrum:
    frequency = np.arange(0.0, highest_hz, 0.125)
    return Spectrum(frequency, np.ones((1, frequency.size)), np.ones((1, frequency.size)))


def shaft_at(speed_hz: float) -> Shaft:
    time = np.array([0.0, 1.0])
    return Shaft("tacho", speed_hz, speed_hz, speed_hz, 1.0, time, True, time, time, time)


def test_zooms_stay_inside_the_spectrum():
    rhythm = Rhythm("FTF x", 10.0, None, "1X")
    line = EnvelopeLine(10.1, 0.4, 1.0, 100.0, "1 x FTF x")
    places = zoom_places((line,), (rhythm,), shaft_at(25.0), spectrum_up_to(25.0))
    assert [one.name for one in places] == ["1 x FTF x", "2 x FTF x"]
    assert all(0 <= one.low_hz < one.high_hz < 25 for one in places)
    assert places[1].expected == (("2 x FTF", pytest.approx(20.2)),)


def test_a_ball_defect_is_looked_at_with_sidebands_of_the_cage():
    rhythm = Rhythm("2BSF x", 120.0, 10.0, "FTF")
    line = EnvelopeLine(240.0, 9.6, 1.0, 100.0, "2 x 2BSF x")
    first = zoom_places((line,), (rhythm,), shaft_at(25.0), spectrum_up_to(600.0))[0]
    assert [place for _, place in first.expected] == pytest.approx([100, 110, 120, 130, 140])
    assert first.expected[3][0] == "1 x 2BSF + 1 x FTF"


def test_without_a_named_line_the_strongest_is_looked_at():
    lines = (EnvelopeLine(77.0, None, 1.0, 100.0, ""), EnvelopeLine(31.0, None, 0.5, 50.0, ""))
    (place,) = zoom_places(lines, (), None, spectrum_up_to(200.0))
    assert place.name == "77.00 Hz"
    assert (place.low_hz, place.high_hz) == pytest.approx((77 - 20 * 0.125, 77 + 20 * 0.125))
    assert zoom_places((), (), None, spectrum_up_to(200.0)) == ()


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
