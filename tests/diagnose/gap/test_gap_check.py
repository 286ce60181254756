"""`rotorwise gap --check`: what was understood of the files, without a search; what is left out is said to be."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from rotorwise.datasets.reading import read
from rotorwise.datasets.simulated import record_machine
from rotorwise.datasets.write import write_recording
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.sensor_chain import SensorChain

from ..command import run

ROTOR = find_machine("amb_rotor")
SPEEDS_RPM = (1500.0, 2100.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    base = tmp_path_factory.mktemp("campaign")
    (base / "baseline").mkdir()
    chain = SensorChain(pulses_per_revolution=1, noise={"m": 2e-8})
    for i, speed in enumerate(SPEEDS_RPM):
        for name, seed in (("baseline/", i), ("", 50 + i)):
            made = record_machine(ROTOR, speed_rpm=speed, duration_s=1.0, rate_hz=2000.0, chain=chain, seed=seed)
            place = base / f"{name}{speed:.0f}.npz"
            write_recording(made.recording, place, file_format="npz", notes={}, remarks="", force=False)
    # A record of the machine at rest: noise, and a tacho without pulses.
    rest = made.recording
    signals = np.random.default_rng(3).normal(scale=2e-8, size=rest.signals.shape)
    for i, channel in enumerate(rest.channels):
        if channel.quantity == "tacho":
            signals[i] = 0.0
    object.__setattr__(rest, "signals", signals)
    write_recording(rest, base / "rest.npz", file_format="npz", notes={}, remarks="", force=False)
    return base


def test_records_speeds_and_channels_are_shown(folder):
    done = run("gap", folder, "--machine", "amb_rotor", "--check", environment={"COLUMNS": "80"})
    lines = done.stdout.splitlines()
    assert all(len(line) <= 80 for line in lines)
    for speed in SPEEDS_RPM:
        rows = [line for line in lines if line.startswith(f"{speed:.0f}.npz")]
        assert ["to explain" in row for row in rows] == [True, False]
        assert all("tacho, 1 a turn" in row for row in rows)
    assert "path_1 is path_1" in done.stdout
    assert "The model explains" not in done.stdout


def test_json_is_what_was_read(folder):
    done = run("gap", folder, "--machine", "amb_rotor", "--check", "--json")
    data = json.loads(done.stdout)
    for role in ("healthy", "to explain"):
        # Edges of pulses fall between samples: within half a sample of the second.
        speeds = [one["speed_rpm"] for one in data["recordings"] if one["role"] == role]
        assert speeds == pytest.approx(SPEEDS_RPM, rel=5e-4)
    assert data["channels"] == {f"path_{n}": f"path_{n}" for n in (1, 2, 3, 4)}
    sizes = data["sizes"]["path_1"]
    assert (sizes["quantity"], sizes["unit"]) == ("displacement", "m")
    assert 1e-6 < sizes["rms"] < 1e-3
    assert len(data["unreadable"]) == 1


def test_a_machine_at_rest_is_left_out_and_the_silent_tacho_is_named(folder):
    done = run("gap", folder, "--machine", "amb_rotor", "--check")
    assert done.returncode == 3
    assert "left out: rest.npz: tacho" in done.stderr
    assert "shows no pulses" in done.stderr
    assert "Traceback" not in done.stderr


def test_what_a_campaign_lacks_is_told(folder, tmp_path):
    done = run("gap", folder, "--machine", "amb_rotor", "--check", environment={"COLUMNS": "200"})
    assert "m rms, healthy " in done.stdout
    assert "one speed" not in done.stdout
    assert "--baseline" not in done.stdout
    (tmp_path / "one.npz").write_bytes((folder / f"{SPEEDS_RPM[0]:.0f}.npz").read_bytes())
    done = run("gap", tmp_path, "--machine", "amb_rotor", "--check", environment={"COLUMNS": "200"})
    assert "All recordings to explain are of one speed" in done.stdout
    assert "No recordings of the healthy machine" in done.stdout


def test_wrong_probe_stops_at_once(folder):
    done = run("gap", folder, "--machine", "amb_rotor", "--check", "--probe", "X=path_9")
    assert (done.returncode, done.stdout) == (2, "")
    assert "no probe 'path_9'" in done.stderr


def test_check_writes_nothing_and_says_so(folder, tmp_path):
    for option, name in (("--report", "a.html"), ("--output", "a.toml")):
        done = run("gap", folder, "--machine", "amb_rotor", "--check", option, tmp_path / name)
        assert (done.returncode, done.stdout) == (2, "")
        assert f"--check only reads; allowed: no {option}" in done.stderr
        assert not (tmp_path / name).exists()


def test_a_dead_tacho_beside_a_stated_speed_is_not_called_a_tacho(folder, tmp_path):
    made = read(folder / "1500.npz")
    signals = made.signals.copy()
    signals[[channel.quantity == "tacho" for channel in made.channels]] = 0.0
    dead = replace(made, signals=signals, condition=replace(made.condition, speed_rpm=1500.0))
    write_recording(dead, tmp_path / "dead.npz", file_format="npz", notes={}, remarks="", force=False)
    done = run("gap", tmp_path, "--machine", "amb_rotor", "--check", "--json")
    data = json.loads(done.stdout)
    (row,) = data["recordings"]
    assert row["speed_from"] == "vibration"
    assert any("phases there do not refer to the shaft" in one for one in data["notes"])


def test_channels_that_point_elsewhere_than_their_probes_are_told(folder):
    swapped = ("--probe", "path_1=path_2", "--probe", "path_2=path_1")
    notes = json.loads(run("gap", folder, "--machine", "amb_rotor", "--check", "--json", *swapped).stdout)["notes"]
    assert any("path_1 is horizontal, and probe path_2 along y. Check --probe." in one for one in notes)
    notes = json.loads(run("gap", folder, "--machine", "amb_rotor", "--check", "--json").stdout)["notes"]
    assert not any("Check --probe" in one for one in notes)


def test_a_machine_that_does_not_run_is_told_before_any_search(folder):
    shown = ("gap", folder, "--machine", "amb_rotor", "--check", "--json")
    assert not any("stably" in one for one in json.loads(run(*shown).stdout)["notes"])
    notes = json.loads(run(*shown, "--preset", "as_printed").stdout)["notes"]
    assert any("preset as_printed) does not run stably at these speeds" in one for one in notes)
