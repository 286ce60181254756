"""A measurement keeps what the solver says of its own accuracy."""

import numpy as np
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.sensor_chain import SensorChain

ROTOR = find_machine("rigid_coupling")
OPTIONS = {"speed_rpm": 1200.0, "duration_s": 0.2, "rate_hz": 500.0, "settle_s": 0.1}


def test_step_and_errors_are_those_of_the_run():
    run = ROTOR.simulate(estimate_error=True, **OPTIONS)
    measured = SensorChain().measure(ROTOR, estimate_error=True, **OPTIONS)
    assert measured.step_s == run.step_s
    assert measured.errors is not None
    assert np.array_equal(measured.errors, run.errors)
    assert SensorChain().measure(ROTOR, **OPTIONS).errors is None
