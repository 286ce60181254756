"""Write the table of the catalogue: ``python -m rotorwise.simulators.effect_table [--tests] [EFFECT ...]``.

Without names all effects are computed anew (some minutes), with names only those; the other rows stay. For every effect
a picture (spectrum with and without it, `docs/effects/NAME.svg`), the lines that it adds, how they grow with
speed and load, how far they rise in the picture, and its test with the figure that a run of it gives. ``--tests``
renews only the tests' cells (some seconds).
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Sequence
from pathlib import Path

from .effect import Effect, Line, effect_catalogue
from .effect_exhibit import SPEED_RPM, Exhibit, exhibit, picture
from .effect_figures import cell_of_test, measured_figures
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
the picture (the floor, for an effect without lines of its own). *Test* begins with its figure: how far the effect is
off theory or literature in the strongest of its tests, in the worst case of that, as a share of the largest expected
value where no unit stands beside it; "to rounding" is less than 1e-12.
"""


def main(names: Sequence[str], root: Path, *, tests_only: bool = False) -> None:
    """Write the pictures and rows of some effects, or of all when none is named, into a checkout.

    With ``tests_only`` rows that are there keep all but the cell of their test. Raises `InvalidValueError` for an
    unknown name, `FigureError` when a test fails; nothing is written then.
    """
    catalogue, machines = effect_catalogue(), _ordered(machine_catalogue())
    for name in names:
        if name not in catalogue:
            raise InvalidValueError(f"Effect {name!r} is unknown; allowed: {', '.join(catalogue)}. Correct the name.")
    readme = root / "simulators" / "effects" / "README.md"
    kept = rows_of(readme.read_text(encoding="utf-8")) if readme.exists() else {}
    anew = [name for name in catalogue if not names or name in names or name not in kept]
    tests = root / "tests" / "simulators" / "effects"
    figures = measured_figures(anew, tests)
    rows: dict[str, list[str]] = {stage: [] for stage in STAGE_TITLES}
    for name, effect in catalogue.items():
        test = cell_of_test(name, tests, figures.get(name))
        if name not in anew:
            line = kept[name]
        elif tests_only and name in kept:
            line = f"{kept[name].rpartition(' | ')[0]} | {test} |"
        else:
            line = row(effect, _shown(effect, machines, root / "docs" / "effects"), test)
        rows[effect.STAGE].append(line)
    readme.write_text(table(rows), encoding="utf-8")


def _shown(effect: type[Effect], machines: dict[str, Machine], pictures: Path) -> Exhibit | None:
    """Compute an effect on the first machine that shows it and write its picture."""
    print(effect.NAME, file=sys.stderr, flush=True)
    shown = exhibit(effect, machines)
    if shown is not None:
        pictures.mkdir(parents=True, exist_ok=True)
        (pictures / f"{effect.NAME}.svg").write_text(picture(shown), encoding="utf-8")
    return shown


def rows_of(text: str) -> dict[str, str]:
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


def row(effect: type[Effect], shown: Exhibit | None, test: str) -> str:
    """Return one row of the table, ``test`` being its last cell."""
    name = effect.NAME
    if shown is None:
        seen, lines, rise = "no machine shows it", "", ""
    else:
        seen = f"![{name} on {shown.machine}](../../docs/effects/{name}.svg)"
        lines, rise = lines_cell(shown.lines), rise_cell(shown)
    cells = [f"**[{name}]({name}.py)** {effect.MEANING}", seen, lines, rise]
    return "| " + " | ".join([*(cell.replace("|", "/") for cell in cells), test]) + " |"


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


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m rotorwise.simulators.effect_table")
    parser.add_argument("names", nargs="*", metavar="EFFECT", help="effects to renew; all when none is named")
    parser.add_argument("--tests", action="store_true", help="renew only the tests' cells")
    return parser.parse_args()


if __name__ == "__main__":
    asked = _arguments()
    main(asked.names, Path(__file__).resolve().parents[1], tests_only=asked.tests)
