"""Options that ``rotorwise orders``, ``envelope`` and ``sidebands`` share. Imports nothing heavy."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..simulators.errors import InvalidValueError
from .cli_options import option

if TYPE_CHECKING:
    from ..datasets.metadata import Metadata

File = Annotated[Path, typer.Argument(help="Recording.", metavar="FILE", show_default=False)]
SpeedRange = Annotated[
    str | None,
    option(
        "--speed-range", value="LOW-HIGH", text="Speeds in rpm to look for, for a run-up without a tacho: 600-3000."
    ),
]
Start = Annotated[float, option("--start", value="S", text="Leave out what is before, in s from the beginning.")]
Stop = Annotated[float | None, option("--stop", value="S", text="Leave out what is after.")]
Force = Annotated[bool, option("--force", text="Replace an earlier report.")]
AsJson = Annotated[bool, option("--json", text="Print JSON.")]


@dataclass(frozen=True)
class Request:
    """What the user asked for, whatever the command."""

    file: Path
    metadata: Metadata
    sidecar: Path | None
    report: Path | None
    as_json: bool
    force: bool
    start_s: float = 0.0
    stop_s: float | None = None

    def __post_init__(self) -> None:
        stop = float("inf") if self.stop_s is None else self.stop_s
        if not 0 <= self.start_s < stop or not self.start_s < float("inf"):
            raise InvalidValueError(
                f"Part from {self.start_s:g} to {stop:g} s; allowed: 0 or more, the start before the stop. Correct "
                "--start or --stop."
            )

    @property
    def is_part(self) -> bool:
        """Whether something of the record is to be left out."""
        return self.start_s > 0 or self.stop_s is not None


def speed_range_hz(text: str | None) -> tuple[float, float] | None:
    """Return a range given as ``600-3000`` rpm, in Hz.

    Raises
    ------
    InvalidValueError
        For anything else.
    """
    if text is None:
        return None
    parts = text.replace("\u2013", "-").split("-")
    try:
        low, high = (float(part) / 60 for part in parts)
    except ValueError:
        low = high = float("nan")
    if not 0 < low < high < float("inf"):
        raise InvalidValueError(f"Range {text!r}; allowed: two numbers, the lower one first. Write 600-3000.")
    return low, high
