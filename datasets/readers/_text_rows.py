"""Lines of text to numbers: NumPy for plain rows, pandas for rows with missing, odd or dated cells."""

from __future__ import annotations

import io
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import UnreadableFileError
from ._text_layout import TextLayout

#: Above this share of cells that are no numbers, a column is not a signal with a few bad cells.
_BAD_SHARE = 0.01


@dataclass(frozen=True)
class Rows:
    """Parsed rows.

    Attributes
    ----------
    values : numpy.ndarray, shape (rows, columns)
        float64; NaN where a cell is missing. A column of dates holds seconds.
    warnings : tuple of str
    """

    values: np.ndarray
    warnings: tuple[str, ...] = ()


def parse_rows(lines: list[str], layout: TextLayout, path: Path, *, first_row: int, is_last: bool) -> Rows:
    """Return the rows of some lines; a last line cut short is dropped with a warning.

    Raises
    ------
    UnreadableFileError
        When a column holds too many cells that are no numbers.
    """
    notes: list[str] = []
    if is_last and lines and _is_cut(lines, layout):
        lines = lines[:-1]
        notes.append("The last line is incomplete and was left out; the file may be cut off.")
    if not lines:
        return Rows(np.empty((0, layout.columns)), tuple(notes))
    if layout.decimal == ",":
        lines = "".join(lines).replace(",", ".").splitlines()
    if not layout.stamp_columns:
        try:
            values = np.loadtxt(
                lines,
                delimiter=layout.separator,
                usecols=range(layout.columns),
                ndmin=2,
                comments=None,
                quotechar='"',
            )
            return Rows(values, tuple(notes))
        except ValueError:
            pass  # a missing or odd cell somewhere: the tolerant parser finds out where
    values, found = _tolerant(lines, layout, path, first_row)
    return Rows(values, (*notes, *found))


def _is_cut(lines: list[str], layout: TextLayout) -> bool:
    cells = layout.split(lines[-1])
    if len(cells) < layout.columns:
        return True
    if len(lines) > 1 and lines[-1].endswith(("\n", "\r")):
        return False
    # Without a line end the last number may stop inside its exponent ("1.2e-"); a shorter number cannot be
    # told.
    text = cells[layout.columns - 1].replace(",", ".") if layout.decimal == "," else cells[layout.columns - 1]
    if layout.columns - 1 in layout.stamp_columns:
        return False
    before = layout.split(lines[-2])[-1:] if len(lines) > 1 else [""]
    try:
        float(text)
    except ValueError:
        return text != "" or before != [""]
    return False


def _tolerant(lines: list[str], layout: TextLayout, path: Path, first_row: int) -> tuple[np.ndarray, list[str]]:
    import pandas as pd

    # Every cell gets a column, so that a row with too many is no error of the parser; the spare ones are
    # dropped.
    width = max(layout.columns, *(len(layout.split(line)) for line in lines))
    text = "\n".join(line.rstrip("\r\n") for line in lines)
    try:
        frame = pd.read_csv(
            io.StringIO(text),
            sep=r"\s+" if layout.separator is None else layout.separator,
            header=None,
            names=list(range(width)),
            skip_blank_lines=True,
            skipinitialspace=True,
            index_col=False,
            low_memory=False,
        )
    except (ValueError, pd.errors.ParserError) as error:
        raise UnreadableFileError(f"{path}: rows cannot be parsed ({error}). Export the file again.") from error
    out = np.empty((len(frame), layout.columns))
    notes: list[str] = []
    for column in range(layout.columns):
        cells = frame[column]
        out[:, column] = (
            _seconds(cells)
            if column in layout.stamp_columns
            else np.asarray(pd.to_numeric(cells, errors="coerce"), dtype=float)
        )
        bad = np.flatnonzero(np.isnan(out[:, column]) & cells.notna().to_numpy())
        if bad.size > max(1, _BAD_SHARE * len(frame)):
            raise UnreadableFileError(
                f"{path}: column {column + 1} has {bad.size} cells of {len(frame)} that are no numbers "
                "(first in data row "
                f"{first_row + bad[0] + 1}: {str(cells.iloc[bad[0]])[:30]!r}). Export it again as numbers "
                "only."
            )
        if bad.size:
            notes.append(
                f"Column {column + 1}: {bad.size} cells are no numbers (first in data row "
                f"{first_row + bad[0] + 1}); read as missing."
            )
    return out, notes


def _seconds(cells) -> np.ndarray:
    """Return seconds of a column of dates or times of day."""
    import pandas as pd

    text = cells.astype(str).str.strip()
    with warnings.catch_warnings():
        # pandas warns when it must look at each stamp alone; slow, but right.
        warnings.simplefilter("ignore")
        if text.iloc[0][:5].count(":") and not text.iloc[0][:4].isdigit():
            return pd.to_timedelta(text, errors="coerce").dt.total_seconds().to_numpy(dtype=float)
        stamps = pd.to_datetime(text, errors="coerce", format="mixed", utc=True)
    # Counted from a recent day, so that microseconds survive in a float.
    origin = pd.Timestamp("2020-01-01", tz="UTC")
    return (stamps - origin).dt.total_seconds().to_numpy(dtype=float)
