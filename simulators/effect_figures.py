"""The tests of each effect, as the table shows them: what they say of themselves, how close they came to theory."""

from __future__ import annotations

import ast
import importlib.util
import re
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from xml.etree import ElementTree

from .errors import RotorwiseError

_LAST_LINES = 15


class FigureError(RotorwiseError):
    """The tests of effects gave no figures: pytest is absent, a test failed, or a module recorded none."""


def measured_figures(names: Sequence[str], tests: Path) -> dict[str, str]:
    """Run the tests of some effects and return the figure of each.

    ``tests`` is the folder ``tests/simulators/effects`` of a checkout; effects without a module there are left out.
    Raises `FigureError`.
    """
    tested = [name for name in names if (tests / f"test_{name}.py").exists()]
    if not tested:
        return {}
    if importlib.util.find_spec("pytest") is None:
        raise FigureError("pytest is absent; the figures of the effects need it. Install the extra 'test'.")
    with TemporaryDirectory() as folder:
        written = Path(folder) / "figures.xml"
        _run([tests / f"test_{name}.py" for name in tested], written, tests.parents[2])
        found = figures_in(written)
    silent = [name for name in tested if name not in found]
    if silent:
        raise FigureError(
            f"No figure from the tests of {', '.join(silent)}; each effect has one. "
            "Call the fixture `figure` in its strongest test."
        )
    return found


def _run(modules: Sequence[Path], written: Path, root: Path) -> None:
    # -P: in the root `import datasets` would find our folder. The seed: a table made twice is the same. xunit1: the
    # newer family of the format has no properties of a test, and pytest warns of each.
    options = ["-q", "--hypothesis-seed=0", f"--junitxml={written}", "-o", "junit_family=xunit1"]
    command = [sys.executable, "-P", "-m", "pytest", *options, *map(str, modules)]
    done = subprocess.run(command, cwd=root, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        said = "\n".join((done.stdout + done.stderr).strip().splitlines()[-_LAST_LINES:])
        raise FigureError(
            f"pytest ended with {done.returncode}; allowed is 0, every test passed. Nothing is written. "
            f"Mend what it says:\n{said}"
        )


def figures_in(written: Path) -> dict[str, str]:
    """Return the figure of each effect in a JUnit file, of several recorded for one effect the worst."""
    texts: dict[str, list[str]] = {}
    for case in ElementTree.parse(written).iter("testcase"):
        module = re.search(r"(?:^|\.)test_(\w+)", case.get("classname", ""))
        for entry in case.iter("property"):
            if module and entry.get("name") == "figure":
                texts.setdefault(module.group(1), []).append(entry.get("value", ""))
    return {name: max(own, key=_size) for name, own in texts.items()}


def _size(figure: str) -> float:
    """Return the deviation that a figure names, 0 for one that names none."""
    found = re.match(r"([\d.]+(?:e[+-]?\d+)?)( %)? (?:.* )?off$", figure.rpartition(": ")[2])
    return float(found.group(1)) / (100 if found.group(2) else 1) if found else 0.0


def cell_of_test(name: str, tests: Path, figure: str | None) -> str:
    """Return the figure of an effect's test, its module with the number of tests, and what that says of itself."""
    path = tests / f"test_{name}.py"
    if not path.exists():
        return "contract only"
    parsed = ast.parse(path.read_text(encoding="utf-8"))
    says = (ast.get_docstring(parsed) or "").split("\n\n")[0].replace("\n", " ")
    count = sum(isinstance(node, ast.FunctionDef) and node.name.startswith("test_") for node in ast.walk(parsed))
    first = f"**{figure}**<br>" if figure else ""
    return f"{first}[{count} tests](../../tests/simulators/effects/{path.name}): {says}".replace("|", "/")
