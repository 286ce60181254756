"""The rows of the zone tables, and finding one by name."""

from __future__ import annotations

import math
import tomllib
from dataclasses import dataclass
from functools import cache
from importlib import resources
from itertools import pairwise
from typing import Any

from ...simulators.errors import InvalidValueError

#: Factor from each table unit to SI; ``C_min`` rows are scaled with the clearance first.
TABLE_UNIT_TO_SI = {"mm/s": 1e-3, "um": 1e-6, "m/s2": 1.0}


@dataclass(frozen=True)
class ZoneRow:
    """One row of a zone table: one quantity of one machine class.

    Attributes
    ----------
    id : str
        Name to choose it by; a velocity and a displacement row may share it, and then the worse zone counts.
    standard, table : str
    sensor : str
        ``"housing"`` or ``"shaft"`` (a displacement probe that looks at the shaft).
    quantity, detector : str
        What is measured, and ``"rms"``, ``"peak-to-peak"`` or ``"zero-to-max"``.
    unit : str
        Of ``boundaries``, a key of ``TABLE_UNIT_TO_SI``, or ``"C_min"``.
    boundaries : tuple of float
        A/B, B/C and C/D, or what ``law`` makes them from.
    source, confidence : str
    verified : bool
    band_hz : tuple of float or None
        Band of an rms; None for the whole signal.
    slow_low_hz : float or None
        Lower edge below 600 r/min.
    mounting : str or None
    power_kw, speed_rpm : tuple of float or None
        Ranges that the row holds for.
    law : str
        ``"constant"``; ``"over_root_speed"`` (divide by the root of r/min); ``"api_limit"``;
        ``"fraction_of_clearance"``.
    note : str
    """

    id: str
    standard: str
    table: str
    sensor: str
    quantity: str
    detector: str
    unit: str
    boundaries: tuple[float, ...]
    source: str
    confidence: str
    verified: bool
    band_hz: tuple[float, float] | None = None
    slow_low_hz: float | None = None
    mounting: str | None = None
    power_kw: tuple[float, float] | None = None
    speed_rpm: tuple[float, float] | None = None
    law: str = "constant"
    note: str = ""

    @property
    def needs_speed(self) -> bool:
        """Whether the boundaries cannot be stated without the shaft speed."""
        return self.speed_rpm is not None or self.law in ("over_root_speed", "api_limit")

    def holds_at(self, speed_rpm: float | None) -> bool:
        """Whether the row covers this speed; a row without a range covers all."""
        if self.speed_rpm is None:
            return True
        return speed_rpm is not None and self.speed_rpm[0] <= speed_rpm <= self.speed_rpm[1]

    def limits(self, *, speed_rpm: float | None = None, clearance_m: float | None = None) -> tuple[float, ...]:
        """Return the boundaries in ``unit`` (in um for a fraction of the clearance).

        over_root_speed: b / sqrt(n). api_limit: min(b, b sqrt(12000 / n)). fraction_of_clearance: b C_min.

        Raises
        ------
        InvalidValueError
            When the law needs a speed or a clearance and none is given.

        Examples
        --------
        >>> shaft = next(row for row in load_rows() if row.id == "iso20816-3-shaft")
        >>> [round(limit, 6) for limit in shaft.limits(speed_rpm=3600.0)]
        [80.0, 150.0, 220.0]
        """
        if self.law == "fraction_of_clearance":
            if clearance_m is None or not clearance_m > 0:
                raise InvalidValueError(
                    f"Smallest radial clearance {clearance_m} m; table {self.id} allows: above 0. "
                    "Give magnetic_bearing_clearance_m in the nameplate."
                )
            return tuple(fraction * clearance_m * 1e6 for fraction in self.boundaries)
        if self.law == "constant":
            return self.boundaries
        if speed_rpm is None or not speed_rpm > 0:
            raise InvalidValueError(f"Speed {speed_rpm} r/min; table {self.id} allows: above 0. Pass --speed.")
        if self.law == "over_root_speed":
            return tuple(number / math.sqrt(speed_rpm) for number in self.boundaries)
        return tuple(min(number, number * math.sqrt(12000.0 / speed_rpm)) for number in self.boundaries)


