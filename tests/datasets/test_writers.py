"""Written recordings come back through the readers: theory is identity, for every format."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rotorwise.datasets import read, write
from rotorwise.datasets.errors import InvalidValueError
from rotorwise.datasets.readers import content_blocks, read_content
from rotorwise.datasets.recording import (
    Channel,
    GearPair,
    MountedBearing,
    Nameplate,
    OperatingCondition,
    Recording,
)
from rotorwise.datasets.sidecar import read_sidecar
from rotorwise.datasets.write import destination, write_recording
from rotorwise.datasets.writers import all_writers, find_writer
from rotorwise.simulators.rotor_dynamics.rolling_bearing import BearingGeometry, find_bearing

FORMATS = [writer.NAME for writer in all_writers()]
NOTES = {"provenance": '{"command": "rotorwise simulate \\"x\\"", "machine": "[parameters]\\nrate_hz = 3.0\\n"}'}


def recording(*, dtype: type = np.float64, rate_hz: float = 12_800.0, samples: int = 700) -> Recording:
    rng = np.random.default_rng(1)
    signals = (rng.normal(size=(4, samples)) * [[3.7e2], [1e-6], [1e-3], [0]]).astype(dtype)
    signals[3] = np.arange(samples) % 100 < 30
    channels = (
        Channel("drive end, x (1)", "acceleration", "bearing 1", "horizontal"),
        Channel("time", "displacement", "Gehäuse", "vertical"),
        Channel("9 'o clock\"", "velocity", None, "axial"),
        Channel("tacho", "tacho"),
    )
    bearings = (
        MountedBearing(find_bearing("6205"), "bearing 1"),
        MountedBearing(BearingGeometry(9, 7.938e-3, 39.04e-3, 0.3), "bearing 2", 0.25),
    )
    plate = Nameplate(
        name="pump \x7f\t3",
        bearings=bearings,
        gears=(GearPair(23, 81), GearPair(12, None, 0.5)),
        line_frequency_hz=50.0,
        severity_table="iso20816-3-group2",
        mounting="rigid",
        power_kw=7.5,
        magnetic_bearing_clearance_m=1.25e-4,
    )
    condition = OperatingCondition(1480.25, 12.5, "N.m", 61.0)
    label = "unbalance at disc (moment_kg_m 0.001 kg.m); rub"
    return Recording(signals, rate_hz, channels, condition, plate, label, pulses_per_revolution=2.0)


def same(first: Recording, second: Recording) -> None:
    assert second.signals.dtype == first.signals.dtype
    np.testing.assert_array_equal(second.signals, first.signals)
    assert second.rate_hz == first.rate_hz
    for one, two in zip(first.channels, second.channels, strict=True):
        names = ("name", "quantity", "location", "direction")
        assert [getattr(two, name) for name in names] == [getattr(one, name) for name in names]
    assert (second.condition, second.label) == (first.condition, first.label)
    assert second.pulses_per_revolution == first.pulses_per_revolution
    assert second.nameplate.gears == first.nameplate.gears
    assert replace(second.nameplate, bearings=()) == replace(first.nameplate, bearings=())
    for one, two in zip(first.nameplate.bearings, second.nameplate.bearings, strict=True):
        assert (two.location, two.shaft_ratio, two.geometry.balls) == (
            one.location,
            one.shaft_ratio,
            one.geometry.balls,
        )
        orders = [bearing.geometry.defect_orders() for bearing in (one, two)]
        assert orders[1].ball_spin == pytest.approx(orders[0].ball_spin, rel=1e-12)
        assert orders[1].outer_race == pytest.approx(orders[0].outer_race, rel=1e-12)
    assert second.warnings == ()


# ---- identity ----


@pytest.mark.parametrize("file_format", FORMATS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_reading_gives_the_recording_back(file_format: str, dtype: type, tmp_path: Path) -> None:
    before = recording(dtype=dtype)
    suffix = find_writer(Path("x"), file_format=file_format).SUFFIXES[0]
    made = write_recording(before, tmp_path / f"record{suffix}", notes=NOTES, remarks="two\n\nlines")
    after = read(made.path)
    if file_format == "csv":
        # Text has no precision of its own: nine digits name a single, but are read as a double.
        after = replace(after, signals=after.signals.astype(dtype))
    same(before, after)
    assert {path.name for path in tmp_path.iterdir()} == {made.path.name, "record.toml"}


@pytest.mark.parametrize("file_format", FORMATS)
@pytest.mark.parametrize("rate_hz", [25.6, 4096.0, 51_200.0, 44_100.123456789])
def test_any_rate_comes_back_exactly(file_format: str, rate_hz: float, tmp_path: Path) -> None:
    made = write_recording(recording(rate_hz=rate_hz), tmp_path / "record.dat", file_format=file_format)
    assert read(made.path).rate_hz == rate_hz


@pytest.mark.parametrize("file_format", [one for one in FORMATS if one != "wav"])
def test_without_the_sidecar_rate_speed_and_label_are_still_there(file_format: str, tmp_path: Path) -> None:
    made = write_recording(recording(), tmp_path / "record.dat", file_format=file_format, notes=NOTES)
    made.sidecar.unlink()
    content = read_content(made.path)
    assert content.rate_hz == 12_800.0
    assert content.speed_rpm == 1480.25
    assert content.label == recording().label
    assert len(content.channel_names) == 4
    # MATLAB 5 has no place for units.
    assert content.units[0] == (None if file_format == "mat" else "m/s2")
    if file_format != "csv":
        assert content.notes["provenance"].startswith('{"command"')


@pytest.mark.parametrize("file_format", FORMATS)
def test_blocks_are_pieces_of_the_whole(file_format: str, tmp_path: Path) -> None:
    made = write_recording(recording(), tmp_path / "record.dat", file_format=file_format, notes=NOTES)
    pieces = [block.signals for block in content_blocks(made.path, block_samples=300)]
    np.testing.assert_array_equal(np.concatenate(pieces, axis=1), read_content(made.path).signals)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    name=st.text(st.characters(codec="utf-8", exclude_categories=["Cs"]), min_size=1, max_size=30),
    label=st.text(st.characters(codec="utf-8", exclude_categories=["Cs"]), min_size=1, max_size=60),
    value=st.floats(1e-3, 1e6),
)
def test_any_text_survives_in_the_sidecar(name: str, label: str, value: float, tmp_path: Path) -> None:
    before = Recording(
        np.zeros((1, 4)), 100.0, (Channel(name, "velocity", label),), OperatingCondition(load=value), label=label
    )
    made = write_recording(before, tmp_path / "record.npz", force=True)
    found = read_sidecar(made.sidecar)
    assert (found.channels[0].name, found.channels[0].location, found.label) == (name, label, label)
    assert found.load == value


def test_missing_samples_stay_missing(tmp_path: Path) -> None:
    before = recording()
    before.signals[0, 5:9] = np.nan
    for file_format in FORMATS:
        made = write_recording(before, tmp_path / f"{file_format}.dat", file_format=file_format)
        np.testing.assert_array_equal(read(made.path).signals[0, 4:10], before.signals[0, 4:10])


# ---- what is refused ----


def test_formats_are_found_by_name_and_by_suffix() -> None:
    assert {"csv", "wav", "parquet", "hdf5", "mat", "npz"} <= set(FORMATS)
    assert find_writer(Path("a.H5")).NAME == "hdf5"
    assert find_writer(Path("a.csv"), file_format="WAV").NAME == "wav"
    with pytest.raises(InvalidValueError, match=r"'xls' cannot be written; allowed: csv \(\.csv\)"):
        find_writer(Path("a.csv"), file_format="xls")
    with pytest.raises(InvalidValueError, match="says no format"):
        find_writer(Path("a.dat"))


def test_nothing_is_overwritten_without_force(tmp_path: Path) -> None:
    made = write_recording(recording(), tmp_path / "a.csv")
    before = made.path.read_bytes(), made.sidecar.read_bytes()
    with pytest.raises(InvalidValueError, match="exists already"):
        write_recording(recording(samples=9), tmp_path / "a.csv")
    # Another format of the same name would take the sidecar.
    with pytest.raises(InvalidValueError, match=r"a\.toml exists already"):
        write_recording(recording(samples=9), tmp_path / "a.wav")
    assert (made.path.read_bytes(), made.sidecar.read_bytes()) == before
    write_recording(recording(samples=9), tmp_path / "a.csv", force=True)
    assert read(made.path).samples == 9


def test_a_file_of_somebody_else_s_in_the_sidecar_s_place_is_never_replaced(tmp_path: Path) -> None:
    (tmp_path / "rig.toml").write_text("format = 1\n")
    with pytest.raises(InvalidValueError, match="never replaced"):
        write_recording(recording(), tmp_path / "rig.csv", force=True)
    assert [path.name for path in tmp_path.iterdir()] == ["rig.toml"]


@pytest.mark.parametrize(("name", "words"), [("nowhere/a.csv", "does not exist"), ("a.toml", "own sidecar")])
def test_impossible_places_are_refused(name: str, words: str, tmp_path: Path) -> None:
    with pytest.raises(InvalidValueError, match=words):
        destination(tmp_path / name, file_format="csv")
    (tmp_path / "b.csv").mkdir()
    with pytest.raises(InvalidValueError, match="is a folder"):
        destination(tmp_path / "b.csv", force=True)
    assert [path.name for path in tmp_path.iterdir()] == ["b.csv"]


def test_a_writer_that_fails_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(recording: Recording, path: Path, *, notes: object) -> None:
        path.write_bytes(b"half")
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(find_writer(Path("a.csv")), "write", full)
    with pytest.raises(InvalidValueError, match="No space left"):
        write_recording(recording(), tmp_path / "a.csv")
    assert list(tmp_path.iterdir()) == []


def test_wav_refuses_a_rate_that_its_header_cannot_hold(tmp_path: Path) -> None:
    with pytest.raises(InvalidValueError, match="1 Hz or more"):
        write_recording(recording(rate_hz=0.01), tmp_path / "a.wav")
    assert list(tmp_path.iterdir()) == []


def test_plain_csv_and_npz_need_no_sidecar(tmp_path: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for made in (
            write.write_csv(recording(), tmp_path / "a.csv"),
            write.write_npz(recording(), tmp_path / "b"),
        ):
            assert read(made).rate_hz == 12_800.0
    assert {path.name for path in tmp_path.iterdir()} == {"a.csv", "b.npz"}
