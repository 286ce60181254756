"""Files and a runner for the tests of ``rotorwise orders``, ``envelope`` and ``sidebands``."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from rotorwise.diagnose.cli import main

RATE = 5_000.0


def run(monkeypatch: pytest.MonkeyPatch, *arguments: object) -> int:
    """Run the command in this process; return the exit code."""
    monkeypatch.setattr(sys, "argv", ["rotorwise", *map(str, arguments)])
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit) as left:
        main()
    return int(left.value.code or 0)


def write_csv(path: Path, columns: dict[str, np.ndarray]) -> Path:
    """Write columns with a time axis at 5 kHz."""
    time = np.arange(len(next(iter(columns.values())))) / RATE
    table = np.column_stack([time, *columns.values()])
    np.savetxt(path, table, delimiter=",", header=",".join(["time (s)", *columns]), comments="", fmt="%.8g")
    return path


def payload(path: Path) -> dict:
    """Return what the page's script draws."""
    found = re.search(r'<script type="application/json" id="data-f0">(.*?)</script>', path.read_text("utf-8"), re.S)
    assert found is not None
    return json.loads(found.group(1))


def expanded(curve: dict) -> tuple[np.ndarray, np.ndarray]:
    """Return x and y of a curve of the page."""
    y = np.array(curve["y"], dtype=float)
    return (curve["x0"] + curve["dx"] * np.cumsum(curve["i"]) if "i" in curve else np.array(curve["x"])), y
