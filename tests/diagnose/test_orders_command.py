"""``rotorwise orders`` on a run-up of known amplitude and phase: tacho, no tacho, JSON, page, refusals."""

from __future__ import annotations

import json

import numpy as np
import pytest

from .look_files import RATE, expanded, payload, run, write_csv

TIME = np.arange(30_000) / RATE
SPEED = 12 + 3 * TIME
ANGLE = np.cumsum(SPEED) / RATE + 0.3


@pytest.fixture(scope="module")
def run_up(tmp_path_factory):
    """Two probes at right angles: a forward ellipse of 40 x 20 um at 1X, 5 um at 2X; a pulse a turn."""
    rng = np.random.default_rng(0)
    columns = {
        "x (um)": 40 * np.cos(2 * np.pi * ANGLE + 0.5) + 5 * np.cos(4 * np.pi * ANGLE) + rng.normal(0, 1, TIME.size),
        "y (um)": 20 * np.sin(2 * np.pi * ANGLE + 0.5) + rng.normal(0, 1, TIME.size),
        "tacho (V)": 5.0 * ((ANGLE % 1.0) < 0.05),
    }
    return write_csv(tmp_path_factory.mktemp("orders") / "run_up.csv", columns)


def test_amplitude_phase_and_orbit_with_a_tacho(run_up, monkeypatch, capsys):
    assert run(monkeypatch, "orders", run_up, "--tacho", "tacho", "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["speed"]["method"] == "tacho"
    assert answer["speed"]["lowest_rpm"] == pytest.approx(60 * 12.2, rel=0.02)
    assert answer["speed"]["highest_rpm"] == pytest.approx(60 * 29.8, rel=0.02)
    found = {(one["channel"], one["order"]): one for one in answer["orders"]}
    # 0.2 dB is 2.3 %.
    assert found["x", 1.0]["median"] == pytest.approx(40e-6, rel=0.023)
    assert found["y", 1.0]["median"] == pytest.approx(20e-6, rel=0.023)
    assert found["x", 2.0]["median"] == pytest.approx(5e-6, rel=0.05)
    # The edge lies up to 1.5 samples before the whole turn.
    assert found["x", 1.0]["phase_deg_at_largest"] == pytest.approx(np.degrees(0.5), abs=4.0)
    assert found["y", 3.0]["phase_deg_at_largest"] is None
    orbit = next(one for one in answer["orbits"] if one["order"] == 1.0)
    assert orbit["major"] == pytest.approx(40e-6, rel=0.05)
    assert orbit["whirl"] == pytest.approx(0.5, abs=0.05)


def test_a_run_through_a_resonance_shows_the_critical_speed(monkeypatch, capsys, tmp_path):
    speed, natural, ratio = 60 * SPEED, 1200.0, 0.08
    motion = 10 * speed**2 / (natural**2 - speed**2 + 2j * ratio * natural * speed) * np.exp(2j * np.pi * ANGLE)
    noise = np.random.default_rng(0).normal(0, 1, TIME.size)
    # The lines of a steady machine: what shows late is taken off, by 18 rpm here.
    columns = {"x (um)": motion.real + noise, "tacho (V)": 5.0 * ((ANGLE % 1.0) < 0.05)}
    path = write_csv(tmp_path / "through.csv", columns)
    assert run(monkeypatch, "orders", path, "--tacho", "tacho", "--bandwidth", 5, "--json") == 0
    (found,) = json.loads(capsys.readouterr().out)["critical_speeds"]
    late = 180.0 / (ratio * natural * np.pi / 30)
    assert found["speed_rpm"] + late == pytest.approx(natural, rel=0.005)
    assert found["damping_ratio"] == pytest.approx(ratio, rel=0.1)
    assert run(monkeypatch, "orders", path, "--tacho", "tacho", "--bandwidth", 5) == 0
    assert "critical speed  11" in capsys.readouterr().out
    page = tmp_path / "through.html"
    assert run(monkeypatch, "orders", path, "--tacho", "tacho", "--bandwidth", 5, "--report", page) == 0
    assert "Critical speed 11" in page.read_text(encoding="utf-8")


def test_without_a_tacho_the_speed_is_tracked_in_the_vibration(run_up, monkeypatch, capsys):
    arguments = ("--skip", "tacho", "--speed-range", "500-2500", "--json")
    assert run(monkeypatch, "orders", run_up, *arguments) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["speed"]["method"] == "vibration, tracked"
    assert answer["speed"]["mean_rpm"] == pytest.approx(60 * SPEED.mean(), rel=2e-3)
    assert answer["critical_speeds"] == []  # 1X has no phase
    first = answer["orders"][0]
    assert first["median"] == pytest.approx(40e-6, rel=0.03)
    assert first["phase_deg_at_largest"] is None


def test_the_table_fits_and_the_page_holds_the_pictures(run_up, monkeypatch, capsys, tmp_path):
    page = tmp_path / "orders.html"
    assert run(monkeypatch, "orders", run_up, "--tacho", "tacho", "--report", page, "--orders", "0.5,1,2") == 0
    out = capsys.readouterr().out
    assert all(len(line) <= 80 for line in out.splitlines() if not line.startswith("report"))
    assert "0.5X" in out
    assert "forward" in out
    drawn = payload(page)
    assert [one["name"] for one in drawn["heat-1"]["channels"]] == ["x", "y"]
    top = np.array(drawn["heat-1"]["channels"][0]["z"], dtype=float)
    assert drawn["heat-1"]["channels"][0]["y"][int(top.mean(axis=1).argmax())] == pytest.approx(1.0)
    assert drawn["orbit"]["channels"] == ["x", "y"]
    # 40 x 20 um forward is a circle of 30 forward and one of 10 backward; 5 um at 2X on one probe is 2.5 in both.
    (whirl,) = next(drawn[f"graph-{n}"] for n in range(1, 7) if "backward" in drawn[f"graph-{n}"][0]["x"])
    (curve,) = whirl["traces"]
    order, radius = expanded(curve["curve"])
    for place, expected in ((1, 30.0), (-1, 10.0), (2, 2.5), (-2, 2.5)):
        near = np.abs(order - place) < 0.1
        assert radius[near].max() == pytest.approx(expected, rel=0.05)
    # The run-up is drawn against frequency too: the highest cell of a column is 1X, at the speed there.
    waterfall = drawn["heat-2"]["channels"][0]
    levels = np.array(waterfall["z"], dtype=float)
    middle = len(waterfall["x"]) // 2
    speed = 12 + 3 * waterfall["x"][middle]
    assert waterfall["y"][int(levels[:, middle].argmax())] == pytest.approx(speed, abs=8.0)
    # An existing report is kept unless told otherwise.
    assert run(monkeypatch, "orders", run_up, "--tacho", "tacho", "--report", page) == 4
    assert "exists already" in capsys.readouterr().err


def test_noise_has_no_speed(tmp_path, monkeypatch, capsys):
    path = write_csv(tmp_path / "noise.csv", {"x (g)": np.random.default_rng(1).normal(size=TIME.size)})
    assert run(monkeypatch, "orders", path) == 3
    assert "Give --tacho" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--orders", "one"), "Write 0.5,1,2"),
        (("--orders", "-1"), "allowed"),
        (("--speed-range", "900"), "Write 600-3000"),
        (("--speed-range", "900-300"), "lower one first"),
        (("--highest-order", "0"), "allowed"),
        (("--highest-order", "0.001"), "allowed: 1 to 1000"),
    ],
)
def test_wrong_options(run_up, monkeypatch, capsys, arguments, message):
    assert run(monkeypatch, "orders", run_up, *arguments) == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--orders", "1,300"), "half the sampling rate at 7"),
        (("--bandwidth", "1e-12"), "a tenth of one over the record's length"),
        (("--bandwidth", "60"), "Give a narrower one"),
        (("--skip", "tacho", "--speed-range", "0.001-0.002"), "between 0.001 and 0.002 rpm"),
        (("--skip", "x", "--skip", "y"), "the file holds tacho (tacho)"),
    ],
)
def test_what_a_record_cannot_hold_is_refused(run_up, monkeypatch, capsys, arguments, message):
    """Each of them once gave a wrong number or a traceback."""
    tacho = () if "tacho" in arguments else ("--tacho", "tacho")
    assert run(monkeypatch, "orders", run_up, *tacho, *arguments) == 3
    assert message in capsys.readouterr().err


