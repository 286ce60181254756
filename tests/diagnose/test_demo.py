"""The demonstration: its answer against the sealed truth, how its recordings are made, what it leaves alone."""

from __future__ import annotations

import filecmp
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest
import soundfile
from rotorwise.diagnose import demo, demo_campaign
from rotorwise.diagnose.demo_files import DemoFolderError
from rotorwise.diagnose.gap.campaign import find_sources
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import machine_from_toml

COMMAND = Path(sys.executable).with_name("rotorwise")
SHIPPED = Path(demo.__file__).with_name("demo-data")


def run(*arguments: object) -> subprocess.CompletedProcess[str]:
    words = [str(COMMAND), "demo", *map(str, arguments)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=280, check=False)
    assert "Traceback" not in done.stderr + done.stdout, done.stderr
    return done


def test_what_was_hidden_is_named_and_lies_in_the_intervals(tmp_path: Path) -> None:
    # One test, as the search takes half a minute.
    folder = tmp_path / "demo"
    done = run("--output", folder)
    assert done.returncode == 0, done.stderr
    truth = tomllib.loads((folder / "sealed.toml").read_text(encoding="utf-8"))
    assert f"Cause: {truth['effect'].replace('_', ' ')}" in " ".join(done.stdout.split())
    gain = re.search(r"extended machine ([\d.]+) dB, calibration alone (-?[\d.]+) dB", " ".join(done.stdout.split()))
    assert gain
    assert float(gain[1]) > float(gain[2]) + 10

    # Each true value stands beside its estimate and, of intervals that hold it nine times in ten, in all but one.
    rows = re.findall(r"(-?[\d.]+) (?:um|deg) +-?[\d.]+ (?:um|deg) \((-?[\d.]+) to (-?[\d.]+)\)", done.stdout)
    assert len(rows) == len(truth["parameters"]) == 4
    inside = [float(low) <= float(value) <= float(high) for value, low, high in rows]
    assert sum(inside) >= 3

    extended = machine_from_toml((folder / "extended.toml").read_text(encoding="utf-8"))
    assert [one.NAME for one in extended.effects] == [truth["effect"]]
    assert (folder / "report.html").stat().st_size > 1e6

    # A second time only when asked for; somebody else's files never.
    assert run("--output", folder).returncode == 4


def test_the_truth_is_not_among_what_the_engine_reads(tmp_path: Path) -> None:
    campaign = demo.write_demo(tmp_path, force=False)
    sources = find_sources([campaign])
    read = (*sources.recordings, *sources.baseline)
    assert len(sources.recordings) == len(demo_campaign.SPEEDS_RPM)
    assert len(sources.baseline) == len(demo_campaign.HEALTHY_SPEEDS_RPM)
    assert not sources.left_out
    assert all(campaign in one.parents for one in read)
    assert (tmp_path / demo.SEALED).is_file()
    assert campaign not in (tmp_path / demo.SEALED).parents
    hidden = tomllib.loads((tmp_path / demo.SEALED).read_text(encoding="utf-8"))["effect"]
    assert not any(hidden.encode() in one.read_bytes() for one in campaign.rglob("*") if one.is_file())


def test_the_documented_command_makes_what_is_shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # One recording of each kind; the others only differ in speed and seed.
    monkeypatch.setattr(demo_campaign, "SPEEDS_RPM", demo_campaign.SPEEDS_RPM[:1])
    monkeypatch.setattr(demo_campaign, "HEALTHY_SPEEDS_RPM", demo_campaign.HEALTHY_SPEEDS_RPM[:1])
    head = (SHIPPED / demo.SEALED).read_text(encoding="utf-8")
    seed = re.search(r"--seed (\d+)", head)
    assert seed
    assert demo_campaign.main(["-o", str(tmp_path / "new"), "--seed", seed[1]]) == 0
    assert filecmp.cmp(tmp_path / "new" / demo.SEALED, SHIPPED / demo.SEALED, shallow=False)
    made = sorted((tmp_path / "new").rglob("*.flac"))
    assert len(made) == 2
    for one in made:
        again, rate_hz = soundfile.read(one)
        there, _ = soundfile.read(SHIPPED / one.relative_to(tmp_path / "new"))
        assert rate_hz == demo_campaign.RATE_HZ
        # Another computer may round a sample to the neighbouring step of the converter.
        assert np.abs(again - there).max() < 3 * 2.0**-15


def test_the_maker_replaces_nothing_and_stays_within_the_converter(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "mine.txt").write_text("mine")
    assert demo_campaign.main(["-o", str(tmp_path), "--seed", "1"]) == 2
    assert "a new or an empty folder" in capsys.readouterr().err
    monkeypatch.setattr(demo_campaign, "SENSITIVITY_V_M", 1e5)
    with pytest.raises(InvalidValueError, match="Hide less"):
        demo_campaign.write_campaign(tmp_path / "new", seed=1)


def test_files_of_somebody_else_stay(tmp_path: Path) -> None:
    demo.write_demo(tmp_path / "ours", force=False)
    with pytest.raises(DemoFolderError, match="--force"):
        demo.write_demo(tmp_path / "ours", force=False)
    demo.write_demo(tmp_path / "ours", force=True)
    mine = tmp_path / "other" / "sealed.toml"
    mine.parent.mkdir()
    mine.write_text("mine")
    with pytest.raises(DemoFolderError, match="stays"):
        demo.write_demo(mine.parent, force=True)
    assert mine.read_text() == "mine"
    with pytest.raises(DemoFolderError, match="can be written"):
        demo.write_demo(mine, force=True)
