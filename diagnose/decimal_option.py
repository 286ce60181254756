"""Options that take a number: what is no number is repeated and answered with what to write."""

from __future__ import annotations

import re
from typing import Any

import typer


def decimal_option(*names: str, text: str, value: str) -> Any:
    """Return a typer option of a floating-point number that shows no default; ``value`` is its name in the help."""
    return typer.Option(*names, help=text, metavar=value, show_default=False, parser=decimal)


def decimal(text: str | float) -> float:
    """Return a number; nan and infinity pass, as their bounds are the command's business.

    Raises
    ------
    typer.BadParameter
        For text that is no number, such as one with a decimal comma or a unit.

    Examples
    --------
    >>> decimal("0.5")
    0.5
    """
    try:
        return float(text)
    except ValueError:
        words = str(text).strip()
    remedy = "Write 0.5, for example."
    if re.fullmatch(r"[-+]?\d*,\d+(e[-+]?\d+)?", words):
        remedy = f"Write {words.replace(',', '.')}."
    raise typer.BadParameter(f"{words!r}; allowed: a number with a decimal point and without unit. {remedy}")
