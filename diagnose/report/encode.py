"""Curves and maps as short JSON that is safe inside an HTML page."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from ...simulators.errors import InvalidValueError

_FLOOR_POINTS = 800
_LARGEST = 1.79e308  # rounding a larger number would overflow


class RawJson(str):
    """Text that is JSON already."""


def peak_preserving_indices(y: np.ndarray, limit: int) -> np.ndarray:
    """Return which samples to draw so that every peak and every dip stays.

    The curve is cut into equal pieces; the lowest and the highest sample of each stay, and both ends.

    Parameters
    ----------
    y : numpy.ndarray, shape (samples,)
        May hold NaN; a piece of nothing but NaN keeps one of them.
    limit : int
        At most this many samples are kept (4 or more).

    Returns
    -------
    numpy.ndarray of int, shape (kept,)
        In rising order.
    """
    if y.size <= limit:
        return np.arange(y.size)
    size = math.ceil(y.size / ((limit - 2) // 2))
    rows = math.ceil(y.size / size)
    padded = np.full(rows * size, np.nan)
    padded[: y.size] = y
    pieces = padded.reshape(rows, size)
    usable = np.isfinite(pieces)
    low = np.where(usable, pieces, np.inf).argmin(axis=1)
    high = np.where(usable, pieces, -np.inf).argmax(axis=1)
    start = np.arange(rows) * size
    return np.unique(np.concatenate([start + low, start + high, [0, y.size - 1]]))


def numbers(values: np.ndarray, *, digits: int = 4) -> RawJson:
    """Return a JSON array of numbers rounded to this many significant digits; null where not finite."""
    flat = np.asarray(values, dtype=float).ravel()
    usable = np.abs(flat) < _LARGEST
    if usable.all():
        return RawJson("[" + (f"%.{digits}g," * flat.size % tuple(flat.tolist()))[:-1] + "]")
    words = (f"{value:.{digits}g}" if good else "null" for value, good in zip(flat.tolist(), usable, strict=True))
    return RawJson("[" + ",".join(words) + "]")


def encode_curve(
    x: np.ndarray,
    y: np.ndarray,
    *,
    limit: int,
    floor: np.ndarray | None = None,
    focus: float | None = None,
) -> dict[str, Any]:
    """Return a curve, thinned to at most ``limit`` points with its peaks kept, ready for ``to_json``.

    Parameters
    ----------
    x : numpy.ndarray, shape (samples,)
        In any unit.
    y : numpy.ndarray, shape (samples,)
        In any unit; NaN and infinity become gaps.
    limit : int
        Most points kept.
    floor : numpy.ndarray, shape (samples,), optional
        A smooth second curve over the same x; it is thinned evenly.
    focus : float, optional
        Up to this x the reader looks closely: that part gets most of the points.

    Returns
    -------
    dict
        ``total`` and ``shown`` samples; ``i`` (steps between kept indices) with ``x0`` and ``dx`` when x is
        evenly spaced, otherwise ``x``; ``y``; ``floor`` when given.

    Raises
    ------
    InvalidValueError
        When the arrays differ in length.
    """
    x, y = np.asarray(x, dtype=float).ravel(), np.asarray(y, dtype=float).ravel()
    if x.size != y.size or (floor is not None and np.size(floor) != y.size):
        sizes = f"x {x.size}, y {y.size}" + ("" if floor is None else f", noise floor {np.size(floor)}")
        raise InvalidValueError(f"Curve with {sizes} samples; allowed: the same number in each. Check the analysis.")
    keep = _focused_indices(x, y, limit, focus)
    coded = {"total": y.size, "shown": keep.size, "y": numbers(y[keep]), **_positions(x, keep)}
    if floor is not None:
        every = np.unique(np.linspace(0, y.size - 1, min(y.size, _FLOOR_POINTS)).astype(int))
        coded["floor"] = {"y": numbers(np.ravel(floor)[every]), **_positions(x, every)}
    return coded


def _focused_indices(x: np.ndarray, y: np.ndarray, limit: int, focus: float | None) -> np.ndarray:
    near = int(np.count_nonzero(x <= focus)) if focus is not None else 0
    if y.size <= limit or not 0 < near < y.size:
        return peak_preserving_indices(y, limit)
    first = peak_preserving_indices(y[:near], limit * 3 // 4)
    rest = peak_preserving_indices(y[near:], limit - first.size)
    return np.concatenate([first, near + rest])


def _positions(x: np.ndarray, keep: np.ndarray) -> dict[str, Any]:
    if x.size > 1 and np.isfinite(x[[0, -1]]).all():
        step = (x[-1] - x[0]) / (x.size - 1)
        if step > 0 and np.nanmax(np.abs(x - x[0] - step * np.arange(x.size))) <= 1e-3 * step:
            steps = np.diff(keep, prepend=0)
            return {
                "x0": float(x[0]),
                "dx": float(step),
                "i": RawJson("[" + ",".join(map(str, steps.tolist())) + "]"),
            }
    return {"x": numbers(x[keep], digits=8)}


def pool_map(levels: np.ndarray, rows: int, columns: int) -> tuple[np.ndarray, int, int]:
    """Return a map reduced to at most this size, each cell the highest of those it stands for.

    Returns
    -------
    numpy.ndarray, shape (<= rows, <= columns)
    int, int
        How many rows and columns of the input one cell stands for.
    """
    per_row, per_column = math.ceil(levels.shape[0] / rows), math.ceil(levels.shape[1] / columns)
    padding = [(0, -levels.shape[0] % per_row), (0, -levels.shape[1] % per_column)]
    padded = np.pad(np.where(np.isfinite(levels), levels, -np.inf), padding, constant_values=-np.inf)
    blocks = padded.reshape(padded.shape[0] // per_row, per_row, padded.shape[1] // per_column, per_column)
    return blocks.max(axis=(1, 3)), per_row, per_column


def to_json(value: Any) -> str:
    """Return compact JSON, null for NaN and infinity, with nothing in it that HTML could take for markup."""
    return _code(value)


def _code(value: Any) -> str:
    if isinstance(value, RawJson):
        return str(value)
    if isinstance(value, dict):
        return "{" + ",".join(f"{_quoted(str(key))}:{_code(item)}" for key, item in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ",".join(map(_code, value)) + "]"
    if isinstance(value, np.ndarray):
        return numbers(value)
    if isinstance(value, float | np.floating):
        return repr(float(value)) if math.isfinite(value) else "null"
    if isinstance(value, str):
        return _quoted(value)
    if isinstance(value, np.integer):
        return str(int(value))
    return json.dumps(value)


def _quoted(text: str) -> str:
    coded = json.dumps(text)
    return coded.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
