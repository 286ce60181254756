"""The gain is that of the machine that is written: the effects that are named, not those that came closest."""

from types import SimpleNamespace
from typing import Any

import pytest
from rotorwise.diagnose.gap.gain import measured_gain
from rotorwise.diagnose.gap.posterior import Posterior
from rotorwise.diagnose.gap.refine import nothing
from rotorwise.diagnose.gap.unknown_force import unexplained

from .test_joint_fit import _case


@pytest.mark.parametrize(("named", "shares"), [(True, (0.98, 0.02)), (False, (0.1, 0.9))])
def test_an_effect_that_only_came_closest_is_no_gain(named, shares):
    fit, problem = _case(1000.0)
    compared = problem.plain()
    probabilities = dict(zip([fit.names, ("unknown",)], shares, strict=True))
    posterior = Posterior(compared, nothing(compared), (fit,), unexplained(compared, ()), probabilities, 1.0)
    every = tuple(range(len(problem.lines.conditions)))
    prepared: Any = SimpleNamespace(
        problem=lambda _: problem,
        held_out=(),
        fitted=every,
        measured=problem.lines,
        by_lines=None,
    )
    found = measured_gain(problem.baseline.machine, prepared, posterior)
    assert found.calibration_only_db == pytest.approx(0.0)
    if named:
        assert found.held_out_db > 10
    else:
        assert found.held_out_db == pytest.approx(found.calibration_only_db)
