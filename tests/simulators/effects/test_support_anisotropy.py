"""Support anisotropy: stiffness of supports, split modes, elliptic orbit, 3X through an offset flange."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.support_anisotropy import SupportAnisotropy
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.rotor_dynamics.support import Support, chosen_supports
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

from .jeffcott import CRITICAL, CRITICAL_RPM, MASS, STIFFNESS, footed, orbit

MACHINE = find_machine("rigid_coupling")
REDUCED = MACHINE.preset("paper_reduction")


def test_splits_the_lateral_mode_as_statics_say():
    values = np.linalg.eigvals(
        REDUCED.with_effects(SupportAnisotropy(at="support_2", fraction=-0.3)).system(speed_rpm=1200).core
    )
    moduli = np.abs(values[(values.imag > 0) & (values.real > -0.3 * np.abs(values))]) / (2 * math.pi)
    support, coupling = REDUCED.values["support_2_n_m"], 4 * REDUCED.values["bolt_stiffness_n_m"]
    soft = math.sqrt((0.7 * support + coupling) / 100) / (2 * math.pi)
    assert np.sort(moduli) == pytest.approx([20.0, soft, 40.0], rel=1e-6)


def test_all_supports_without_a_name_one_with_a_name():
    def stiffness(effect):
        parts = MACHINE.with_effects(effect).assembly(speed_rpm=600).components
        return [parts[f"support_{i}"].stiffness_x_n_m / parts[f"support_{i}"].stiffness_y_n_m for i in (1, 2)]

    assert stiffness(SupportAnisotropy(fraction=-0.3)) == pytest.approx([0.7, 0.7])
    assert stiffness(SupportAnisotropy(at="support_1", fraction=0.5)) == pytest.approx([1.5, 1.0])


def test_orbit_turns_backward_in_part():
    # Forward and backward circle of an orbit: (X + iY) / 2 with X, Y the complex amplitudes of cos-like motion.
    def backward(machine):
        motion = harmonic_balance(machine, speed_rpm=600)
        x, y = motion.amplitude("rotor_2.x", 1.0), motion.amplitude("rotor_2.y", 1.0)
        return abs(x - 1j * y) / 2, abs(x + 1j * y) / 2

    round_orbit, ellipse = backward(MACHINE), backward(MACHINE.with_effects(SupportAnisotropy(fraction=-0.3)))
    assert min(round_orbit) < 1e-6 * max(round_orbit)
    assert min(ellipse) > 0.05 * max(ellipse)


@pytest.mark.parametrize(("ratio", "turns"), [(0.6, "forward"), (0.88, "backward"), (1.4, "forward")])
def test_whirl_is_backward_between_the_two_critical_speeds(ratio, turns, figure):
    """Unbalance on one mass: x = F / (0.6 k - M w^2), y a quarter behind with k; of opposite signs in between."""
    machine = footed(eccentricity_m=1e-5).with_effects(SupportAnisotropy(fraction=-0.4))
    speed = ratio * CRITICAL
    ahead, back = orbit(harmonic_balance(machine, speed_rpm=ratio * CRITICAL_RPM, harmonics=2), 1.0)
    push = MASS * 1e-5 * speed**2
    yields = [1 / (stiffness - MASS * speed**2) for stiffness in (0.6 * STIFFNESS, STIFFNESS)]
    assert ahead == pytest.approx(push * (yields[0] + yields[1]) / 2, rel=1e-9)
    assert abs(back) == pytest.approx(push * abs(yields[0] - yields[1]) / 2, rel=1e-9)
    expected = [push * (yields[0] + yields[1]) / 2, push * abs(yields[0] - yields[1]) / 2]
    figure("Forward and backward part of the orbit against closed form", [ahead, abs(back)], expected)
    assert (abs(back) > abs(ahead)) == (turns == "backward")


@pytest.mark.parametrize("speed_rpm", [600, 1200])
def test_its_lines_rise(speed_rpm):
    effect = SupportAnisotropy()
    base, changed = (harmonic_balance(m, speed_rpm=speed_rpm) for m in (MACHINE, MACHINE.with_effects(effect)))
    for line in effect.signature(MACHINE):
        probe = "twist" if line.direction == "torsion" else "rotor_2.x"
        assert abs(changed.amplitude(probe, line.order)) > 5 * abs(base.amplitude(probe, line.order))


def test_zero_strength_changes_nothing():
    base, same = (m.system(speed_rpm=900) for m in (MACHINE, MACHINE.with_effects(SupportAnisotropy().at_zero())))
    assert np.array_equal(base.core, same.core)


def test_machine_without_supports_is_refused():
    with pytest.raises(MissingPartError, match="no support"):
        find_machine("amb_rotor").with_effects(SupportAnisotropy()).system(speed_rpm=1200)


def test_support_adds_springs_and_dampers_between_its_ends():
    from rotorwise.simulators.assembly import Assembly

    assembly = Assembly(speed_rad_s=0.0)
    for name in ("a.x", "a.y", "b.x"):
        assembly.add_coordinate(name, mass=1.0)
    support = Support("support", {"a.x": 1.0, "b.x": -1.0}, {"a.y": 1.0}, 3.0, 5.0, 0.3, 0.5)
    support.scale_stiffness(x=2.0)
    support.scale_damping(y=0.5)
    assembly.add_component(support)
    support.finish(assembly)
    assert assembly.stiffness["a.x", "b.x"] == -6.0
    assert assembly.stiffness["a.y", "a.y"] == 5.0
    assert assembly.damping["b.x", "b.x"] == 0.3
    assert assembly.damping["a.y", "a.y"] == 0.25
    assert list(chosen_supports(assembly, "support")) == [support]
    with pytest.raises(InvalidValueError, match="factors from 0"):
        support.scale_stiffness(x=-1.0)
