"""Machines balanced side by side: each as if it were alone, and one without a periodic motion spoils no other."""

import numpy as np
import pytest
from rotorwise.simulators.effect import make_effect
from rotorwise.simulators.errors import RotorwiseError
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance_at_speeds, harmonic_balances

SPEEDS_RPM = (700.0, 1400.0, 1900.0)


@pytest.mark.parametrize("name", ["rigid_coupling", "amb_rotor", "test_rig"])
def test_each_machine_moves_as_if_it_were_alone(name) -> None:
    machine = find_machine(name)
    effects = [make_effect("rub", {}), make_effect("unbalance", {})]
    machines = [machine, machine.with_effects(effects[1]), *(machine.with_effects(effect) for effect in effects)]
    cases = [(one, SPEEDS_RPM[: 2 + number % 2]) for number, one in enumerate(machines)]
    together = harmonic_balances(cases)
    for (one, speeds), found in zip(cases, together, strict=True):
        assert not isinstance(found, RotorwiseError)
        alone = harmonic_balance_at_speeds(one, speeds)
        for own, other in zip(found, alone, strict=True):
            scale = np.abs(other.amplitudes).max()
            assert own.amplitudes == pytest.approx(other.amplitudes, rel=0, abs=1e-12 * scale)


def test_a_machine_without_a_periodic_motion_fails_alone() -> None:
    machine = find_machine("rigid_coupling")
    whirling = machine.with_effects(make_effect("oil_whirl", {}))
    supplied = machine.with_effects(make_effect("twice_line_force", {}))
    found = harmonic_balances([(machine, SPEEDS_RPM), (whirling, SPEEDS_RPM), (supplied, SPEEDS_RPM)])
    assert len(found[0]) == len(SPEEDS_RPM)
    for one, words in ((found[1], "can excite"), (found[2], "does not repeat")):
        # An error that is kept must not keep the arrays of all the frames that it came through.
        assert isinstance(one, RotorwiseError)
        assert one.__traceback__ is None
        with pytest.raises(RotorwiseError, match=words):
            raise one


@pytest.mark.parametrize("loss", [0.9, 0.984])
def test_a_support_that_has_lost_nearly_all_of_its_stiffness_is_balanced_as_it_moves(loss) -> None:
    # From rest Newton's method finds no balance here: the contact opens in one step and closes in the next.
    machine = find_machine("rigid_coupling").with_effects(
        make_effect("looseness", {"loss": loss, "hold": 0.053, "rounding": 0.2}, at="support_2")
    )
    speeds_rpm = SPEEDS_RPM[1:]
    (balanced,) = harmonic_balances([(machine, speeds_rpm)], harmonics=8)
    assert not isinstance(balanced, RotorwiseError)
    for motion, speed_rpm in zip(balanced, speeds_rpm, strict=True):
        run = machine.simulate(speed_rpm=speed_rpm, duration_s=6.0, rate_hz=1000.0, settle_s=60.0)
        turns = run.phase_rad / (2 * np.pi)
        whole = turns < np.floor(turns[-1])
        found = 2 * run.signals[:, whole] @ np.exp(-2j * np.pi * np.outer(turns[whole], (1, 2, 3))) / whole.sum()
        assert np.abs(found - motion.amplitudes[:, 1:4]).max() < 0.02 * np.abs(found).max()
