"""The figure of a test: how close an effect came to theory or literature, for the table of the catalogue."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import ArrayLike

#: A smaller share of the expected value is rounding.
ROUNDING = 1e-12
#: From here a share is easier to read in percent.
PERCENT = 1e-4


@pytest.fixture
def figure(record_property: Callable[[str, object], None]) -> Callable[..., None]:
    """Return what records the figure of a test; `simulators/effect_figures.py` reads it.

    ``figure("1X against m e omega^2", found, expected)`` records the largest deviation as a share of the largest
    expected value; with ``off="Hz"`` the deviation itself in that unit. ``figure("whirl", reads="0.447X where 0.40 to
    0.48X is published")`` records a text; the number in it has to come from the result, and the test has one case only.
    A call for each of several cases is right: the table shows the worst.
    """

    def record(
        what: str, found: ArrayLike | None = None, expected: ArrayLike | None = None, *, off: str = "", reads: str = ""
    ) -> None:
        says = reads or deviation(found, expected, unit=off)
        record_property("figure", f"{what}: {says}".replace("e-0", "e-"))

    return record


def deviation(found: ArrayLike | None, expected: ArrayLike | None, *, unit: str = "") -> str:
    """Return in words how far arrays, real or complex, are off at most."""
    given = np.asarray(expected)
    scale = float(np.abs(given).max())
    assert scale > 0, "what is expected is zero everywhere: a share of it says nothing"
    size = float(np.abs(np.asarray(found) - given).max())
    if size < ROUNDING * scale:
        return "to rounding"
    if unit:
        return f"{_one_digit(size)} {unit} off"
    share = size / scale
    return f"{_one_digit(100 * share)} % off" if share >= PERCENT else f"{_one_digit(share)} off"


def _one_digit(value: float) -> str:
    return f"{float(f'{value:.0e}'):g}"