def test_an_order_beyond_the_map_has_its_own_noise_and_none_where_the_rate_ends(tmp_path, monkeypatch, capsys):
    """Order 120 of 12 to 30 Hz passes half of 5 kHz at 20.8 Hz; noise of 1 is some 0.03 in a frame of the map."""
    rng = np.random.default_rng(3)
    columns = {
        "x (um)": 40 * np.cos(2 * np.pi * ANGLE) + rng.normal(0, 1, TIME.size),
        "tacho (V)": 5.0 * ((ANGLE % 1.0) < 0.05),
    }
    path = write_csv(tmp_path / "high.csv", columns)
    assert run(monkeypatch, "orders", path, "--tacho", "tacho", "--orders", "1,120", "--json") == 0
    _, high = json.loads(capsys.readouterr().out)["orders"]
    assert high["rpm_at_largest"] < 60 * 0.5 * RATE / 120
    assert 0 < high["median"] < 0.3e-6
    # The largest of some 40 independent values of noise: 10 dB and less above its mean.
    assert abs(high["over_noise_db"]) < 15


def test_a_tacho_that_stops_is_told_and_gives_no_amplitudes_after_it(tmp_path, monkeypatch, capsys):
    """The speed goes on rising: an angle that runs on at the last speed would put 1X elsewhere."""
    columns = {
        "x (um)": 40 * np.cos(2 * np.pi * ANGLE + 0.5),
        "tacho (V)": 5.0 * (((ANGLE % 1.0) < 0.05) & (TIME < 4.0)),
    }
    path = write_csv(tmp_path / "stops.csv", columns)
    assert run(monkeypatch, "orders", path, "--tacho", "tacho", "--orders", "1", "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    assert "after the last one" in answer["warnings"][0]
    assert answer["orders"][0]["median"] == pytest.approx(40e-6, rel=0.023)
    assert answer["orders"][0]["rpm_at_largest"] < 60 * (12 + 3 * 4.2)


def test_a_tacho_without_pulses_is_told(tmp_path, monkeypatch, capsys):
    columns = {
        "x (um)": sum(np.cos(2 * np.pi * n * 25 * TIME) for n in (1, 2, 3)),
        "tacho (V)": np.full(TIME.size, 5.0),
    }
    path = write_csv(tmp_path / "silent.csv", columns)
    assert run(monkeypatch, "orders", path, "--tacho", "tacho", "--speed", "1500", "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    assert any("no pulse train" in warning for warning in answer["warnings"])
    assert answer["speed"]["method"].startswith("vibration")


def test_a_missing_file_is_told(monkeypatch, capsys):
    assert run(monkeypatch, "orders", "/nowhere.csv") == 3
    assert "no such file" in capsys.readouterr().err
