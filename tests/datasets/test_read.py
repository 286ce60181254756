"""Files to recordings in SI: units, sensitivities, rates, channels, blocks, folders, writing back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from rotorwise import datasets
from rotorwise.datasets import Metadata, Recording, find_recordings, read, read_blocks
from rotorwise.datasets.errors import InvalidValueError, MissingMetadataError, UnreadableFileError
from rotorwise.datasets.metadata import ChannelMetadata
from rotorwise.datasets.recording import Channel, OperatingCondition
from rotorwise.datasets.write import write_csv, write_npz

G = 9.80665
DATA = np.random.default_rng(3).standard_normal((3, 500))


@pytest.fixture
def volts(tmp_path: Path) -> Path:
    """Three channels without rate; two of them in volts, the third unknown."""
    path = tmp_path / "volts.csv"
    path.write_text("a (V),b (mV),c\n" + "\n".join(",".join(map(repr, row)) for row in DATA.T.tolist()) + "\n")
    return path


def test_missing_rate_says_how_to_give_it(volts: Path) -> None:
    with pytest.raises(MissingMetadataError, match=r"--rate.*rate_hz"):
        read(volts)
    with pytest.raises(MissingMetadataError, match="--rate"):
        next(read_blocks(volts, block_samples=100))


def test_units_to_si(volts: Path) -> None:
    recording = read(volts, metadata=Metadata(rate_hz=1000, units=("", "g", "mm/s")))
    np.testing.assert_allclose(recording.signals, DATA * [[1.0], [G], [1e-3]], rtol=1e-15)
    assert [one.quantity for one in recording.channels] == ["voltage", "acceleration", "velocity"]
    assert [one.stored_unit for one in recording.channels] == ["V", "g", "mm/s"]
    assert any("contradicts the file's mV" in text for text in recording.warnings)


def test_sensitivity_turns_volts_into_its_quantity(volts: Path) -> None:
    # 100 mV/g: 1 V is 10 g; b is in mV: 1 mV is 0.01 g; c in mm/s has no use for it.
    recording = read(volts, metadata=Metadata(rate_hz=1000, units=("", "", "mm/s"), sensitivities=("100 mV/g",)))
    np.testing.assert_allclose(recording.signals, DATA * [[10 * G], [0.01 * G], [1e-3]], rtol=1e-12)
    assert recording.channels[1].quantity == "acceleration"
    assert any("not in volts" in text for text in recording.warnings)


def test_sensitivity_without_unit_is_a_question_not_a_guess(volts: Path) -> None:
    with pytest.raises(MissingMetadataError, match="--unit V"):
        read(volts, metadata=Metadata(rate_hz=1000, sensitivities=("100 mV/g",)))


def test_unknown_unit_stays_unknown(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    np.savez(path, signals=DATA, fs=1000.0, units=np.array(["EU", "g", ""]))
    recording = read(path)
    assert [one.quantity for one in recording.channels] == [None, "acceleration", None]
    assert any("'EU' is not known" in text for text in recording.warnings)
    with pytest.raises(InvalidValueError, match="furlong"):
        read(path, metadata=Metadata(units=("furlong",)))


def test_given_rate_wins_and_a_contradiction_is_told(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    np.savez(path, signals=DATA, fs=25600.0)
    assert not read(path, metadata=Metadata(rate_hz=25601)).warnings
    recording = read(path, metadata=Metadata(rate_hz=256000))
    assert recording.rate_hz == 256000
    assert any("256000 Hz contradicts the file's 25600 Hz" in text for text in recording.warnings)
    assert any("unusual" in text for text in read(path, metadata=Metadata(rate_hz=3.0)).warnings)


def test_channels_by_name_number_and_order(volts: Path) -> None:
    metadata = Metadata(
        rate_hz=1000,
        channel_names=("DE", "", "pulse"),
        channels=(
            ChannelMetadata(match="b*", location="FE", direction="axial"),
            ChannelMetadata(number=1, unit="mV"),
        ),
        skip=("2",),
        tacho="pulse",
        pulses_per_revolution=2,
    )
    recording = read(volts, metadata=metadata)
    assert [(one.name, one.quantity) for one in recording.channels] == [("DE", "voltage"), ("pulse", "tacho")]
    np.testing.assert_allclose(recording.signals, DATA[[0, 2]] * [[1e-3], [1.0]], rtol=1e-15)
    assert recording.pulses_per_revolution == 2
    both = read(volts, metadata=Metadata(rate_hz=1000, channels=metadata.channels))
    assert (both.channels[1].location, both.channels[1].direction) == ("FE", "axial")


def test_names_with_brackets_and_channels_that_are_not_there(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    np.savez(path, signals=DATA, fs=1000.0)
    rules = (ChannelMetadata(match="signals[1]", unit="g"), ChannelMetadata(number=4, unit="V"))
    recording = read(path, metadata=Metadata(channels=rules))
    assert [one.quantity for one in recording.channels] == [None, "acceleration", None]
    assert recording.warnings[0].startswith("Metadata for channel 4 is not used: the file has 3")


@pytest.mark.parametrize(("tacho", "warned"), [("Key [V]", False), ("Acc [g]", True), ("2", False)])
def test_tacho_by_its_title_in_the_file_and_vibration_as_tacho(tmp_path: Path, tacho: str, warned: bool) -> None:
    path = tmp_path / "a.csv"
    path.write_text("Time [s],Acc [g],Key [V]\n" + "".join(f"{k / 100},{k % 7},{k % 5}\n" for k in range(50)))
    recording = read(path, metadata=Metadata(tacho=tacho))
    assert [one.quantity for one in recording.channels] == (
        ["tacho", "voltage"] if warned else ["acceleration", "tacho"]
    )
    assert any("in g, as vibration is" in one for one in recording.warnings) is warned


@pytest.mark.parametrize(
    ("metadata", "word"),
    [
        (Metadata(rate_hz=1, units=("g", "g")), "2 units for 3 channels"),
        (Metadata(rate_hz=1, channel_names=("x",)), "1 channel names for 3"),
        (Metadata(rate_hz=1, skip=("d",)), "'d' is no channel"),
        (Metadata(rate_hz=1, tacho="4"), "'4' is no channel"),
        (Metadata(rate_hz=1, skip=("1", "2", "3")), "every channel"),
        (Metadata(rate_hz=1, channel_names=("x", "x", "y")), "twice"),
    ],
)
def test_metadata_that_does_not_fit(volts: Path, metadata: Metadata, word: str) -> None:
    with pytest.raises(InvalidValueError, match=word):
        read(volts, metadata=metadata)


def test_tacho_by_its_name(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    np.savez(
        path,
        signals=DATA,
        fs=1000.0,
        channel_names=np.array(["DE", "Keyphasor", "tacho rpm"]),
        units=np.array(["g", "mV", "rpm"]),
    )
    recording = read(path)
    assert [one.quantity for one in recording.channels] == ["acceleration", "tacho", "rotational_speed"]
    np.testing.assert_allclose(recording.signals[1:], DATA[1:] * [[1e-3], [2 * np.pi / 60]], rtol=1e-12)


@pytest.mark.parametrize(
    ("size", "overlap"), [(100, 0), (100, 30), (128, 127), (500, 10), (1000, 10), (499, 1), (250, 0)]
)
def test_blocks_with_overlap_cover_everything_once(volts: Path, size: int, overlap: int) -> None:
    whole = read(volts, metadata=Metadata(rate_hz=1000))
    blocks = list(read_blocks(volts, metadata=Metadata(rate_hz=1000), block_samples=size, overlap=overlap))
    starts = [block.provenance.start_sample for block in blocks]
    assert starts == list(range(0, starts[-1] + 1, size - overlap))
    for block, start in zip(blocks, starts, strict=True):
        np.testing.assert_array_equal(block.signals, whole.signals[:, start : start + size])
    assert all(block.samples == size for block in blocks[:-1])
    assert starts[-1] + blocks[-1].samples == 500
    assert blocks[-1].samples > (overlap if len(blocks) > 1 else 0)


def test_block_sizes_that_make_no_sense(volts: Path) -> None:
    for size, overlap in ((0, 0), (10, 10), (10, -1)):
        with pytest.raises(InvalidValueError, match="overlap"):
            next(read_blocks(volts, block_samples=size, overlap=overlap))
    with pytest.raises(InvalidValueError, match="start"):
        read(volts, start=10, stop=5)


def test_blocks_of_a_large_text_need_little_memory(tmp_path: Path) -> None:
    import tracemalloc

    path = tmp_path / "long.csv"
    line = "0.12345678,0.12345678,0.12345678\n"
    path.write_text("# rate_hz: 1000\n" + line * 300_000)
    tracemalloc.start()
    total = sum(block.samples for block in read_blocks(path, block_samples=10_000))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert total == 300_000
    assert peak < 8e6  # the file has 10 MB, its numbers 7.2 MB


def test_sidecar_beside_the_file_counts_below_the_argument(volts: Path) -> None:
    (volts.parent / "recording.toml").write_text(
        '[recording]\nrate_hz = 1000\nspeed_rpm = 1480\n[[channel]]\nname = "DE"\n'
    )
    recording = read(volts)
    assert (recording.rate_hz, recording.condition.speed_rpm, recording.channels[0].name) == (
        1000,
        1480,
        "DE",
    )
    assert read(volts, metadata=Metadata(rate_hz=2000)).rate_hz == 2000
    assert read(volts, metadata=Metadata(rate_hz=2000)).condition.speed_rpm == 1480


def test_find_recordings(volts: Path, tmp_path: Path) -> None:
    for name in ("recording.toml", "CARD.md", "report.html", ".hidden.csv"):
        (tmp_path / name).write_text("1,2\n3,4\n")
    (tmp_path / "photo.dat").write_bytes(bytes(range(256)))
    (tmp_path / "more").mkdir()
    (tmp_path / "more" / "x.csv").write_text("1.0,2.0\n3.0,5.0\n")
    assert find_recordings([tmp_path]) == ([volts], [tmp_path / "photo.dat"])
    assert find_recordings([tmp_path], recursive=True)[0] == [volts, tmp_path / "more" / "x.csv"]
    assert find_recordings([tmp_path / "photo.dat", str(volts)]) == ([tmp_path / "photo.dat", volts], [])
    with pytest.raises(UnreadableFileError, match="no such file"):
        find_recordings([tmp_path / "none"])


def test_an_empty_file_in_a_folder_is_told_not_passed_over(tmp_path: Path) -> None:
    (tmp_path / "run.csv").touch()
    (tmp_path / "photo.xyz").touch()
    assert find_recordings([tmp_path]) == ([tmp_path / "run.csv"], [tmp_path / "photo.xyz"])


@pytest.mark.parametrize("name", ["run.wav", "run.MAT", "run.tdms", "run.uff", "run.h5", "run.npz", "run.parquet"])
def test_a_damaged_recording_in_a_folder_is_not_passed_over(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(np.random.default_rng(5).bytes(3000))
    found, left_out = find_recordings([tmp_path])
    assert (found, left_out) == ([tmp_path / name], [])
    with pytest.raises(UnreadableFileError, match="its suffix says so: damaged"):
        read(found[0])


def recording(dtype: type = np.float64) -> Recording:
    channels = (Channel("drive end", "acceleration"), Channel("odd, name (g)"), Channel("Keyphasor", "tacho"))
    return Recording(DATA.astype(dtype), 25600.5, channels, OperatingCondition(speed_rpm=1480.25), label="healthy; new")


@pytest.mark.parametrize("write", [write_csv, write_npz])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_written_files_read_back_exactly(tmp_path: Path, write, dtype: type) -> None:
    before = recording(dtype)
    path = write(before, tmp_path / ("a.csv" if write is write_csv else "a.npz"))
    after = read(path)
    np.testing.assert_array_equal(after.signals.astype(dtype), before.signals)
    assert after.rate_hz == before.rate_hz
    assert after.condition.speed_rpm == 1480.25
    assert after.label == before.label
    assert [one.quantity for one in after.channels] == ["acceleration", None, "tacho"]
    assert not after.warnings


@pytest.mark.parametrize("write", [write_csv, write_npz])
def test_an_existing_file_is_kept_unless_forced(tmp_path: Path, write) -> None:
    path = write(recording(), tmp_path / "a.npz")
    before = path.read_bytes()
    with pytest.raises(InvalidValueError, match="--force"):
        write(recording(np.float32), path)
    assert path.read_bytes() == before
    write(recording(np.float32), path, force=True)
    assert path.read_bytes() != before
    with pytest.raises(InvalidValueError, match="does not exist"):
        write(recording(), tmp_path / "none" / "a.npz")


def test_public_names() -> None:
    assert sorted(datasets.__all__) == datasets.__dir__()
    for name in datasets.__all__:
        assert getattr(datasets, name).__name__ == name
    with pytest.raises(AttributeError, match="nothing"):
        datasets.nothing  # noqa: B018
