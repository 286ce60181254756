"""Sample files of every format, each made with the format's own library."""

from __future__ import annotations

import gc
import gzip
import struct
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.request import Request, urlopen

import numpy as np
import pytest

RATE_HZ = 25600.0
SAMPLES = 4096


def signals() -> np.ndarray:
    """Two channels of sine and noise, shape (2, SAMPLES), below 1 so that WAV can hold them."""
    rng = np.random.default_rng(20816)
    time = np.arange(SAMPLES) / RATE_HZ
    rows = [0.4 * np.sin(2 * np.pi * 50 * time), 0.1 * np.cos(2 * np.pi * 120 * time)]
    return np.stack([row + 0.05 * rng.standard_normal(SAMPLES) for row in rows]).astype(np.float32)


def make_csv(folder: Path, data: np.ndarray) -> Path:
    path = folder / "sample.csv"
    time = np.arange(data.shape[1]) / RATE_HZ
    rows = np.column_stack([time, *data])
    np.savetxt(path, rows, delimiter=",", fmt="%.10g", header="time (s),ax (m/s2),ay (m/s2)", comments="")
    return path


def make_matlab5(folder: Path, data: np.ndarray) -> Path:
    from scipy.io import savemat

    path = folder / "sample.mat"
    savemat(path, {"ax": data[0], "ay": data[1], "fs": RATE_HZ}, do_compression=True)
    return path


def make_matlab73(folder: Path, data: np.ndarray) -> Path:
    import h5py

    path = folder / "sample.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in (("ax", data[0]), ("ay", data[1]), ("fs", np.array([RATE_HZ]))):
            # MATLAB stores a column vector as one row.
            file.create_dataset(name, data=values[None, :]).attrs["MATLAB_class"] = np.bytes_("double")
        label = file.create_dataset("label", data=np.array([[ord(c)] for c in "healthy"], dtype=np.uint16))
        label.attrs["MATLAB_class"] = np.bytes_("char")
    text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: Mon Jan  1 00:00:00 2024 HDF5 schema 1.00 ."
    head = text.ljust(124, b" ") + struct.pack("<H", 0x0200) + b"IM"
    with path.open("r+b") as handle:
        handle.write(head)
    return path


def make_hdf5(folder: Path, data: np.ndarray) -> Path:
    import h5py

    path = folder / "sample.h5"
    with h5py.File(path, "w") as file:
        file.attrs["sample_rate"] = RATE_HZ
        group = file.create_group("vibration")
        for name, values in zip(("ax", "ay"), data, strict=True):
            group.create_dataset(name, data=values, chunks=(512,), compression="gzip").attrs["units"] = "m/s2"
    return path


def make_numpy(folder: Path, data: np.ndarray) -> Path:
    path = folder / "sample.npz"
    np.savez_compressed(path, ax=data[0], ay=data[1], fs=np.array(RATE_HZ))
    return path


def make_parquet(folder: Path, data: np.ndarray) -> Path:
    import pyarrow as pa
    import pyarrow.parquet as pq

    path = folder / "sample.parquet"
    time = np.arange(data.shape[1]) / RATE_HZ
    table = pa.table({"time": time, "ax (m/s2)": data[0], "ay (m/s2)": data[1]})
    pq.write_table(table, path, row_group_size=700)
    return path


def make_tdms(folder: Path, data: np.ndarray) -> Path:
    from nptdms import ChannelObject, TdmsWriter

    path = folder / "sample.tdms"
    properties = {"wf_increment": 1 / RATE_HZ, "unit_string": "m/s^2"}
    with TdmsWriter(path) as writer:
        for part in np.array_split(data, 3, axis=1):
            writer.write_segment(
                [ChannelObject("g", name, values, properties) for name, values in zip(("ax", "ay"), part, strict=True)]
            )
    return path