_LAWS = ("constant", "over_root_speed", "api_limit", "fraction_of_clearance")


@cache
def load_rows() -> tuple[ZoneRow, ...]:
    """Return every row of every shipped table.

    Raises
    ------
    InvalidValueError
        When a row breaks the rules of ``ZoneRow``; the message names it.
    """
    rows = []
    for file in sorted(resources.files(__package__ or __name__).iterdir(), key=lambda entry: entry.name):
        if file.name.endswith(".toml"):
            content = tomllib.loads(file.read_text(encoding="utf-8"))
            rows += [_row(content["standard"], raw) for raw in content["row"]]
    return tuple(rows)


def _row(standard: str, raw: dict[str, Any]) -> ZoneRow:
    fields: dict[str, Any] = {key: tuple(value) if isinstance(value, list) else value for key, value in raw.items()}
    row = ZoneRow(standard=standard, **fields)
    rising = all(low < high for low, high in pairwise(row.boundaries))
    if not rising or row.law not in _LAWS or row.unit not in (*TABLE_UNIT_TO_SI, "C_min"):
        raise InvalidValueError(
            f"Zone row {row.id!r}: boundaries {row.boundaries}, unit {row.unit!r}, law {row.law!r}; allowed: "
            f"rising boundaries, units {', '.join(TABLE_UNIT_TO_SI)}, C_min, laws {', '.join(_LAWS)}. "
            "Correct the file."
        )
    return row


def available_tables() -> tuple[str, ...]:
    """Return the names of the zone tables, sorted.

    Examples
    --------
    >>> "iso20816-3-group2-rigid" in available_tables()
    True
    """
    return tuple(sorted({row.id for row in load_rows()}))


@dataclass(frozen=True)
class ChosenTable:
    """Rows to judge by, and what was assumed to get to them."""

    rows: tuple[ZoneRow, ...]
    assumption: str = ""


def find_table(name: str, *, mounting: str | None = None, power_kw: float | None = None) -> ChosenTable:
    """Return the table of this name; a shorter name is completed with mounting and power.

    ``"iso20816-3-group2"`` becomes ``-rigid`` or ``-flexible``, ``"iso10816-7-category1"`` becomes the one
    for the power. Without a mounting the rigid table is taken, the stricter one, and the assumption is
    stated.

    Raises
    ------
    InvalidValueError
        When no table has the name, or the short name stays ambiguous.
    """
    wanted = _key(name)
    exact = tuple(row for row in load_rows() if _key(row.id) == wanted)
    if exact:
        return ChosenTable(exact)
    longer = [row for row in load_rows() if wanted and _key(row.id).startswith(wanted)]
    assumption = ""
    if longer and all(row.mounting for row in longer):
        assumption = "" if mounting else "mounting not given: rigid assumed"
        longer = [row for row in longer if row.mounting == (mounting or "rigid")]
    if power_kw is not None:
        longer = [row for row in longer if row.power_kw is None or row.power_kw[0] < power_kw <= row.power_kw[1]]
    if len({row.id for row in longer}) == 1:
        return ChosenTable(tuple(longer), assumption)
    choices = sorted({row.id for row in longer}) or available_tables()
    raise InvalidValueError(
        f"Severity table {name!r} is not {'a single table' if longer else 'known'}{_mix_up(wanted)}. "
        f"Allowed: {', '.join(choices)}. Pass one of them with --severity-table."
    )


def _key(name: str) -> str:
    """Return a table name in lower case, without signs, under the standard's present number."""
    bare = "".join(character for character in name.lower() if character.isalnum())
    return bare.replace("iso108163", "iso208163").replace("iso79193", "iso208163shaft", 1)


def _mix_up(wanted: str) -> str:
    """Return a hint where classes of one standard were asked of another."""
    if "class" in wanted and not wanted.startswith(("iso108161", "iso208169")):
        return ": classes I to IV are ISO 10816-1 (iso10816-1-class2), not the groups of ISO 20816-3"
    if "group" in wanted and not wanted.startswith("iso208163"):
        return ": groups 1 and 2 are ISO 20816-3 (iso20816-3-group2), not the classes of ISO 10816-1"
    return ""
