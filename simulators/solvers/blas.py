"""Small matrices and several BLAS threads: the threads wait for each other longer than they compute.

On a loaded two-core machine a 120 x 120 eigenvalue problem took 60 times its single-thread time.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar

_Arguments = ParamSpec("_Arguments")
_Result = TypeVar("_Result")


@functools.cache
def _controller() -> Any:
    # Both numpy and scipy bring a BLAS; each must be loaded to be found.
    import numpy as np
    import scipy.linalg
    from threadpoolctl import ThreadpoolController

    del np, scipy
    return ThreadpoolController()


def single_blas_thread(function: Callable[_Arguments, _Result]) -> Callable[_Arguments, _Result]:
    """Return the function, run with one BLAS thread; the number before is restored afterwards."""

    @functools.wraps(function)
    def limited(*arguments: _Arguments.args, **options: _Arguments.kwargs) -> _Result:
        with _controller().limit(limits=1, user_api="blas"):
            return function(*arguments, **options)

    return limited
