"""`numba.njit` for computers on which compiled code can be kept, and for those on which it cannot."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba


def njit(*signature: Any, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return what compiles a function; it is kept on the disk where ``cache`` is asked for and there is a place.

    There is none where neither the installed package, nor the home, nor NUMBA_CACHE_DIR can be written to, as in many
    containers. Every process then compiles anew, which takes seconds.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        try:
            return numba.njit(*signature, **options)(function)
        except RuntimeError as problem:
            if "cannot cache function" not in str(problem):
                raise
            return numba.njit(*signature, **{**options, "cache": False})(function)

    return decorate
