"""`rotorwise simulate`: the record is the simulation, the files hold what made them, wrong values write nothing."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rotorwise.datasets.reading import read
from rotorwise.datasets.simulated import MOST_SAMPLES, label_of, nameplate_of, record_machine, recordable
from rotorwise.diagnose.signal.speed import speed_from_tacho
from rotorwise.diagnose.simulate_command import _notes, check_ours
from rotorwise.diagnose.simulate_options import CHAINS, parse_chain, parse_effect, parse_machine, parse_speed
from rotorwise.simulators.assembly import Probe
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine, machine_from_toml
from rotorwise.simulators.speed_profile import SpeedProfile, ramp

from .command import Done, run

SHORT = ("--speed", 3000, "--duration", 0.5, "--rate", 2000)


def rotorwise(*arguments: object, cwd: Path | None = None) -> Done:
    done = run(*arguments, cwd=cwd)
    assert "Traceback" not in done.stderr + done.stdout, done.stderr
    return done


# ---- theory: the record is the simulation ----


def test_an_ideal_chain_records_the_simulation_itself() -> None:
    machine = find_machine("amb_rotor").with_effects(Unbalance(moment_kg_m=2e-4, angle_rad=0.3))
    run = machine.simulate(speed_rpm=3000.0, duration_s=0.5, rate_hz=2000.0)
    made = record_machine(machine, speed_rpm=3000.0, duration_s=0.5, rate_hz=2000.0).recording
    np.testing.assert_array_equal(made.signals[:-1], run.signals)
    assert [one.quantity for one in made.channels] == ["displacement"] * 4 + ["tacho"]
    assert [one.direction for one in made.channels[:2]] == ["horizontal", "vertical"]
    assert made.condition.speed_rpm == pytest.approx(3000.0, rel=1e-14)


@pytest.mark.parametrize("pulses", [1, 4])
def test_tacho_follows_a_run_up(pulses: int) -> None:
    """Pulses of a ramp: as many as turns, and their mean rate is the mean speed."""
    chain = parse_chain("ideal", pulses_per_revolution=pulses)
    profile = ramp(start_rpm=1500.0, stop_rpm=2500.0, duration_s=2.0)
    made = record_machine(find_machine("amb_rotor"), speed_rpm=profile, duration_s=2.0, rate_hz=4096.0, chain=chain)
    tacho = made.recording.signals[-1]
    turns = (1500 + 2500) / 2 / 60 * 2.0
    assert np.count_nonzero(np.diff(tacho) > 0.5) == pytest.approx(turns * pulses, abs=1)
    assert made.recording.pulses_per_revolution == pulses
    # A run-up has no nominal speed.
    assert made.recording.condition.speed_rpm is None
    found = speed_from_tacho(tacho, rate_hz=4096.0, pulses_per_revolution=pulses)
    assert found is not None
    assert found[0].speed_hz == pytest.approx(2000 / 60, rel=0.03)


def test_nameplate_is_what_the_owner_knows() -> None:
    rig = nameplate_of(find_machine("test_rig").preset("adi"))
    assert [one.location for one in rig.bearings] == ["bearing_a", "bearing_b"]
    assert rig.bearings[0].geometry.defect_orders().outer_race == pytest.approx(3.05, abs=0.01)
    box = nameplate_of(find_machine("gearbox"))
    assert [(one.driver_teeth, one.driven_teeth, one.mesh_order) for one in box.gears] == [(23, 81, 23.0)]
    assert [one.shaft_ratio for one in box.bearings] == pytest.approx([1.0, 1.0, 23 / 81, 23 / 81])
    assert nameplate_of(find_machine("amb_rotor")).magnetic_bearing_clearance_m == 125e-6
    assert rig.magnetic_bearing_clearance_m is None
    humming = find_machine("test_rig").with_effects(parse_effect("mains_hum:supply_hz=60"))
    assert nameplate_of(humming).line_frequency_hz == 60.0


def test_label_names_effects_places_and_values() -> None:
    effects = [parse_effect("unbalance@disc:moment_kg_m=2e-4,angle_rad=0"), parse_effect("mains_hum:amplitude=0.1")]
    first = "unbalance at disc (moment_kg_m 0.0002 kg.m, angle_rad 0 rad, axial_offset_m 0 m); mains_hum ("
    assert label_of(effects).startswith(first)


def test_torsion_is_recorded_as_an_angle() -> None:
    machine = find_machine("rigid_coupling")
    made = record_machine(machine, speed_rpm=1500.0, duration_s=0.2, rate_hz=1000.0, probes=["twist"]).recording
    assert (made.channels[0].quantity, made.channels[0].unit) == ("angle", "rad")
    run = machine.simulate(speed_rpm=1500.0, duration_s=0.2, rate_hz=1000.0, probes=["twist"])
    np.testing.assert_array_equal(made.signals[0], run.signals[0])


def test_what_a_recording_cannot_hold_is_left_out_and_said() -> None:
    path, heat = (Probe(name, "displacement", unit, "hub", "x", {}) for name, unit in (("path", "m"), ("heat", "K")))
    kept, notes = recordable([path, heat], [])
    assert kept == [path]
    assert any("heat (K)" in note for note in notes)
    with pytest.raises(InvalidValueError, match="None of the probes heat"):
        recordable([path, heat], ["heat"])


def test_error_estimate_is_small_for_the_shipped_step() -> None:
    made = record_machine(
        find_machine("amb_rotor"), speed_rpm=3000.0, duration_s=0.5, rate_hz=2000.0, estimate_error=True
    )
    assert set(made.errors) == {f"path_{n}" for n in range(1, 5)}
    assert 0 < max(made.errors.values()) < 1e-3


def test_noise_has_the_stated_density_and_depends_on_the_seed() -> None:
    chain = parse_chain("ideal:noise.m=1e-6", pulses_per_revolution=0)
    still = find_machine("amb_rotor").with_parameters(unbalance_kg_m=0.0)
    signals = [
        record_machine(
            still, speed_rpm=3000.0, duration_s=2.0, rate_hz=2000.0, chain=chain, seed=seed
        ).recording.signals
        for seed in (1, 1, 2)
    ]
    assert signals[0].shape[0] == 4
    np.testing.assert_array_equal(signals[0], signals[1])
    assert not np.array_equal(signals[0], signals[2])
    # White noise of one-sided density d up to half the rate: rms d sqrt(1000 Hz); 4 x 4000 samples know it to 1 %.
    assert signals[2].std() == pytest.approx(1e-6 * math.sqrt(1000), rel=0.04)


# ---- words of the command line ----


def test_speed_is_a_number_or_a_run_up() -> None:
    assert parse_speed("1800", duration_s=2.0) == 1800.0
    assert parse_speed("600..3000.5", duration_s=2.0) == ramp(start_rpm=600.0, stop_rpm=3000.5, duration_s=2.0)
    assert isinstance(parse_speed("3000..600", duration_s=1.0), SpeedProfile)
    for text in ("", "fast", "1..2..3", "600..", "nan", "-5", "0", "1e7"):
        with pytest.raises(InvalidValueError, match="allowed"):
            parse_speed(text, duration_s=2.0)


def test_effects_are_read_with_place_and_values() -> None:
    effect = parse_effect("outer_race_defect@bearing 1: angle_rad = 0.5")
    assert (effect.NAME, effect.at, effect.values()["angle_rad"]) == ("outer_race_defect", "bearing 1", 0.5)
    for text, words in (
        ("hole", "'hole' is unknown; allowed: "),
        ("unbalance:mass=1", "no parameter 'mass'; allowed: moment_kg_m"),
        ("unbalance:moment_kg_m=1", "allowed: 0 to 0.1 kg.m"),
        ("unbalance:moment_kg_m", "'moment_kg_m' is not understood"),
        ("unbalance:moment_kg_m=x", "is not a number"),
        ("unbalance:moment_kg_m=1e-4,moment_kg_m=2e-4", "given twice"),
        ("unbalance@:moment_kg_m=1e-4", "no place after"),
    ):
        with pytest.raises(InvalidValueError, match=words.replace("(", r"\(")):
            parse_effect(text)


def test_machines_come_from_name_or_file(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text(find_machine("test_rig").preset("adi").with_parameters(shaft_load_kg=5.0).to_toml())
    mine = parse_machine(str(file), preset="", settings=(), load=None)
    assert (mine.preset_name, dict(mine.changed)) == ("adi", {"shaft_load_kg": 5.0})
    other = parse_machine(str(file), preset="plausible", settings=["disc_mass_kg=1.5"], load=2.0)
    assert (other.preset_name, dict(other.changed)) == ("plausible", {"shaft_load_kg": 2.0, "disc_mass_kg": 1.5})
    with pytest.raises(InvalidValueError, match="amb_rotor has no load"):
        parse_machine("amb_rotor", preset="", settings=(), load=1.0)


def test_chains_are_named_and_changed() -> None:
    assert parse_chain("mems", pulses_per_revolution=0) == CHAINS["mems"]
    chain = parse_chain("accelerometer:bits=16,noise.m/s2=1e-3,full_scale.m=1e-3", pulses_per_revolution=2)
    assert (chain.bits, chain.noise, chain.pulses_per_revolution) == (16, {"m/s2": 1e-3}, 2)
    assert chain.full_scale == {"m/s2": 490.0, "m": 1e-3}
    for text, words in (
        ("tape", "'tape' is unknown; allowed: ideal"),
        ("ideal:hiss=1", "'hiss' is unknown; allowed: mounting_hz"),
        ("ideal:bits=2.5", "a whole number"),
        ("ideal:bits=many", "is not a number"),
        ("ideal:noise.furlong=1", r"'noise.furlong' is unknown"),
        ("ideal:pole_hz=-1", "more than 0"),
    ):
        with pytest.raises(InvalidValueError, match=words):
            parse_chain(text, pulses_per_revolution=1)


# ---- the command ----


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], Path]:
    folder = tmp_path_factory.mktemp("simulate")
    done = rotorwise(
        "simulate", "amb_rotor", *SHORT, "--with", "unbalance@disc:moment_kg_m=2e-4", "--set", "derivative=7e-4",
        "--chain", "ideal:noise.m=1e-9", "--seed", 3, "--json", "--estimate-error", "-o", folder / "run.h5",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), folder


def test_json_says_what_was_written(made: tuple[dict[str, Any], Path]) -> None:
    said, folder = made
    assert (said["samples"], said["rate_hz"], said["format"]) == (1000, 2000.0, "hdf5")
    assert said["speed_rpm"] == pytest.approx(3000.0)
    assert set(said["errors"]) == {f"path_{n}" for n in range(1, 5)}
    assert said["step_s"] <= 5e-4
    back = read(folder / "run.h5")
    assert (back.label, back.samples) == (said["label"], 1000)
    rms = back.signals.std(axis=1)
    assert [one["rms"] for one in said["channels"]] == pytest.approx(rms.tolist())


def test_the_sidecar_holds_a_machine_that_makes_the_same_record(made: tuple[dict[str, Any], Path]) -> None:
    said, folder = made
    comments = [line.removeprefix("#").strip() for line in (folder / "run.toml").read_text().splitlines()]
    text = "\n".join(comments[comments.index("format = 1") : comments.index("[recording]")])
    machine = machine_from_toml(text)
    assert machine == machine_from_toml(said["provenance"]["machine"])
    chain = parse_chain("ideal:noise.m=1e-9", pulses_per_revolution=1)
    again = record_machine(machine, speed_rpm=3000.0, duration_s=0.5, rate_hz=2000.0, chain=chain, seed=3)
    # To rounding: the number of threads of the linear algebra may differ from process to process.
    found = read(folder / "run.h5").signals
    np.testing.assert_allclose(again.recording.signals, found, rtol=0, atol=1e-9 * np.abs(found).max())
    command = next(line for line in comments if line.startswith("command: "))
    assert "--seed 3" in command
    assert any(line.startswith("versions: rotorwise ") for line in comments)


def test_every_format_holds_the_same_record(tmp_path: Path) -> None:
    """By suffix and by name; that each comes back unchanged is tested with the writers."""
    found = []
    for name, more in (("a.csv", ()), ("b.dat", ("--format", "wav")), ("c.mat", ())):
        done = rotorwise("simulate", "amb_rotor", *SHORT, *more, "-o", tmp_path / name)
        assert done.returncode == 0, done.stderr
        assert "label: healthy" in done.stdout
        found.append(read(tmp_path / name))
    for other in found[1:]:
        np.testing.assert_array_equal(other.signals, found[0].signals)
        assert [one.name for one in other.channels] == [one.name for one in found[0].channels]
        assert (other.condition, other.nameplate) == (found[0].condition, found[0].nameplate)


def test_wrong_values_get_one_message_and_write_nothing(tmp_path: Path) -> None:
    (tmp_path / "mine.csv").write_text("mine")
    (tmp_path / "rig.toml").write_text("format = 1\nmachine = 'amb_rotor'\ncolour = 1\n")
    good = {"machine": "amb_rotor", "--speed": 3000, "--duration": 0.5, "--rate": 2000, "-o": tmp_path / "new.csv"}
    for changes, words in (
        ({"machine": "pump"}, "Machine 'pump' is unknown; allowed: amb_rotor, "),
        ({"machine": tmp_path / "rig.toml"}, "unknown entry 'colour'"),
        ({"machine": tmp_path / "no.toml"}, "cannot be read"),
        ({"--preset": "best"}, "no preset 'best'; allowed: plausible"),
        ({"--set": "clearance_m=1"}, "allowed: 1e-06 to 0.00125 m"),
        ({"--set": "size=1"}, "no parameter 'size'; allowed:"),
        ({"--with": "unbalance@wing"}, "'wing' is no rotor of this machine; allowed: disc"),
        ({"--with": "gear_eccentricity"}, "has no place of the kind 'gear'"),
        ({"--with": "mains_hum@wing"}, "finds no probe 'wing'"),
        ({"--speed": "fast"}, "--speed 600..3000"),
        ({"--speed": -3}, "Speed -3.0 rpm; allowed"),
        ({"--duration": 0}, "allowed: more than 0"),
        ({"--duration": 1e9}, "do not fit the memory; allowed: up to "),
        ({"--rate": "nan"}, "allowed: more than 0"),
        ({"--load": 3}, "has no load"),
        ({"--chain": "ideal:noise.m=1e-9"}, "seed = None"),
        ({"--seed": -1}, "seed = -1; allowed"),
        ({"--probe": "ear"}, "No probe 'ear'; allowed: path_1"),
        ({"--format": "xls"}, "'xls' cannot be written; allowed: csv"),
        ({"-o": tmp_path / "new.xyz"}, "says no format"),
        ({"-o": tmp_path / "mine.csv"}, "exists already"),
        ({"-o": tmp_path / "rig.csv"}, "never replaced"),
        ({"--threads": 0}, "threads = 0; allowed"),
        ({"--pulses-per-revolution": -1}, "0 to 10000"),
    ):
        asked = {**good, **changes}
        arguments = [asked.pop("machine"), *(word for pair in asked.items() for word in pair)]
        done = rotorwise("simulate", *arguments)
        assert done.returncode == 2, (changes, done.stdout, done.stderr)
        assert words in done.stderr, (changes, done.stderr)
        assert done.stdout == ""
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine.csv", "rig.toml"]
    assert (tmp_path / "mine.csv").read_text() == "mine"


def test_numbers_that_are_none_are_repeated_with_what_to_write(tmp_path: Path) -> None:
    good = {"--speed": 3000, "--duration": 0.5, "--rate": 2000, "-o": tmp_path / "a.csv"}
    for option, text, remedy in (
        ("--duration", "0,5", "Write 0.5."),
        ("--rate", "2 kHz", "without unit"),
        ("--load", "-1,5e3", "Write -1.5e3."),
    ):
        words = (word for pair in {**good, option: text}.items() for word in pair)
        done = rotorwise("simulate", "amb_rotor", *words)
        assert done.returncode == 2
        assert f"'{option}': '{text}'; allowed: a number with a decimal point" in done.stderr
        assert remedy in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_force_replaces_recordings_of_this_name_and_nothing_else(tmp_path: Path) -> None:
    def record(name: str, words: str = "") -> Done:
        done = rotorwise("simulate", "amb_rotor", *SHORT, "-o", tmp_path / name, "--force")
        assert words in done.stderr, done.stderr
        return done

    (tmp_path / "mine.csv").write_text("mine")
    assert record("mine.csv", "never replaced").returncode == 2
    # One sidecar cannot serve two recordings.
    assert record("a.csv").returncode == 0
    before = (tmp_path / "a.toml").read_text()
    assert record("a.npz", "is the sidecar of a.csv").returncode == 2
    assert (tmp_path / "a.toml").read_text() == before
    assert record("a.csv").returncode == 0
    (tmp_path / "a.toml").unlink()
    assert record("a.csv", "never replaced").returncode == 2
    assert (tmp_path / "mine.csv").read_text() == "mine"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "mine.csv"]


def test_a_sidecar_whose_recording_is_gone_may_be_replaced(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text("# Written by rotorwise with a.wav.\n")
    check_ours(tmp_path / "a.csv")
    (tmp_path / "a.wav").write_bytes(b"")
    with pytest.raises(InvalidValueError, match=r"is the sidecar of a\.wav"):
        check_ours(tmp_path / "a.csv")


def test_a_record_without_the_shaft_in_it_says_so() -> None:
    def notes(duration_s: float, rate_hz: float) -> str:
        machine = find_machine("rigid_coupling").preset("linearised")
        return " ".join(_notes(record_machine(machine, speed_rpm=1800.0, duration_s=duration_s, rate_hz=rate_hz)))

    # 30 Hz: 0.4 of the rate must hold it, and 10 turns take a third of a second.
    assert "1X and everything above" in notes(1.0, 74.0)
    assert "1X and everything above" not in notes(1.0, 76.0)
    assert "The record holds 9 turns" in notes(0.3, 1000.0)
    assert "turns" not in notes(0.4, 1000.0)


@pytest.mark.parametrize("missing", ["--speed", "--duration", "--rate"])
def test_speed_duration_and_rate_have_no_default(missing: str, tmp_path: Path) -> None:
    pairs = {"--speed": 3000, "--duration": 0.5, "--rate": 2000, "-o": tmp_path / "a.csv"}
    pairs.pop(missing)
    done = rotorwise("simulate", "amb_rotor", *(word for pair in pairs.items() for word in pair))
    assert done.returncode == 2
    assert f"Missing option '{missing}'" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_an_unstable_machine_is_told_and_writes_nothing(tmp_path: Path) -> None:
    done = rotorwise("simulate", "amb_rotor", "--preset", "as_printed", *SHORT, "-o", tmp_path / "a.csv")
    assert done.returncode == 3
    assert "unstable" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_record_that_just_fits_is_not_refused_for_its_length() -> None:
    with pytest.raises(InvalidValueError, match="up to 3"):
        record_machine(
            find_machine("amb_rotor"), speed_rpm=3000.0, duration_s=MOST_SAMPLES / 4 / 2000 * 1.01, rate_hz=2000.0
        )
