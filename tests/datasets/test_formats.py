"""What each format says beside its samples, on files made here in the layout of well-known data sets."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import soundfile
from nptdms import ChannelObject, RootObject, TdmsWriter
from rotorwise.datasets.errors import UnreadableFileError
from rotorwise.datasets.readers import read_content
from scipy.io import savemat

X, Y = np.random.default_rng(11).standard_normal((2, 600))


def test_cwru_layout(tmp_path: Path) -> None:
    path = tmp_path / "12k_Drive_End_B007_0_118.mat"
    savemat(path, {"X118_DE_time": X[:, None], "X118_FE_time": Y[:, None], "X118RPM": 1796})
    content = read_content(path)
    np.testing.assert_array_equal(content.signals, [X, Y])
    assert (content.rate_hz, content.speed_rpm, content.units) == (None, 1796, ("g", "g"))


@pytest.mark.parametrize(("name", "chosen"), [("normal_2_99", "X099"), ("normal_1_98", "X098"), ("renamed", "X098")])
def test_cwru_file_with_two_records(tmp_path: Path, name: str, chosen: str) -> None:
    path = tmp_path / f"{name}.mat"
    savemat(path, {"X098_DE_time": X, "X099_DE_time": Y, "X098_FE_time": X, "X099_FE_time": Y, "X099RPM": 1750.0})
    content = read_content(path)
    assert content.channel_names == (f"{chosen}_DE_time", f"{chosen}_FE_time")
    np.testing.assert_array_equal(content.signals[0], X if chosen == "X098" else Y)
    assert content.speed_rpm == (1750 if chosen == "X099" else None)
    assert f"{chosen} is read" in content.warnings[0]


def test_mfpt_layout(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    savemat(path, {"bearing": {"sr": 48828, "gs": X, "load": 50, "rate": 25}, "BPFO": 81.125})
    content = read_content(path)
    assert (content.rate_hz, content.speed_rpm, content.load, content.load_unit) == (48828, 1500, 50, "lb")
    assert content.units == ("g",)
    assert content.notes["BPFO"] == "81.125"


@pytest.mark.parametrize(("code", "unit"), [(12, "m/s2"), (103, None)])
def test_nva_header_layout(tmp_path: Path, code: int, unit: str | None) -> None:
    path = tmp_path / "a.mat"
    savemat(
        path,
        {
            "Data1": X,
            "Count": 1,
            "Head_1": {"SampFreq": 25600.0, "YUnit": code, "Name": "Input5(t)", "Sensity": 0.051, "Load": 0},
        },
    )
    content = read_content(path)
    assert (content.rate_hz, content.units, content.channel_names) == (25600, (unit,), ("Input5(t)",))
    assert content.load is None


@pytest.mark.parametrize(
    "name", ["fs", "Fs", "sr", "SampFreq", "rate_hz", "sampling_rate", "SampleRate", "sample_rate", "rate"]
)
def test_names_of_the_rate_in_matlab_files(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.mat"
    savemat(path, {"x": X, name: 12800, "RPM": 1480, "label": "healthy"})
    content = read_content(path)
    assert (content.rate_hz, content.speed_rpm, content.label, content.channel_names) == (
        12800,
        1480,
        "healthy",
        ("x",),
    )


def test_matlab_time_vector_matrix_and_odd_lengths(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    savemat(
        path,
        {
            "t": np.arange(600) / 2560,
            "acc": np.stack([X, Y], axis=1),
            "window": np.ones(64),
            "map": np.ones((5, 6, 7)),
        },
    )
    content = read_content(path)
    np.testing.assert_array_equal(content.signals, [X, Y])
    assert content.rate_hz == 2560
    assert "window (64 samples)" in content.warnings[0]
    savemat(path, {"t": np.arange(600) / 2560, "x": X, "fs": 25600})
    content = read_content(path)
    assert content.rate_hz == 25600
    assert "25600 Hz" in content.warnings[0]
    assert "2560 Hz" in content.warnings[0]


def test_matlab_without_signals(tmp_path: Path) -> None:
    path = tmp_path / "a.mat"
    savemat(path, {"fs": 25600, "label": "healthy"})
    with pytest.raises(UnreadableFileError, match="no numeric samples"):
        read_content(path)


def test_hdf5_matrix_with_names_units_and_step(tmp_path: Path) -> None:
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        data = file.create_dataset("run/vibration", data=np.stack([X, Y]))
        data.attrs["dt"] = 1 / 2560
        data.attrs["channel_names"] = ["DE", "FE"]
        data.attrs["units"] = ["g", "mm/s"]
        file["run"].attrs["speed_rpm"] = 1480.0
    content = read_content(path)
    assert (content.channel_names, content.units) == (("DE", "FE"), ("g", "mm/s"))
    assert (content.rate_hz, content.speed_rpm) == (2560, 1480)


def test_tdms_channels_of_another_rate_are_left_out_by_name(tmp_path: Path) -> None:
    path = tmp_path / "a.tdms"
    slow = ChannelObject("g", "temperature", np.ones(6), {"wf_increment": 1.0})
    fast = [
        ChannelObject("g", "DE", X, {"wf_increment": 1 / 25600, "NI_UnitDescription": "g"}),
        ChannelObject("g", "tacho", Y, {"wf_increment": 1 / 25600, "unit_string": "V"}),
    ]
    with TdmsWriter(path) as writer:
        writer.write_segment([RootObject({"rpm": 1480.0}), slow, *fast])
    content = read_content(path)
    assert (content.channel_names, content.units) == (("DE", "tacho"), ("g", "V"))
    assert content.quantity_hints == (None, "tacho")
    assert (content.rate_hz, content.speed_rpm) == (pytest.approx(25600), 1480)
    assert "temperature (6 samples)" in content.warnings[0]


def test_parquet_metadata_stamps_and_lists(tmp_path: Path) -> None:
    path = tmp_path / "a.parquet"
    stamps = np.datetime64("2024-01-01T00:00:00", "ns") + (np.arange(600) * 390_625).astype("timedelta64[ns]")
    fields = [pa.field("when", pa.timestamp("ns")), pa.field("DE", pa.float32(), metadata={"unit": "g"})]
    pq.write_table(pa.table([stamps, X.astype(np.float32)], schema=pa.schema(fields)), path)
    content = read_content(path)
    assert (content.rate_hz, content.units, content.signals.dtype) == (2560, ("g",), np.float32)
    table = pa.table({"x": X}).replace_schema_metadata({"rate_hz": "12800", "speed_rpm": "1480", "label": "healthy"})
    pq.write_table(table, path)
    content = read_content(path)
    assert (content.rate_hz, content.speed_rpm, content.label) == (12800, 1480, "healthy")
    pq.write_table(pa.table({"signal": [X.tolist(), Y.tolist()], "label": ["a", "b"]}), path)
    with pytest.raises(UnreadableFileError, match="text or lists"):
        read_content(path)


def test_numpy_shapes_types_and_pickles(tmp_path: Path) -> None:
    path = tmp_path / "a.npy"
    for array in (np.stack([X, Y]), np.stack([X, Y], axis=1)):
        np.save(path, array)
        np.testing.assert_array_equal(read_content(path).signals, [X, Y])
    np.save(path, (X * 1000).astype(np.int16))
    assert read_content(path).signals.dtype == np.float64
    np.save(path, X.astype(">f4"))
    np.testing.assert_array_equal(read_content(path).signals[0], X.astype(np.float32))
    for bad in (np.array([{"a": 1}], dtype=object), np.ones((4, 4, 4)), X + 1j * Y):
        np.save(path, bad, allow_pickle=True)
        with pytest.raises(UnreadableFileError, match=r"a\.npy"):
            read_content(path)


@pytest.mark.parametrize("subtype", ["PCM_16", "PCM_24", "PCM_32", "FLOAT", "DOUBLE"])
def test_sound_full_scale_is_one_and_has_no_unit(tmp_path: Path, subtype: str) -> None:
    path = tmp_path / "a.wav"
    data = np.round(X / 8 * 2**15) / 2**15
    soundfile.write(path, data, 44100, subtype=subtype)
    content = read_content(path)
    np.testing.assert_array_equal(content.signals[0], data)
    assert (content.units, content.rate_hz) == ((None,), 44100)


def test_slices_do_not_load_the_file(tmp_path: Path) -> None:
    """Of 16 MB only the samples asked for may be held, where the format can be read in part."""
    import tracemalloc

    data = np.random.default_rng(0).standard_normal(2_000_000)
    np.save(tmp_path / "a.npy", data)
    soundfile.write(tmp_path / "a.wav", data, 48000, subtype="DOUBLE")
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.create_dataset("x", data=data, chunks=(10_000,))
    with TdmsWriter(tmp_path / "a.tdms") as writer:
        for part in np.array_split(data, 50):
            writer.write_segment([ChannelObject("g", "x", part, {"wf_increment": 1e-4})])
    pq.write_table(pa.table({"x": data}), tmp_path / "a.parquet", row_group_size=20_000)
    for path in sorted(tmp_path.iterdir()):
        read_content(path, start=0, stop=1)  # imports count once
        tracemalloc.start()
        content = read_content(path, start=1_000_000, stop=1_001_000)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        np.testing.assert_array_equal(content.signals[0], data[1_000_000:1_001_000])
        assert peak < 2e6, f"{path.name}: {peak / 1e6:.1f} MB"
