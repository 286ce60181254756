"""Housing resonance: the oscillator's transfer function, absorber, what the sensor sees."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.housing_resonance import HousingResonance
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

RIG = find_machine("test_rig")
SPEED_RPM = 1800.0


def transfer(effect, frequency_hz):
    """1 + v [1 / (1 - r^2 + 2 i z r) (1 + 2 i z r) - 1]: what the sensor sees over the housing's own motion."""
    r = frequency_hz / effect.frequency_hz
    loss = 2j * effect.damping_ratio * r
    return 1 + effect.participation * ((1 + loss) / (1 - r**2 + loss) - 1)


@pytest.mark.parametrize("frequency_hz", [20.0, 30.5, 45.0])
def test_the_sensor_sees_the_oscillator_on_its_base(frequency_hz, figure):
    """A part so light that the housing does not feel it; probes sit on the cap, the part on the housing's body."""
    effect = HousingResonance(mass_kg=1e-9, participation=0.8, frequency_hz=frequency_hz, damping_ratio=0.05)
    plain, changed = (harmonic_balance(m, speed_rpm=SPEED_RPM) for m in (RIG, RIG.with_effects(effect)))
    before, after = (motion.amplitude("housing_a_y", 1.0) for motion in (plain, changed))
    # Body and cap move together at 30 Hz, to (30 / 4200)^2.
    assert after / before == pytest.approx(transfer(effect, SPEED_RPM / 60), rel=1e-3)
    expected = transfer(effect, SPEED_RPM / 60)
    figure("Motion of the sensor against an oscillator on its base", after / before, expected)
    for probe in ("housing_a_x", "housing_b_y", "housing_a_axial"):
        assert changed.amplitude(probe, 1.0) == pytest.approx(plain.amplitude(probe, 1.0), rel=1e-4)


def test_direction_shares_the_motion_between_the_sensors():
    effect = HousingResonance(mass_kg=1e-9, participation=1.0, frequency_hz=40.0, direction_rad=0.6)
    plain, changed = (harmonic_balance(m, speed_rpm=SPEED_RPM) for m in (RIG, RIG.with_effects(effect)))
    x, y = (changed.amplitude(f"housing_a_{d}", 1.0) - plain.amplitude(f"housing_a_{d}", 1.0) for d in "xy")
    assert y / x == pytest.approx(math.tan(0.6), rel=1e-6)


def test_an_undamped_part_holds_a_light_housing_still():
    """Den Hartog's absorber: the base of an oscillator tuned to the excitation does not move."""
    effect = HousingResonance(mass_kg=1.0, participation=0.0, frequency_hz=30.0, damping_ratio=0.001)
    plain, changed = (harmonic_balance(m, speed_rpm=SPEED_RPM) for m in (RIG, RIG.with_effects(effect)))
    ratio = abs(changed.amplitude("housing_a_y", 1.0)) / abs(plain.amplitude("housing_a_y", 1.0))
    assert ratio < 0.05


def test_two_parts_at_one_housing():
    names = RIG.with_effects(HousingResonance(), HousingResonance(frequency_hz=900.0)).system(speed_rpm=600).coordinates
    assert [name for name in names if "part" in name] == ["housing_a part 1", "housing_a part 2"]


def test_modes_are_where_they_were_asked_for():
    made = RIG.with_effects(HousingResonance(mass_kg=1e-6, frequency_hz=777.0, damping_ratio=0.01))
    values = np.linalg.eigvals(made.system(speed_rpm=SPEED_RPM).core)
    nearest = values[np.abs(np.abs(values) / (2 * np.pi) - 777.0).argmin()]
    assert abs(nearest) / (2 * np.pi) == pytest.approx(777.0, rel=1e-4)
    assert -nearest.real / abs(nearest) == pytest.approx(0.01, rel=1e-3)


def test_a_machine_without_housing_is_refused():
    with pytest.raises(MissingPartError):
        HousingResonance().contribute(find_machine("amb_rotor").bare_assembly())
