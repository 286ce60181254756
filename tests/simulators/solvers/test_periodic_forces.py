"""Whether forces repeat with the shaft is told before all of them are computed."""

import numpy as np
import pytest
from rotorwise.simulators.effects import TorqueRipple
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers import periodic_forces as module
from rotorwise.simulators.solvers.periodic_forces import FEW, MANY, periodic_forces


@pytest.mark.parametrize("order", [1.0, float(FEW), 2.0 * FEW, 5.0 * FEW])
def test_whole_orders_repeat_whatever_the_instants_of_the_first_look(order):
    machine = find_machine("rigid_coupling").with_effects(TorqueRipple(torque_n_m=3.0, order=order))
    found = periodic_forces([machine.system(speed_rpm=1500.0)], [50 * np.pi], MANY, 1)
    assert max(np.abs(own).max(initial=0.0) for own in found.signals) > 1.0


def test_what_never_repeats_is_told_from_a_few_instants(monkeypatch):
    looked_at = []
    usual = module._signals

    def watched(systems, speeds_rad_s, parameters, instants, *rest):
        looked_at.append(instants)
        return usual(systems, speeds_rad_s, parameters, instants, *rest)

    monkeypatch.setattr(module, "_signals", watched)
    gearbox = find_machine("gearbox")
    with pytest.raises(InvalidValueError, match="does not repeat"):
        periodic_forces([gearbox.system(speed_rpm=1500.0)], [50 * np.pi], MANY, 1)
    assert looked_at == [FEW]
