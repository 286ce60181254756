"""A disk that fills up while a recording is written: one error for every format, and nothing left behind."""

import subprocess
import sys
from pathlib import Path

import pytest

resource = pytest.importorskip("resource", reason="needs a limit on the size of files")

#: A file may grow to 16 KiB only; what is written would take more than ten times that. A process of its own, because
#: a library that fails at closing the file can take Python with it.
_SCRIPT = """
import resource, sys
import numpy as np
from rotorwise.datasets.recording import Channel, Recording
from rotorwise.datasets.write import write_recording
from rotorwise.simulators.errors import RotorwiseError

signals = np.random.default_rng(1).normal(size=(2, 20_000))
recording = Recording(signals, 10_000.0, tuple(Channel(n, "acceleration", None, None, "m/s2") for n in "ab"))
if sys.argv[2] == "full":
    resource.setrlimit(resource.RLIMIT_FSIZE, (16384, resource.getrlimit(resource.RLIMIT_FSIZE)[1]))
try:
    write_recording(recording, sys.argv[1])
except RotorwiseError as problem:
    print(problem)
    sys.exit(4)
"""


def write(path: Path, disk: str) -> subprocess.CompletedProcess[str]:
    words = [sys.executable, "-c", _SCRIPT, str(path), disk]
    return subprocess.run(words, capture_output=True, text=True, timeout=100, check=False)


@pytest.mark.parametrize("suffix", ["csv", "wav", "parquet", "h5", "mat", "npz"])
def test_a_full_disk_is_one_message_and_leaves_nothing(suffix: str, tmp_path: Path) -> None:
    done = write(tmp_path / f"a.{suffix}", "full")
    assert done.returncode == 4, done.stderr
    assert "cannot be written" in done.stdout
    assert "Choose another place." in done.stdout
    assert done.stderr == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", ["wav", "h5"])
def test_the_same_record_is_written_where_there_is_room(suffix: str, tmp_path: Path) -> None:
    done = write(tmp_path / f"a.{suffix}", "empty")
    assert done.returncode == 0, done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([f"a.{suffix}", "a.toml"])
