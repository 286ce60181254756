"""Compiled functions on a computer that has no place to keep them."""

from __future__ import annotations

from collections.abc import Callable

import numba
import pytest
from rotorwise.simulators.compiled_code import njit

_SIMULATE = """
import numpy as np
from rotorwise.simulators import amb_rotor, effects
for machine in (amb_rotor, amb_rotor.with_effects(effects.Rub())):
    print(np.abs(machine.simulate(speed_rpm=1800, duration_s=0.05, rate_hz=2000).signals).max())
"""


@pytest.mark.slow
def test_a_simulation_runs_where_nothing_can_be_kept(
    printed_usually: Callable[[str], str], printed_with_nothing_kept: Callable[[str], str]
) -> None:
    usual = printed_usually(_SIMULATE)
    assert printed_with_nothing_kept(_SIMULATE) == usual
    assert all(float(line) > 0 for line in usual.split())


def test_other_errors_of_the_compiler_are_not_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_signature: object, **_options: object) -> None:
        raise RuntimeError("no memory")

    monkeypatch.setattr(numba, "njit", refuse)
    with pytest.raises(RuntimeError, match="no memory"):
        njit(cache=True)(lambda x: x)
