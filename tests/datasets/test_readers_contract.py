"""One contract for all readers: parametrised by scanning the folder, so a new reader cannot opt out."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rotorwise.datasets.errors import RotorwiseError, UnreadableFileError
from rotorwise.datasets.file_content import FileContent
from rotorwise.datasets.readers import all_readers, content_blocks, find_reader, read_content, read_head

READERS = [pytest.param(reader, id=reader.__name__.rsplit(".", 1)[-1]) for reader in all_readers()]
SECOND_FORMS = ("csv_text", "numpy_arrays", "wav_flac", "parquet_feather", "uff58")
FILES = [("samples", reader.id) for reader in READERS] + [("more_samples", name) for name in SECOND_FORMS]

# Text and single-stream formats do not state their own length, so a cut at a row's end leaves no trace.
LENGTH_UNSTATED = {"csv_text"}
MAGIC = [
    b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM",
    b"\x89HDF\r\n\x1a\n",
    b"TDSm",
    b"RIFF\x24\x00\x01\x00WAVEfmt ",
    b"fLaC",
    b"PAR1",
    b"ARROW1\x00\x00",
    b"\x93NUMPY\x01\x00",
    b"PK\x03\x04" + bytes(22) + b"\x05\x00\x00\x00a.npy",
    b"    -1\n    58b     1     2          11        4000\n",
    b"1.0,2.0\n3.0,4.0\n",
    b"\x1f\x8b\x08\x00",
]


def module_name(reader) -> str:
    return reader.__name__.rsplit(".", 1)[-1]


@pytest.fixture(params=[f"{which}-{name}" for which, name in FILES])
def sample(request: pytest.FixtureRequest) -> tuple[str, Path]:
    which, name = request.param.split("-")
    return name, request.getfixturevalue(which)[name]


@pytest.mark.parametrize("reader", READERS)
def test_has_name_suffixes_and_docstrings(reader) -> None:
    assert reader.NAME
    assert all(suffix.startswith(".") for suffix in reader.SUFFIXES)
    assert reader.__doc__
    assert reader.read.__doc__


def test_every_reader_has_a_sample(samples: dict[str, Path]) -> None:
    assert set(samples) == {module_name(reader) for reader in all_readers()}


def test_recognised_by_exactly_one_reader(sample: tuple[str, Path]) -> None:
    name, path = sample
    head = read_head(path)
    assert [module_name(reader) for reader in all_readers() if reader.recognises(path, head)] == [name]


def test_recognised_under_any_suffix(sample: tuple[str, Path], tmp_path: Path) -> None:
    name, path = sample
    renamed = tmp_path / "renamed.bin"
    shutil.copy(path, renamed)
    assert module_name(find_reader(renamed)) == name


def test_gives_the_signals_back(sample: tuple[str, Path], sample_signals: np.ndarray, sample_rate: float) -> None:
    _, path = sample
    content = read_content(path)
    assert content.signals.dtype in (np.float32, np.float64)
    # FLAC holds 16 bits here, text six digits at least.
    np.testing.assert_allclose(
        content.signals, sample_signals, rtol=2e-6, atol=2**-15 if path.suffix == ".flac" else 1e-8
    )
    assert content.total_samples == content.samples == sample_signals.shape[1]
    assert len(set(content.channel_names)) == len(content.units) == 2
    if path.suffix == ".npy":
        assert content.rate_hz is None
    else:
        assert content.rate_hz == pytest.approx(sample_rate, rel=1e-6)
    assert content.warnings == ()


@pytest.mark.parametrize(
    ("start", "stop"), [(0, 1), (0, 700), (699, 1401), (1000, None), (4000, 99999), (5, 5), (5000, None)]
)
def test_slice_equals_the_slice_of_the_whole(sample: tuple[str, Path], start: int, stop: int | None) -> None:
    _, path = sample
    part, whole = read_content(path, start=start, stop=stop), read_content(path)
    np.testing.assert_array_equal(part.signals, whole.signals[:, start:stop])
    assert part.channel_names == whole.channel_names
    assert part.units == whole.units
    assert part.start_sample == min(start, whole.samples)
    assert part.rate_hz == whole.rate_hz


@pytest.mark.parametrize("size", [1000, 1024, 10_000])
def test_blocks_join_to_the_whole(sample: tuple[str, Path], size: int) -> None:
    _, path = sample
    parts, whole = list(content_blocks(path, block_samples=size)), read_content(path)
    assert all(part.samples <= size for part in parts)
    np.testing.assert_array_equal(np.concatenate([part.signals for part in parts], axis=1), whole.signals)
    assert [part.start_sample for part in parts] == list(range(0, whole.samples, size))
    assert {part.rate_hz for part in parts} == {whole.rate_hz}


def test_truncated_gives_a_prefix_with_a_warning_or_is_refused(sample: tuple[str, Path], tmp_path: Path) -> None:
    name, path = sample
    data, whole = path.read_bytes(), read_content(path)
    rng = np.random.default_rng(1)
    for index, length in enumerate([0, 1, 8, *rng.integers(9, len(data) - 1, 15)]):
        cut = tmp_path / f"{index}{path.suffix}"
        cut.write_bytes(data[:length])
        try:
            content = read_content(cut)
        except UnreadableFileError as error:
            assert cut.name in str(error)  # noqa: PT017
            continue
        _assert_prefix(content, whole, exact=name not in LENGTH_UNSTATED)
        assert content.warnings or content.samples == whole.samples or name in LENGTH_UNSTATED, length


def _assert_prefix(content: FileContent, whole: FileContent, *, exact: bool) -> None:
    # Of text, the last number can be cut within its digits and still be one.
    samples = content.samples if exact else content.samples - 1
    channels = [whole.channel_names.index(name) for name in content.channel_names if name in whole.channel_names]
    assert len(channels) == len(content.channel_names) or samples < 2
    if channels:
        np.testing.assert_array_equal(content.signals[:, :samples], whole.signals[channels, :samples])


def test_corrupted_bytes_never_give_another_error(sample: tuple[str, Path], tmp_path: Path) -> None:
    _, path = sample
    data = np.frombuffer(path.read_bytes(), dtype=np.uint8)
    for seed in range(40):
        rng = np.random.default_rng(seed)
        # Half of the damage goes to the head, where the structure is.
        reach = data.size if seed % 2 else min(data.size, 2000)
        damaged = data.copy()
        places = rng.integers(0, reach, rng.integers(1, 20))
        damaged[places] = rng.integers(0, 256, places.size)
        target = tmp_path / f"{seed}{path.suffix}"
        target.write_bytes(damaged.tobytes())
        try:
            content = read_content(target)
        except UnreadableFileError:
            continue
        assert content.signals.shape[0] == len(content.channel_names) == len(content.units)


@given(magic=st.sampled_from(MAGIC), tail=st.binary(max_size=600))
@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_known_beginning_with_rubbish_behind(magic: bytes, tail: bytes, tmp_path: Path) -> None:
    path = tmp_path / "rubbish"
    path.write_bytes(magic + tail)
    try:
        content = read_content(path)
    except RotorwiseError as error:
        assert str(path) in str(error)  # noqa: PT017
    else:
        assert content.samples > 0


def test_a_folder_a_missing_and_an_empty_file_are_refused(tmp_path: Path) -> None:
    (tmp_path / "empty.csv").touch()
    for path, word in (
        (tmp_path, "folder"),
        (tmp_path / "none.csv", "no such file"),
        (tmp_path / "empty.csv", "empty"),
    ):
        with pytest.raises(UnreadableFileError, match=word):
            read_content(path)


def test_prose_and_html_are_no_recording(tmp_path: Path) -> None:
    for text in (
        "Dear colleague,\nthe pump is fine.\n",
        "<html><body>1,2\n3,4</body></html>",
        '{"a": [1, 2, 3]}',
    ):
        path = tmp_path / "text.txt"
        path.write_text(text)
        with pytest.raises(UnreadableFileError, match="rows of numbers"):
            read_content(path)


def test_scanning_imports_no_heavy_library() -> None:
    heavy = "pandas pyarrow h5py nptdms pyuff soundfile scipy"
    code = (
        "import sys, rotorwise.datasets.readers as r, rotorwise.datasets as d; r.all_readers(); d.read; "
        "d.Metadata;"
        f"print([m for m in {heavy.split()!r} if m in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        check=True,
        cwd=Path(__file__).parent,
    )
    assert done.stdout.strip() == "[]"
