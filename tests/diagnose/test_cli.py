"""The command as a user meets it: exit codes, output, files; as installed, in a process of its own, where marked."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from rotorwise.datasets.write import write_csv

from .command import Done, run
from .conftest import Make

COMMAND = Path(sys.executable).with_name("rotorwise")


def rotorwise(*arguments: object, cwd: Path | None = None) -> Done:
    """Run the command and return what it said."""
    done = run(*arguments, cwd=cwd)
    assert "Traceback" not in done.stderr + done.stdout, done.stderr
    return done


def installed(*arguments: object, cwd: Path | None = None) -> Done:
    """Run the installed command in a process of its own."""
    words = [str(COMMAND), *map(str, arguments)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120, cwd=cwd, check=False)
    assert "Traceback" not in done.stderr + done.stdout, done.stderr
    return done


@pytest.fixture
def recording(make: Make, tmp_path: Path) -> Path:
    """Return a small CSV recording without its machine."""
    return write_csv(make(seconds=2.0), tmp_path / "pump.csv")


def test_json_has_the_documented_keys(recording: Path) -> None:
    done = rotorwise("analyse", recording, "--speed", 1480, "--bearing", "6205", "--json")
    assert done.returncode == 0, done.stderr
    (answer,) = json.loads(done.stdout)
    assert {"path", "speed_rpm", "findings", "severity", "warnings"} <= set(answer)
    assert answer["speed_rpm"] == pytest.approx(24.6 * 60, rel=2e-3)
    assert {"standard", "zone", "value", "unit"} <= set(answer["severity"])
    assert answer["findings"] == []


def test_json_of_a_finding(make: Make, tmp_path: Path) -> None:
    healthy = write_csv(make(seconds=3.0, seed=2), tmp_path / "healthy.csv")
    heavy = write_csv(make(seconds=3.0, lines={1: 3.0, 2: 0.1}), tmp_path / "heavy.csv")
    done = installed("analyse", heavy, "--baseline", healthy, "--speed", 1480, "--json")
    (answer,) = json.loads(done.stdout)
    finding = answer["findings"][0]
    assert finding["fault"] == "unbalance"
    # A risen 1X at one speed is shared with misalignment and a bent shaft: first, more likely than not, not certain.
    assert 0.5 < finding["probability"] <= 1.0
    assert {"misalignment", "bent_shaft"} <= {other["fault"] for other in answer["findings"]}
    assert finding["evidence"][0]["signal_to_noise"] > 10


def test_report_is_written_once_and_kept(recording: Path, tmp_path: Path) -> None:
    report = tmp_path / "out.html"
    assert rotorwise("analyse", recording, "--speed", 1480, "--report", report).returncode == 0
    before = report.read_bytes()
    refused = rotorwise("analyse", recording, "--speed", 1480, "--report", report)
    assert refused.returncode == 4
    assert "--force" in refused.stderr
    assert report.read_bytes() == before
    assert rotorwise("analyse", recording, "--speed", 1480, "--report", report, "--force").returncode == 0


def test_report_never_replaces_a_recording(recording: Path) -> None:
    before = recording.read_bytes()
    done = rotorwise("analyse", recording, "--speed", 1480, "--report", recording, "--force")
    assert done.returncode == 4
    assert recording.read_bytes() == before


def test_missing_rate_says_how_to_give_it(tmp_path: Path) -> None:
    path = tmp_path / "bare.csv"
    np.savetxt(path, np.random.default_rng(0).normal(size=(3000, 2)), delimiter=",")
    done = rotorwise("analyse", path)
    assert done.returncode == 3
    assert "--rate" in done.stderr


def test_a_bad_file_does_not_stop_the_others(recording: Path, tmp_path: Path) -> None:
    (tmp_path / "broken.wav").write_bytes(b"RIFF\x00\x00\x00\x00WAVEfmt ")
    done = rotorwise("analyse", recording, tmp_path / "broken.wav", "--speed", 1480, "--json")
    assert done.returncode == 3
    assert "broken.wav" in done.stderr
    assert len(json.loads(done.stdout)) == 1


@pytest.mark.parametrize(
    ("arguments", "hint"),
    [
        (["--bearing", "9,39,7"], "ball"),
        (["--bearing", "nonsense"], "catalogue"),
        (["--teeth", "0"], "teeth"),
        (["--unit", "furlong"], "Allowed"),
        (["--sensitivity", "100"], "mV/g"),
        (["--rate", "-5"], "rate"),
        (["--rate", "nan"], "rate"),
        (["--speed", "-1"], "peed"),
        (["--mounting", "soft"], "rigid"),
        (["--severity-table", "iso9999"], "iso"),
        (["--sidecar", "nowhere.toml"], "nowhere.toml"),
        (["--baseline", "nowhere.csv"], "nowhere.csv"),
    ],
)
def test_bad_options_are_explained(recording: Path, arguments: list[str], hint: str) -> None:
    done = rotorwise("analyse", recording, *arguments)
    assert done.returncode in (2, 3)
    assert hint in done.stderr
    assert len(done.stderr) < 1200


def test_folder_gives_an_overview_and_names_what_it_left_out(make: Make, tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    for index in range(4):
        write_csv(make(seconds=1.0, seed=index), folder / f"{index}.csv")
    (folder / "notes.doc").write_text("not a recording")
    done = rotorwise("analyse", folder, "--speed", 1480)
    assert done.returncode == 0
    assert all(f"{index}.csv" in done.stdout for index in range(4))
    assert "notes.doc" in done.stderr


def test_sidecar_beside_the_file_is_used(make: Make, tmp_path: Path) -> None:
    path = write_csv(make(seconds=2.0, hint_rpm=None), tmp_path / "pump.csv")
    (tmp_path / "recording.toml").write_text(
        '[recording]\nspeed_rpm = 1480\n[machine]\n[[machine.bearing]]\ndesignation = "6205"\n'
    )
    (answer,) = json.loads(rotorwise("analyse", path, "--json").stdout)
    assert answer["features"]["outer_race_modulation"] is not None


def test_demo_of_analyse_writes_its_report_and_refuses_a_second_time(tmp_path: Path) -> None:
    folder = tmp_path / "demo"
    done = installed("demo", "--analyse", "--output", folder)
    assert done.returncode == 0
    for fault in ("unbalance", "bearing_outer_race", "bearing_inner_race"):
        assert fault in done.stdout
    assert (folder / "report.html").stat().st_size > 1e6
    assert installed("demo", "--analyse", "--output", folder).returncode != 0


@pytest.mark.parametrize("words", [("analyse",), ("orders",), ("orders", "--json"), ("envelope",)], ids=" ".join)
def test_a_reader_that_leaves_is_no_error(words: tuple[str, ...], make: Make, tmp_path: Path) -> None:
    """As with ``| head -0``: rich, typer and Python each answer it in a way of their own."""
    path = write_csv(make(seconds=2.0), tmp_path / "pump.csv")
    command = [COMMAND, words[0], path, *words[1:], "--speed", "1480"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        running.stdout.close()
        assert running.stderr.read() == b""
        assert running.wait(timeout=120) == 0


def test_version_and_help() -> None:
    assert installed("--version").stdout.strip()[0].isdigit()
    assert "--baseline" in installed("analyse", "--help").stdout