def make_uff(folder: Path, data: np.ndarray, *, binary: int = 1) -> Path:
    import pyuff

    path = folder / f"sample{binary}.uff"
    with warnings.catch_warnings():
        # pyuff leaves the file it wrote open.
        warnings.simplefilter("ignore", ResourceWarning)
        file = pyuff.UFF(str(path))
        for name, values in zip(("ax", "ay"), data, strict=True):
            file.write_sets(
                pyuff.prepare_58(
                    binary=binary,
                    func_type=1,
                    rsp_ent_name=name,
                    rsp_node=1,
                    rsp_dir=3,
                    ref_ent_name="NONE",
                    ref_node=0,
                    ref_dir=0,
                    id1="test",
                    data=values.astype(float),
                    x=np.arange(values.size) / RATE_HZ,
                    abscissa_inc=1 / RATE_HZ,
                    abscissa_spacing=1,
                    abscissa_spec_data_type=17,
                    ordinate_spec_data_type=12,
                    ordinate_axis_units_lab="m/s2",
                    orddenom_spec_data_type=0,
                    z_axis_spec_data_type=0,
                ),
                mode="add",
            )
        gc.collect()
    return path


def make_sound(folder: Path, data: np.ndarray) -> Path:
    import soundfile

    path = folder / "sample.wav"
    soundfile.write(path, data.T, int(RATE_HZ), subtype="FLOAT")
    return path


#: Maker of each reader module's sample. A reader without one fails its contract test.
MAKERS: dict[str, Callable[[Path, np.ndarray], Path]] = {
    "csv_text": make_csv,
    "hdf5": make_hdf5,
    "matlab5": make_matlab5,
    "matlab73": make_matlab73,
    "numpy_arrays": make_numpy,
    "parquet_feather": make_parquet,
    "tdms": make_tdms,
    "uff58": make_uff,
    "wav_flac": make_sound,
}


@pytest.fixture(scope="session")
def sample_signals() -> np.ndarray:
    return signals()


@pytest.fixture(scope="session")
def sample_rate() -> float:
    return RATE_HZ


@pytest.fixture(scope="session")
def samples(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Path of one sample file for each reader module."""
    out: dict[str, Path] = {}
    for name, make in MAKERS.items():
        folder = tmp_path_factory.mktemp(name)
        out[name] = make(folder, signals())
    return out


@pytest.fixture(scope="session")
def more_samples(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Second forms of formats: gzip, FLAC, NPY, Feather, text UFF."""
    import pyarrow as pa
    import soundfile
    from pyarrow import feather

    folder, data = tmp_path_factory.mktemp("more"), signals()
    plain = make_csv(folder, data)
    packed = folder / "sample.csv.gz"
    packed.write_bytes(gzip.compress(plain.read_bytes()))
    np.save(folder / "sample.npy", data.T)
    soundfile.write(folder / "sample.flac", np.round(data.T * 2**15) / 2**15, int(RATE_HZ), subtype="PCM_16")
    table = pa.table({"time": np.arange(data.shape[1]) / RATE_HZ, "ax (m/s2)": data[0], "ay (m/s2)": data[1]})
    feather.write_feather(table, folder / "sample.feather")
    return {
        "csv_text": packed,
        "numpy_arrays": folder / "sample.npy",
        "wav_flac": folder / "sample.flac",
        "parquet_feather": folder / "sample.feather",
        "uff58": make_uff(folder, data, binary=0),
    }


@pytest.fixture(scope="session")
def measured_folder() -> Path:
    """Folder of the measured recordings, beside the checkout."""
    folder = Path(__file__).resolve().parents[2].parent / "shared" / "data"
    if not folder.is_dir():
        pytest.skip(f"measured recordings are not at {folder}")
    return folder


@pytest.fixture
def bucket(monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """Yield a bucket of an S3 server on this computer."""
    server = pytest.importorskip("moto.server", reason="needs moto (pip install 'moto[server]')")
    s3fs = pytest.importorskip("s3fs", reason="needs s3fs (pip install s3fs)")
    import boto3

    # Those that it keeps know the address of the server of an earlier test.
    s3fs.S3FileSystem.clear_instance_cache()

    for name in ("AWS_ACCESS_KEY_ID", "AWS_SECRET_ACCESS_KEY"):
        monkeypatch.setenv(name, "test")
    monkeypatch.setenv("AWS_DEFAULT_REGION", "us-east-1")
    running = server.ThreadedMotoServer(ip_address="127.0.0.1", port=0)
    running.start()
    host, port = running.get_host_and_port()
    monkeypatch.setenv("AWS_ENDPOINT_URL", f"http://{host}:{port}")
    # Servers of one process share what they hold.
    urlopen(Request(f"http://{host}:{port}/moto-api/reset", method="POST")).close()
    boto3.client("s3").create_bucket(Bucket="plant")
    yield "s3://plant"
    running.stop()
