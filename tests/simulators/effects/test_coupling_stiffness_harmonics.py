"""Stiffness that varies within a revolution, on the magnetic-bearing rotor."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects import CouplingMisalignment, CouplingStiffnessHarmonics
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

RPM = 4000.0
MACHINE = find_machine("amb_rotor")
CONSTANT = MACHINE.with_parameters(harmonic_1=0.0, harmonic_2=0.0, harmonic_3=0.0)
NONE = CouplingStiffnessHarmonics().at_zero()


def amplitudes(machine, *effects):
    return harmonic_balance(machine.with_effects(*effects), speed_rpm=RPM).amplitudes


def test_zero_strength_changes_nothing():
    np.testing.assert_array_equal(amplitudes(MACHINE, NONE), amplitudes(MACHINE))


def test_effect_and_machine_parameters_mean_the_same():
    values = {f"{d}_{n}": v for d in ("x", "y", "angle_x", "angle_y") for n, v in ((1, 0.3), (2, 0.2), (3, 0.05))}
    by_effect = amplitudes(CONSTANT, NONE.with_values(**values))
    np.testing.assert_allclose(by_effect, amplitudes(MACHINE), atol=1e-12 * np.abs(by_effect).max())


@pytest.mark.parametrize("order", [1, 2, 3])
def test_harmonic_n_makes_n_plus_1_of_unbalance(order):
    effect = NONE.with_values(**{f"x_{order}": 0.05})
    (line,) = effect.signature(CONSTANT)
    added = np.abs(amplitudes(CONSTANT, effect)[0])
    assert line.order == order + 1
    strongest = {m for m in range(2, 9) if added[m] > 0.05 * added[2:].max()}
    assert strongest <= {order - 1, order + 1}
    assert order + 1 in strongest


def test_y_harmonics_leave_x_alone_but_for_the_gyroscopic_coupling():
    motion = amplitudes(CONSTANT, NONE.with_values(y_2=0.05))
    assert np.abs(motion[::2, 3]).max() < 0.1 * np.abs(motion[1::2, 3]).max()
    assert np.abs(motion[::2, 3]).max() > 0


@settings(max_examples=10, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.floats(-3, 3))
def test_turning_the_coupling_is_turning_everything_else_back(figure, angle):
    """Counting the shaft angle from the coupling's mark instead turns unbalance and misalignment by -angle."""
    harmonics = NONE.with_values(x_1=0.2, y_2=0.1, angle_x_1=0.3)
    offset = CouplingMisalignment(offset_m=1e-4, angle_rad=0.0)
    turned = amplitudes(CONSTANT, harmonics.with_values(angle_rad=angle), offset)
    from_mark = amplitudes(
        CONSTANT.with_parameters(unbalance_angle_rad=angle), harmonics, offset.with_values(offset_phase_rad=angle)
    )
    orders = np.arange(turned.shape[1])
    np.testing.assert_allclose(turned, from_mark * np.exp(-1j * orders * angle), atol=1e-10 * np.abs(turned).max())
    expected = from_mark * np.exp(-1j * orders * angle)
    figure("All orders, coupling turned, against all else turned back", turned, expected)


def test_cross_terms_with_misalignment_arise_without_either_knowing_the_other():
    harmonics, offset = NONE.with_values(x_2=0.1), CouplingMisalignment(offset_m=2e-4, angle_rad=0.0)
    base = amplitudes(CONSTANT)
    alone = amplitudes(CONSTANT, harmonics) + amplitudes(CONSTANT, offset) - 2 * base
    both = amplitudes(CONSTANT, harmonics, offset) - base
    assert abs(both[0, 3]) > 2 * abs(alone[0, 3])
    swapped = amplitudes(CONSTANT, offset, harmonics) - base
    np.testing.assert_allclose(both, swapped, atol=1e-12 * np.abs(both).max())


def test_stiffness_below_zero_is_noted():
    notes = MACHINE.with_effects(NONE.with_values(x_1=1.0)).system(speed_rpm=RPM).notes
    assert any("in x falls to" in note for note in notes)


def test_a_machine_without_flexible_coupling_says_so():
    with pytest.raises(MissingPartError, match="flexible_coupling"):
        MACHINE.bare_assembly().component("flexible_coupling", "nowhere")
