"""Write the table of the catalogue: ``python -m rotorwise.simulators.effect_table [EFFECT ...]``.

Without names all effects are computed anew (some minutes), with names only those; the other rows stay. For every effect
a picture (spectrum with and without it, `docs/effects/NAME.svg`), the lines that it adds, how they grow with
speed and load, how far they rise in the picture, and its test.
"""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Sequence
from pathlib import Path

from .effect import Effect, Line, effect_catalogue
from .effect_exhibit import SPEED_RPM, Exhibit, exhibit, picture
from .effect_text import STAGE_TITLES, growth_text, line_text
from .errors import InvalidValueError
from .machine import Machine, machine_catalogue

#: In this order machines are tried: the rig that people have first.
PREFERRED = ("test_rig", "gearbox", "rigid_coupling", "amb_rotor")
MOST_LINES = 4

HEAD = f"""# Effects

One physical effect a file. Each declares its parameters with unit, bounds, prior and source, its signature, its rivals
and the measurement that tells them apart; `rotorwise effects NAME` prints all of that. Effects combine freely: none
knows another.

This table is made by `python -m rotorwise.simulators.effect_table` (with names: only those rows); do not edit it by
hand. Pictures: peak amplitude over orders of the shaft at {SPEED_RPM:g} rpm, a line for each decade with the values
of the lowest and the highest, grey without and blue with the effect at its default values; red marks stand at the
declared lines. *Growth* is that of the force behind a line, away from resonances. *Rise* is the line that rose most in
the picture (the floor, for an effect without lines of its own).
"""


def main(names: Sequence[str], root: Path) -> None:
    """Write the pictures and rows of some effects, or of all when none is named, into a checkout."""
    catalogue, machines = effect_catalogue(), _ordered(machine_catalogue())
    for name in names:
        if name not in catalogue:
            raise InvalidValueError(f"Effect {name!r} is unknown; allowed: {', '.join(catalogue)}. Correct the name.")
    readme = root / "simulators" / "effects" / "README.md"
    kept = _rows_of(readme.read_text(encoding="utf-8")) if readme.exists() else {}
    (root / "docs" / "effects").mkdir(parents=True, exist_ok=True)
    rows: dict[str, list[str]] = {stage: [] for stage in STAGE_TITLES}
    for name, effect in catalogue.items():
        if names and name not in names and name in kept:
            rows[effect.STAGE].append(kept[name])
            continue
        print(name, file=sys.stderr, flush=True)
        shown = exhibit(effect, machines)
        if shown is not None:
            (root / "docs" / "effects" / f"{name}.svg").write_text(picture(shown), encoding="utf-8")
        rows[effect.STAGE].append(row(effect, shown, root / "tests" / "simulators" / "effects"))
    readme.write_text(table(rows), encoding="utf-8")


def _rows_of(text: str) -> dict[str, str]:
    """Return the rows of a table written before, by effect."""
    found = (re.match(r"\| \*\*\[(\w+)\]", line) for line in text.splitlines())
    return {match.group(1): match.string for match in found if match}


def _ordered(machines: dict[str, Machine]) -> dict[str, Machine]:
    names = [name for name in PREFERRED if name in machines]
    return {name: machines[name] for name in [*names, *(n for n in machines if n not in names)]}


def table(rows: dict[str, list[str]]) -> str:
    """Return the whole text from the rows of each stage."""
    parts = [HEAD]
    for stage, title in STAGE_TITLES.items():
        parts.append(f"## {title}\n")
        parts.append("| effect | spectrum | lines and growth | rise | test |\n|---|---|---|---|---|")
        parts.append("\n".join(sorted(rows[stage])) + "\n")
    return "\n".join(parts)


def row(effect: type[Effect], shown: Exhibit | None, tests: Path) -> str:
    """Return one row of the table."""
    name = effect.NAME
    if shown is None:
        seen, lines, rise = "no machine shows it", "", ""
    else:
        seen = f"![{name} on {shown.machine}](../../docs/effects/{name}.svg)"
        lines, rise = lines_cell(shown.lines), rise_cell(shown)
    cells = [f"**[{name}]({name}.py)** {effect.MEANING}", seen, lines, rise, _test_cell(name, tests)]
    return "| " + " | ".join(cell.replace("|", "/") for cell in cells) + " |"


def lines_cell(lines: tuple[Line, ...]) -> str:
    """Return the lines of a signature with their growth, lines of one law together."""
    groups: dict[str, list[str]] = {}
    for line in lines[:MOST_LINES]:
        direction = "all directions" if line.direction == "any" else line.direction
        groups.setdefault(f"{direction}; {growth_text(line) or 'no simple law'}", []).append(line_text(line))
    texts = [f"{', '.join(places)} ({law})" for law, places in groups.items()]
    more = f"<br>{len(lines) - MOST_LINES} more" if len(lines) > MOST_LINES else ""
    return "<br>".join(texts) + more if texts else "none of its own"


def rise_cell(shown: Exhibit) -> str:
    """Return how far the strongest rise goes, in words."""
    what = "floor" if shown.line is None else line_text(shown.line)
    words = f"{what} is new" if shown.rise > 1e4 else f"{what} × {shown.rise:.3g}"
    return words if shown.is_visible else f"{words}, far below the strongest line"


def _test_cell(name: str, tests: Path) -> str:
    path = tests / f"test_{name}.py"
    if not path.exists():
        return "contract only"
    parsed = ast.parse(path.read_text(encoding="utf-8"))
    says = (ast.get_docstring(parsed) or "").split("\n\n")[0].replace("\n", " ")
    count = sum(isinstance(node, ast.FunctionDef) and node.name.startswith("test_") for node in ast.walk(parsed))
    return f"[{count} tests](../../tests/simulators/effects/{path.name}): {says}"


if __name__ == "__main__":
    main(sys.argv[1:], Path(__file__).resolve().parents[1])
