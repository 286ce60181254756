"""Coupling misalignment on the magnetic-bearing rotor: linear, turning, and with the lines it announces."""

import math

import numpy as np
import pytest
from rotorwise.simulators.effects import CouplingMisalignment, CouplingStiffnessHarmonics
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

RPM = 4000.0
MACHINE = find_machine("amb_rotor")
CONSTANT = MACHINE.with_parameters(harmonic_1=0.0, harmonic_2=0.0, harmonic_3=0.0)


def change(machine, effect):
    """Return what the effect adds to the order amplitudes."""
    with_it = harmonic_balance(machine.with_effects(effect), speed_rpm=RPM)
    return with_it.amplitudes - harmonic_balance(machine, speed_rpm=RPM).amplitudes


def purely(**values):
    return CouplingMisalignment(**{"offset_m": 0.0, "angle_rad": 0.0, **values})


def test_zero_strength_changes_nothing():
    # A core that is asked for the first time is solved, later ones inverted: other rounding.
    harmonic_balance(MACHINE, speed_rpm=RPM)
    assert not change(MACHINE, CouplingMisalignment().at_zero()).any()


def test_response_is_linear_in_offset_and_angle():
    both = change(MACHINE, CouplingMisalignment(offset_m=6e-4, angle_rad=0.03))
    offset, angle = change(MACHINE, purely(offset_m=2e-4)), change(MACHINE, purely(angle_rad=0.01))
    np.testing.assert_allclose(both, 3 * offset + 3 * angle, atol=1e-10 * np.abs(both).max())


def test_phase_turns_the_response_of_an_isotropic_coupling():
    straight, turned = (
        change(CONSTANT, purely(offset_m=2e-4)),
        change(CONSTANT, purely(offset_m=2e-4, offset_phase_rad=1)),
    )
    np.testing.assert_allclose(turned, straight * np.exp(1j), atol=1e-10 * np.abs(straight).max())
    # Forward whirl: y follows x by a quarter turn.
    np.testing.assert_allclose(straight[1::2, 1], -1j * straight[::2, 1], rtol=1e-9)


@pytest.mark.parametrize("strength", [{"offset_m": 1e-4}, {"angle_rad": 1e-3}])
@pytest.mark.parametrize("machine", [MACHINE, CONSTANT, MACHINE.with_parameters(harmonic_1=0.0)])
def test_the_lines_announced_are_the_lines_that_come(machine, strength):
    effect = purely(**strength)
    announced = {round(line.order) for line in effect.signature(machine)}
    added = np.abs(change(machine, effect)).max(axis=0)
    # Orders beyond those need the coupling twice; it carries a tenth of the rotor's stiffness.
    shown = {m for m in range(1, 9) if added[m] > 1e-3 * added.max()}
    assert shown <= announced | {5}
    assert all(added[m] > 1e-5 * added.max() for m in announced)


def test_force_does_not_grow_with_speed_as_unbalance_does(figure):
    """Well below the first mode, at 300 and 600 rpm, the response to an offset stays; unbalance gives four times."""
    amplitude = []
    for rpm in (300.0, 600.0):
        base = harmonic_balance(CONSTANT, speed_rpm=rpm).amplitudes
        moved = harmonic_balance(CONSTANT.with_effects(purely(offset_m=2e-4)), speed_rpm=rpm).amplitudes
        amplitude.append([abs(base[0, 1]), abs(moved[0, 1] - base[0, 1])])
    unbalance, misalignment = np.array(amplitude).T
    assert unbalance[1] / unbalance[0] == pytest.approx(4, rel=0.15)
    assert misalignment[1] / misalignment[0] == pytest.approx(1, rel=0.3)
    figure("Force the same at 300 and 600 rpm, well below resonance", misalignment[1] / misalignment[0], 1.0)


@pytest.mark.parametrize("value", [-1e-6, 0.1, math.nan])
def test_offsets_out_of_bounds_are_refused(value):
    with pytest.raises(InvalidValueError, match="offset_m"):
        CouplingMisalignment(offset_m=value)


@pytest.mark.parametrize("order", [1, 2, 3])
@pytest.mark.parametrize("strength", [{"offset_m": 1e-4}, {"angle_rad": 1e-3}])
def test_the_lines_announced_follow_harmonics_that_another_effect_adds(order, strength):
    harmonics = CouplingStiffnessHarmonics().at_zero()
    varied = {f"{direction}_{order}": 0.1 for direction in ("x", "y", "angle_x", "angle_y")}
    machine = CONSTANT.with_effects(harmonics.with_values(**varied))
    effect = purely(**strength)
    alone, together = ({round(line.order) for line in effect.signature(m)} for m in (CONSTANT, machine))
    assert (alone, together) == ({1}, {1, order - 1, order + 1} - {0})
    # The effect may be on the machine already.
    assert effect.signature(machine.with_effects(effect)) == effect.signature(machine)
    added = np.abs(change(machine, effect)).max(axis=0)
    new = together - alone
    assert all(added[m] > 1e-3 * added.max() for m in together)
    assert all(np.abs(change(CONSTANT, effect)).max(axis=0)[m] < 1e-9 * added.max() for m in new)
    shown = {m for m in range(1, 9) if added[m] > 0.03 * added.max()}
    assert shown <= together
