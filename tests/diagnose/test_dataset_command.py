"""``rotorwise dataset``: build, go on, look, and what it says when something is wrong."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest
from rotorwise.datasets import recipes
from rotorwise.datasets.generate import Progress
from rotorwise.diagnose.dataset_show import duration, pace

from .command import run

SMALL = Path(__file__).parents[1] / "datasets" / "recipe_small.toml"


def rotorwise(*words: object) -> subprocess.CompletedProcess[str]:
    """Run the command in a process of its own."""
    environment = {**os.environ, "COLUMNS": "100", "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-c", "from rotorwise.diagnose.cli import main; main()", *map(str, words)]
    return subprocess.run(command, capture_output=True, text=True, timeout=200, check=False, env=environment)


def test_build_goes_on_and_info_tells(tmp_path: Path) -> None:
    first = rotorwise("dataset", "build", SMALL, "-o", tmp_path / "set", "--limit", 20, "--workers", 1)
    assert first.returncode == 0, first.stderr
    assert "20 signals, 40 to be built" in first.stdout
    assert "0 of 20 signals" in first.stderr
    assert "a second" in first.stderr
    second = rotorwise("dataset", "build", SMALL, "-o", tmp_path / "set", "--workers", 1, "--json")
    assert second.returncode == 0, second.stderr
    assert "20 of 60 signals, starting, 20 are there" in second.stderr
    made = json.loads(second.stdout)
    assert (made["rows"], made["signals_wanted"], made["refused"]) == (60, 60, [])
    told = rotorwise("dataset", "info", tmp_path / "set")
    assert told.returncode == 0
    assert "small: 60 signals, complete" in told.stdout
    assert "parallel misalignment" in told.stdout
    assert "path_1 (m)" in told.stdout
    found = json.loads(rotorwise("dataset", "info", tmp_path / "set", "--json").stdout)
    assert found == made
    assert found["bytes"] == sum(path.stat().st_size for path in (tmp_path / "set" / "data").iterdir())
    assert len(pd.read_parquet(tmp_path / "set" / "data")) == 60


@pytest.mark.skipif(os.name == "nt", reason="signals")
@pytest.mark.parametrize(
    ("number", "workers"),
    [(signal.SIGINT, "1"), pytest.param(signal.SIGTERM, "2", marks=pytest.mark.slow), (signal.SIGINT, "2")],
)
def test_a_stopped_build_ends_in_order(number: signal.Signals, workers: str, tmp_path: Path) -> None:
    # A job in the background of a shell inherits that Ctrl-C is ignored.
    heard = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)"
    program = f"{heard}; from rotorwise.diagnose.cli import main; main()"
    command = [sys.executable, "-c", program, "dataset", "build", "tiny"]
    words = "-o", str(tmp_path / "set"), "--workers", workers
    build = subprocess.Popen([*command, *words], stderr=subprocess.PIPE, text=True)
    try:
        for _ in range(2000):
            if (tmp_path / "set" / "data").is_dir() and any((tmp_path / "set" / "data").iterdir()):
                break
            time.sleep(0.05)
        build.send_signal(number)
        _, told = build.communicate(timeout=60)
    finally:
        build.kill()
    assert build.returncode == 128 + number, told
    assert "stopped. What is in" in told
    assert "Traceback" not in told
    assert "of 24 signals so far" in (tmp_path / "set" / "card.md").read_text(encoding="utf-8")


def test_files_that_are_no_parts_are_named_as_other_programs_would_read_them(tmp_path: Path) -> None:
    words = "dataset", "build", SMALL, "-o", tmp_path / "set", "--limit", 10, "--workers", 1
    assert "not read" not in rotorwise(*words).stdout
    (tmp_path / "set" / "data" / "other.parquet").write_bytes(b"PAR1")
    assert "not read: other.parquet: no whole parts" in rotorwise(*words).stdout


def test_recipes_are_listed() -> None:
    told = run("dataset", "recipes", environment={"COLUMNS": "100"})
    assert told.returncode == 0
    wanted = {path.stem for path in Path(recipes.__path__[0]).glob("*.toml")}
    assert {"amb_thresholds", "gearbox_faults", "misalignment_load_speed", "test_rig_faults", "tiny"} <= wanted
    assert wanted <= set(told.stdout.split())
    found = json.loads(run("dataset", "recipes", "--json").stdout)
    assert wanted == {one["name"] for one in found}
    assert all(one["signals"] > 0 and one["machines"] for one in found)


def test_mistakes_are_one_line_and_a_code(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear", encoding="utf-8")
    cases = [
        (("build", "tinny", "-o", tmp_path / "a"), 2, "Did you mean tiny?"),
        (("build", tmp_path / "none.toml", "-o", tmp_path / "a"), 2, "cannot be read"),
        (("build", SMALL, "-o", tmp_path / "a", "--workers", 0), 2, "workers = 0; allowed: 1 or more"),
        (("build", SMALL, "-o", tmp_path / "a", "--limit", -3), 2, "limit = -3; allowed: 1 or more"),
        (("build", SMALL, "-o", tmp_path / "a", "--workers", 2, "--cluster", "tcp://x:1"), 2, "Give one of them"),
        (("build", SMALL, "-o", tmp_path / "mine"), 4, "holds files, but no dataset"),
        (("build", SMALL, "-o", tmp_path / "mine" / "letter.txt"), 4, "is a file"),
        (("build", SMALL, "-o", "/proc/nothing"), 4, "cannot be written to"),
        (("info", tmp_path / "mine"), 4, "holds no dataset"),
    ]
    for words, code, text in cases:
        done = run("dataset", *words, environment={"COLUMNS": "100"})
        assert (done.returncode, done.stdout) == (code, ""), done.stderr
        assert text in done.stderr
        assert len(done.stderr.strip().splitlines()) == 1, done.stderr
    assert not (tmp_path / "a").exists()
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["letter.txt"]


@pytest.mark.parametrize(
    ("now", "seconds", "words"),
    [
        (Progress(0, 90, 0, 0), 1.0, "starting"),
        (Progress(60, 60, 0, 60), 1.0, "nothing left to build"),
        (Progress(60, 60, 3, 0), 30.0, "2.0 a second, 3 refused"),
        (Progress(40, 400, 0, 10), 3.0, "10.0 a second, 36 s left"),
    ],
)
def test_the_pace_counts_what_this_build_has_done(now: Progress, seconds: float, words: str) -> None:
    assert pace(now, seconds) == words


def test_durations_carry_over() -> None:
    assert [duration(s) for s in (59.6, 3599.7, 86400)] == ["1 min 0 s", "1 h 0 min", "1 d 0 h"]
