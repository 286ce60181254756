"""The measured recordings with their sidecars: rate, channels, units, speed, and what must be refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from rotorwise.datasets import Metadata, find_recordings, read, read_blocks
from rotorwise.datasets.errors import MissingMetadataError, UnreadableFileError

pytestmark = pytest.mark.measured
SIDECARS = Path(__file__).parents[1] / "measured"

# folder, file pattern, sidecar, rate, (channel, quantity), speed
CASES = [
    (
        "01_adi_limerick_mfs",
        "1200_*.csv",
        "adi_limerick",
        20_000,
        [("X", "voltage"), ("Y", "voltage"), ("Z", "voltage")],
        1200,
    ),
    (
        "01_adi_limerick_mfs",
        "1800_*.csv",
        "adi_limerick",
        20_000,
        [("X", "voltage"), ("Y", "voltage"), ("Z", "voltage")],
        1800,
    ),
    (
        "01_adi_limerick_mfs",
        "2400_*.csv",
        "adi_limerick",
        20_000,
        [("X", "voltage"), ("Y", "voltage"), ("Z", "voltage")],
        2400,
    ),
    ("03_gear0_gearbox_28ch", "*Chan5.mat", "gear0", 25_600, [("Input5(t)", "acceleration")], 2000),
    (
        "05_cwru_bearing",
        "12k_*_118.mat",
        "cwru",
        12_000,
        [(name, "acceleration") for name in ("DE", "FE", "BA")],
        1796,
    ),
    (
        "05_cwru_bearing",
        "12k_*_105.mat",
        "cwru",
        12_000,
        [(name, "acceleration") for name in ("DE", "FE", "BA")],
        1797,
    ),
    (
        "05_cwru_bearing",
        "normal_0_97.mat",
        "cwru",
        48_000,
        [(name, "acceleration") for name in ("DE", "FE")],
        1796,
    ),
    ("06_mfpt_bearing", "*.mat", "mfpt", 48_828, [("bearing.gs", "acceleration")], 1500),
    ("12_sqv_machine_off", "REC3603_ch2.txt", "sqv_machine_off", 25_600, [("ch2", "acceleration")], None),
    ("12_sqv_machine_off", "REC3603_ch3.txt", "sqv_machine_off", 25_600, [("ch3", "tacho")], None),
    ("14_format_samples", "Sample*.uff", "format_samples", 65_536, [("Mic 01", "sound_pressure")], None),
    (
        "14_format_samples",
        "MPS*.uff",
        "format_samples",
        3_200,
        [(name, "acceleration") for name in ("1+Z", "2+Z", "3+Z", "1+Z (2)")],
        None,
    ),
]


def files(measured_folder: Path, folder: str, pattern: str) -> list[Path]:
    found = sorted((measured_folder / folder).rglob(pattern))
    if not found:
        pytest.skip(f"{folder}/{pattern} is not among the measured recordings")
    return found


@pytest.mark.parametrize(("folder", "pattern", "sidecar", "rate", "channels", "speed"), CASES)
def test_rate_channels_units_and_speed(
    measured_folder: Path,
    folder: str,
    pattern: str,
    sidecar: str,
    rate: float,
    channels: list,
    speed: float | None,
) -> None:
    for path in files(measured_folder, folder, pattern):
        recording = read(path, sidecar=SIDECARS / f"{sidecar}.toml")
        assert recording.rate_hz == rate
        assert [(one.name, one.quantity) for one in recording.channels] == channels
        assert recording.condition.speed_rpm == speed
        assert recording.warnings == ()
        assert np.isfinite(recording.signals).all()
        part = read(path, sidecar=SIDECARS / f"{sidecar}.toml", start=1000, stop=1500)
        np.testing.assert_array_equal(part.signals, recording.signals[:, 1000:1500])


def test_known_facts_of_the_signals(measured_folder: Path) -> None:
    """Lengths, loads and levels that the sources state."""
    (path,) = files(measured_folder, "06_mfpt_bearing", "InnerRaceFault_vload_7.mat")
    recording = read(path)
    assert (recording.samples, recording.condition.load, recording.condition.load_unit) == (
        146_484,
        300,
        "lb",
    )
    (path,) = files(measured_folder, "12_sqv_machine_off", "REC3603_ch2.txt")
    levels_g = [part.std() / 9.80665 for part in np.array_split(read(path).signals[0], 6)]
    assert 0.0048 <= min(levels_g) <= max(levels_g) <= 0.0050  # sensor noise, constant: the machine is off
    (path,) = files(measured_folder, "03_gear0_gearbox_28ch", "*Chan5.mat")
    recording = read(path)
    spectrum = np.abs(np.fft.rfft(recording.signals[0]))
    frequency_hz = np.fft.rfftfreq(recording.samples, 1 / recording.rate_hz)
    near = (frequency_hz > 700) & (frequency_hz < 830)
    assert frequency_hz[near][np.argmax(spectrum[near])] == pytest.approx(766.58, abs=0.1)  # 23 teeth at 33.33 Hz
    path = files(measured_folder, "01_adi_limerick_mfs", "1800_GoB_GS_VHIL_WA_00lb*.csv")[0]
    recording = read(path)
    amplitude = 2 * np.abs(np.fft.rfft(recording.signals[0]))[60] / recording.samples
    assert amplitude == pytest.approx(13.35e-3, rel=0.02)  # 1X at 30 Hz, df 0.5 Hz


def test_without_documented_rate_nothing_is_guessed(measured_folder: Path) -> None:
    for path in files(measured_folder, "08_gfs_gearbox_broken_tooth", "*.csv.gz"):
        with pytest.raises(MissingMetadataError, match="--rate"):
            read(path, sidecar=SIDECARS / "gfs_gearbox.toml")
        recording = read(path, sidecar=SIDECARS / "gfs_gearbox.toml", metadata=Metadata(rate_hz=12_800))
        assert [one.name for one in recording.channels] == ["a1", "a2", "a3", "a4"]
        assert {one.quantity for one in recording.channels} == {None}
        assert recording.label == ("healthy" if path.name.startswith("h") else "broken tooth")
        assert recording.condition.load == float(path.name[5:].split(".")[0])
    with pytest.raises(MissingMetadataError, match="--rate"):
        read(files(measured_folder, "05_cwru_bearing", "normal_0_97.mat")[0])


def test_tables_of_results_are_refused(measured_folder: Path) -> None:
    for folder, pattern, word in (
        ("02_mafaulda_order_table", "data.csv", "words"),
        ("09_rk4_rotor_kit", "rk4_1x_vectors.csv", "words"),
        ("09_rk4_rotor_kit", "rk4_runup_1x.csv", "run-up"),
    ):
        with pytest.raises(UnreadableFileError, match=word):
            read(files(measured_folder, folder, pattern)[0], metadata=Metadata(rate_hz=1000))


def test_ten_times_the_rate_is_told(measured_folder: Path) -> None:
    path = files(measured_folder, "03_gear0_gearbox_28ch", "*Chan5.mat")[0]
    recording = read(path, metadata=Metadata(rate_hz=256_000))
    assert any("contradicts the file's 25600 Hz" in text for text in recording.warnings)


def test_blocks_equal_the_whole(measured_folder: Path) -> None:
    for folder, pattern in (
        ("01_adi_limerick_mfs", "1200_*.csv"),
        ("14_format_samples", "MPS*.uff"),
        ("06_mfpt_bearing", "*.mat"),
    ):
        path = files(measured_folder, folder, pattern)[0]
        parts = [block.signals for block in read_blocks(path, block_samples=9_999)]
        np.testing.assert_array_equal(np.concatenate(parts, axis=1), read(path).signals)


def test_every_waveform_of_the_folder_is_found(measured_folder: Path) -> None:
    found, _ = find_recordings([measured_folder], recursive=True)
    assert {path.suffix for path in found} == {".csv", ".gz", ".mat", ".txt", ".uff"}
    assert not [path for path in found if path.name == "CARD.md"]
