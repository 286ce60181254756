"""Reports as files: nothing is lost, nothing is left half done."""

from __future__ import annotations

from pathlib import Path

import pytest
from rotorwise.datasets.errors import RotorwiseError
from rotorwise.diagnose.report import write_report


def test_existing_report_is_kept_unless_forced(make, tmp_path: Path) -> None:
    target = tmp_path / "report.html"
    target.write_text("<!DOCTYPE html>mine")
    with pytest.raises(RotorwiseError, match="--force"):
        write_report([make.bare()], target)
    assert target.read_text() == "<!DOCTYPE html>mine"
    write_report([make.bare()], target, force=True)
    assert target.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    assert [entry.name for entry in tmp_path.iterdir()] == ["report.html"]


def test_other_data_is_never_replaced(make, tmp_path: Path) -> None:
    target = tmp_path / "recording.csv"
    target.write_text("1,2,3")
    with pytest.raises(RotorwiseError, match="never replaces other data"):
        write_report([make.bare()], target, force=True)
    assert target.read_text() == "1,2,3"


def test_a_device_is_never_replaced(make) -> None:
    with pytest.raises(RotorwiseError, match="regular file"):
        write_report([make.bare()], Path("/dev/null"), force=True)
    assert not Path("/dev/null").is_file()


def test_failed_writing_leaves_nothing_behind(make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(self: Path, other: Path) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(RotorwiseError, match="No space left"):
        write_report([make.bare()], tmp_path / "report.html")
    assert list(tmp_path.iterdir()) == []


def test_folders_and_missing_folders_are_refused(make, tmp_path: Path) -> None:
    with pytest.raises(RotorwiseError, match="is a folder"):
        write_report([make.bare()], tmp_path)
    with pytest.raises(RotorwiseError, match="does not exist"):
        write_report([make.bare()], tmp_path / "no" / "report.html")
