"""The magnetic bearing against Eqs (7)-(9) of the source: transfer function, closed loop, signs."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.polynomial import polynomial
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.rotor_dynamics.magnetic_bearing import MagneticBearing

BEARING = MagneticBearing(
    current_stiffness_n_a=90.0,
    displacement_stiffness_n_m=2.5e5,
    sensor_gain_v_m=1e4,
    amplifier_gain_a_v=1.0,
    proportional=0.62,
    integral=1.5,
    derivative=6e-4,
    first_amplifier_time_s=2e-4,
    second_amplifier_time_s=1e-4,
    derivative_filter_time_s=2e-4,
)


def formula(bearing, s):
    """Eqs (8), (9) written out again."""
    sensor = bearing.sensor_gain_v_m
    control = (
        bearing.proportional
        + bearing.integral / s
        + bearing.derivative * s / (bearing.derivative_filter_time_s * s + 1)
    )
    amplifier = bearing.amplifier_gain_a_v / (bearing.first_amplifier_time_s * s + 1)
    return -sensor * control * amplifier / (bearing.second_amplifier_time_s * s + 1)


def characteristic_polynomial(bearing, mass_kg):
    """(m s^2 - k_s) s (T_D s + 1)(T_a s + 1)(T_b s + 1) + k_i k_a sensor N(s), ascending powers."""
    t_a, t_b, t_d = (
        bearing.first_amplifier_time_s,
        bearing.second_amplifier_time_s,
        bearing.derivative_filter_time_s,
    )
    left = np.array([-bearing.displacement_stiffness_n_m, 0.0, mass_kg])
    for factor in ([0.0, 1.0], [1.0, t_d], [1.0, t_a], [1.0, t_b]):
        left = polynomial.polymul(left, factor)
    numerator = polynomial.polymul([bearing.integral, bearing.proportional], [1.0, t_d])
    numerator = polynomial.polyadd(numerator, [0.0, 0.0, bearing.derivative])
    gain = bearing.current_stiffness_n_a * bearing.amplifier_gain_a_v * bearing.sensor_gain_v_m
    return polynomial.polyadd(left, gain * numerator)


def test_state_space_equals_the_formula_at_many_frequencies():
    control = BEARING.controller()
    for omega in np.logspace(-2, 6, 200):
        s = 1j * omega
        from_states = control.output @ np.linalg.solve(s * np.eye(4) - control.state, control.input)
        assert from_states == pytest.approx(formula(BEARING, s), rel=1e-12)
        assert BEARING.transfer(s) == pytest.approx(formula(BEARING, s), rel=1e-14)


@pytest.mark.parametrize("mass_kg", [0.5, 4.0, 40.0])
def test_closed_loop_eigenvalues_are_the_roots_of_the_characteristic_polynomial(mass_kg):
    found = np.linalg.eigvals(BEARING.closed_loop_matrix(mass_kg))
    coefficients = characteristic_polynomial(BEARING, mass_kg)
    # Relative backward error: what each root leaves over, against the size of the terms it cancels.
    for root in found:
        powers = coefficients * root ** np.arange(7)
        assert abs(powers.sum()) < 1e-12 * np.abs(powers).sum()
    # The product of all roots is the constant term over the leading one: none is missing or counted twice.
    assert np.prod(found).real == pytest.approx(coefficients[0] / coefficients[-1], rel=1e-9)
    assert found.sum().real == pytest.approx(-coefficients[-2] / coefficients[-1], rel=1e-9)


def test_closed_loop_with_the_usual_gains_is_stable_and_without_control_is_not():
    assert np.linalg.eigvals(BEARING.closed_loop_matrix(4.0)).real.max() < 0
    weak = dataclasses.replace(BEARING, proportional=1e-6, derivative=0.0, integral=0.0)
    growth = np.linalg.eigvals(weak.closed_loop_matrix(4.0)).real.max()
    # Free fall towards the magnet: sqrt(k_s / m).
    assert growth == pytest.approx(math.sqrt(2.5e5 / 4.0), rel=1e-3)


def test_control_must_beat_the_negative_stiffness():
    # Static stiffness k_i k_a sensor K_P - k_s changes sign at this proportional gain.
    limit = 2.5e5 / (90.0 * 1e4)
    above, below = (
        dataclasses.replace(BEARING, proportional=limit * factor, integral=0.0) for factor in (1.001, 0.999)
    )
    assert above.dynamic_stiffness_n_m(np.array(0.0)).real == pytest.approx(2.5e5 * 0.001, rel=1e-9)
    assert np.linalg.eigvals(above.closed_loop_matrix(4.0)[np.ix_([0, 1, 3, 4, 5], [0, 1, 3, 4, 5])]).real.max() < 0
    assert np.linalg.eigvals(below.closed_loop_matrix(4.0)).real.max() > 0.1


def test_without_current_the_magnets_pull_the_rotor_off_centre():
    # Printed Eq (7), F = -k_s q, would give +-250j here: a rotor that floats without control.
    idle = dataclasses.replace(BEARING, proportional=0.0, derivative=0.0, integral=0.0)
    rotor = np.sort_complex(np.linalg.eigvals(idle.closed_loop_matrix(4.0)[:2, :2]))
    assert rotor == pytest.approx([-250.0, 250.0], rel=1e-12)


def test_integral_action_carries_a_constant_load_without_offset():
    # m q'' = k_s q + k_i i + f at rest: q = 0 and k_i i = -f.
    matrix = BEARING.closed_loop_matrix(4.0)
    load_n = 40.0
    rest = np.linalg.solve(matrix, -np.array([0.0, load_n / 4.0, 0.0, 0.0, 0.0, 0.0]))
    assert rest[0] == pytest.approx(0.0, abs=1e-15)
    assert BEARING.controller().output @ rest[2:] == pytest.approx(-load_n / 90.0)


@given(st.floats(0.01, 10), st.floats(0.1, 100), st.floats(1e-5, 1e-2), st.floats(1e-6, 1e-2))
def test_realisation_holds_for_any_gain(proportional, integral, derivative, filter_time):
    bearing = dataclasses.replace(
        BEARING,
        proportional=proportional,
        integral=integral,
        derivative=derivative,
        derivative_filter_time_s=filter_time,
    )
    control = bearing.controller()
    s = 30.0 + 700j
    from_states = control.output @ np.linalg.solve(s * np.eye(4) - control.state, control.input)
    assert from_states == pytest.approx(formula(bearing, s), rel=1e-9)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("displacement_stiffness_n_m", -2.5e5),
        ("current_stiffness_n_a", 0.0),
        ("first_amplifier_time_s", 0.0),
        ("derivative", math.nan),
    ],
)
def test_wrong_values_are_named(name, value):
    with pytest.raises(InvalidValueError, match=name):
        dataclasses.replace(BEARING, **{name: value})


def test_a_mass_is_needed():
    with pytest.raises(InvalidValueError, match="Mass"):
        BEARING.closed_loop_matrix(0.0)
