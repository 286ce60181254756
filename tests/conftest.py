"""Settings of hypothesis; scripts in a process of their own, and one where compiled code finds no place to be kept."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable

import pytest
from hypothesis import HealthCheck, settings

# How long a test takes tells how busy the machine is. pytest's own limit of time holds for all.
settings.register_profile("shared machine", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("shared machine")

_NOWHERE = """
from numba.core import caching
for kind in (caching.CompileResultCacheImpl, caching.CodeLibraryCacheImpl):
    kind._locator_classes = []
import numba
try:
    numba.njit(cache=True)(lambda x: x)
except RuntimeError as problem:
    assert "cannot cache function" in str(problem)
else:
    raise SystemExit("numba found a place all the same: this shows nothing")
"""


@pytest.fixture
def printed_usually() -> Callable[[str], str]:
    """Return what tells what a script prints in a process of its own."""
    return _printed


@pytest.fixture
def printed_with_nothing_kept() -> Callable[[str], str]:
    """Return what tells what a script prints where numba has no place to keep what it compiled."""
    return lambda script: _printed(_NOWHERE + script)


def _printed(script: str) -> str:
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout
