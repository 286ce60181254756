"""A contact that opens and closes: penetration with a rounded corner."""

from __future__ import annotations

from ..compiled_code import njit


@njit(cache=True, error_model="numpy", inline="always")
def rounded_ramp(depth, width):  # type: ignore[no-untyped-def]
    """Return max(depth, 0) with its corner rounded over -width .. width, twice continuously differentiable.

    Surfaces are rough, so a contact stiffens over the height of its roughness; and integration keeps its order.
    Outside the corner the result is exactly 0 or ``depth``: with s = depth / width inside,

        width (3 + 8 s + 6 s^2 - s^4) / 16.
    """
    if depth <= -width:
        return 0.0
    if depth >= width:
        return depth
    s = depth / width
    square = s * s
    return width * (3.0 + 8.0 * s + square * (6.0 - square)) / 16.0
