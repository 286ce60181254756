"""Soft foot: static shift in closed form, softer support, what does not appear."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from rotorwise.simulators.effects.soft_foot import SoftFoot
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

from .jeffcott import CRITICAL_RPM, MASS, STIFFNESS, footed


@settings(max_examples=20, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(share=st.floats(0.1, 0.9), gap=st.floats(0.0, 1e-3), loss=st.floats(0.0, 0.9), ratio=st.floats(0.1, 0.6))
def test_shift_and_1x(figure, share, gap, loss, ratio):
    eccentricity = 1e-5
    machine = footed(eccentricity_m=eccentricity, foot_share=share, damping_ratio=0.02).with_effects(
        SoftFoot(gap_m=gap, loss=loss)
    )
    motion = harmonic_balance(machine, speed_rpm=ratio * CRITICAL_RPM, harmonics=3)
    foot = share * STIFFNESS * (1 - loss)
    left = (1 - share) * STIFFNESS + foot
    assert motion.amplitude("y", 0.0).real == pytest.approx(-gap * foot / left, rel=1e-9, abs=1e-15)
    omega2 = ratio**2 * STIFFNESS / MASS
    push = MASS * eccentricity * omega2
    lag = 2j * 0.02 * ratio * STIFFNESS
    # The heavy spot turns from x to y: y lags by a quarter.
    expected = -1j * push / (left - MASS * omega2 + lag)
    assert motion.amplitude("y", 1.0) == pytest.approx(expected, rel=1e-6)
    found = [motion.amplitude("y", order) for order in (0.0, 1.0)]
    figure("Static shift and 1X of a machine on a soft foot", found, [-gap * foot / left, expected])
    # Only the vertical direction changes, and no multiple appears.
    assert motion.amplitude("x", 1.0) == pytest.approx(push / (STIFFNESS - MASS * omega2 + lag), rel=1e-6)
    assert np.abs(motion.amplitudes[:, 2:]).max() < 1e-12


def test_gaps_add_and_losses_multiply_in_any_order():
    effects = [SoftFoot(gap_m=1e-4, loss=0.3), SoftFoot(gap_m=2e-4, loss=0.5)]
    one, two = (
        harmonic_balance(footed(foot_share=0.5).with_effects(*order), speed_rpm=1000).amplitude("y", 0.0).real
        for order in (effects, effects[::-1])
    )
    foot = 0.5 * 0.7 * 0.5
    assert one == pytest.approx(two, rel=1e-12)
    assert one == pytest.approx(-3e-4 * foot / (0.5 + foot), rel=1e-9)


def test_a_shifted_rotor_wakes_an_offset_flange():
    # Hole circle off, axes in line: no torque. The shift of the axes makes 1X of the twist, in proportion.
    machine = find_machine("rigid_coupling").preset("linearised").with_parameters(axis_offset_m=0.0)
    sizes = [
        abs(harmonic_balance(m, speed_rpm=900).amplitude("twist", 1.0))
        for m in (machine, *(machine.with_effects(SoftFoot(at="support_2", gap_m=g, loss=0.0)) for g in (1e-4, 2e-4)))
    ]
    assert sizes[0] < 1e-12
    assert sizes[1] > 1e-7
    assert sizes[2] == pytest.approx(2 * sizes[1], rel=0.01)


def test_every_support_of_the_rig_can_be_soft():
    rig = find_machine("test_rig")
    base = harmonic_balance(rig, speed_rpm=1800)
    for name in ("housing_a pedestal", "housing_b pedestal"):
        motion = harmonic_balance(rig.with_effects(SoftFoot(at=name)), speed_rpm=1800)
        changed = np.abs(motion.amplitudes - base.amplitudes)[:, 1]
        # Far below the housing's resonance a softer pedestal changes 1X by little: that is what there is.
        assert 0 < changed.max() < 0.1 * np.abs(base.amplitudes[:, 1]).max()
