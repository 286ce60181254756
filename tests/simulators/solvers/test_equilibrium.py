"""Where a machine comes to rest: what is held finds its place, what nothing holds is not turned on and on."""

import numpy as np
import pytest
from rotorwise.simulators import test_rig
from rotorwise.simulators.effects.twice_line_force import TwiceLineForce
from rotorwise.simulators.solvers import equilibrium
from rotorwise.simulators.solvers.simulate import simulate_motion


def test_a_torque_on_a_free_shaft_ends_the_search_early(monkeypatch: pytest.MonkeyPatch) -> None:
    # Over one turn of the shaft the mean of a torque at 100 Hz is not nothing, and nothing holds the shaft's angle.
    steps = []
    once = equilibrium._shifted_inverse
    monkeypatch.setattr(equilibrium, "_shifted_inverse", lambda form, shift: steps.append(shift) or once(form, shift))
    how = {"duration_s": 0.05, "rate_hz": 3200.0, "settle_s": 0.0}
    pulled = test_rig.with_effects(TwiceLineForce(force_n=0.0, torque_n_m=1.0))
    (with_torque,) = simulate_motion([(pulled, 1260.0)], **how)
    assert 2 <= len(steps) <= 1 + equilibrium.STALLED_STEPS < equilibrium.MOST_STEPS / 2
    # Everything that is held has come to rest where it is without the torque, which turns nothing sideways.
    (without,) = simulate_motion([(test_rig, 1260.0)], **how)
    for probe in without.probes:
        if probe.quantity == "acceleration":
            alone = without.probe(probe.name)
            np.testing.assert_allclose(with_torque.probe(probe.name), alone, atol=1e-5 * np.abs(alone).max())
