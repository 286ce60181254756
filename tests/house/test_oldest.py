"""The list of oldest versions is that of pyproject.toml."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def pinned(version: str) -> str:
    return version + ".0" * (2 - version.count("."))


def test_oldest_versions_are_the_lower_bounds() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    asked = [*project["dependencies"], *project["optional-dependencies"]["test"]]
    bounds = {name: pinned(low) for name, low in (re.fullmatch(r"([\w-]+)>=([\d.]+)", one).groups() for one in asked)}
    lines = (ROOT / "tests" / "oldest.txt").read_text(encoding="utf-8").splitlines()
    listed = dict(line.split("==") for line in lines if not line.startswith("#"))
    assert listed == bounds
