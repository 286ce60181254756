"""Threshold maps: equal to direct solutions, convex, with the zones of the clearance."""

import time

import numpy as np
import pytest
from rotorwise.simulators.effects import CouplingMisalignment, Unbalance
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance
from rotorwise.simulators.threshold_map import INSTANTS, threshold_map

MACHINE = find_machine("amb_rotor")
OFFSETS, ANGLES = np.linspace(0, 5e-4, 21), np.radians(np.linspace(0, 2, 17))
ANGLE = 2 * np.pi * np.arange(INSTANTS) / INSTANTS


@pytest.mark.parametrize("rpm", [2580.0, 4000.0])
def test_map_equals_direct_solutions(rpm):
    phases = {"offset_phase_rad": 0.4, "angle_phase_rad": -1.1}
    found = threshold_map(MACHINE, rpm, OFFSETS, ANGLES, **phases)
    assert found.probes == ("path_1", "path_2", "path_3", "path_4")
    for i, j in ((0, 0), (20, 0), (0, 16), (20, 16), (7, 11)):
        effect = CouplingMisalignment(offset_m=OFFSETS[i], angle_rad=ANGLES[j], **phases)
        wave = harmonic_balance(MACHINE.with_effects(effect), speed_rpm=rpm).waveform(ANGLE)
        np.testing.assert_allclose(found.peaks[:, i, j], np.abs(wave).max(axis=1), rtol=1e-8)


def test_map_agrees_with_time_stepping():
    found = threshold_map(MACHINE, 4000.0, OFFSETS[-1:], ANGLES[-1:])
    effect = CouplingMisalignment(offset_m=OFFSETS[-1], angle_rad=ANGLES[-1])
    run = MACHINE.with_effects(effect).simulate(speed_rpm=4000.0, duration_s=0.3, rate_hz=4000.0, settle_s=8.0)
    # 60 samples a turn and 0.3 s = 20 turns: the sampled peak misses at most 1 - cos(pi / 60).
    np.testing.assert_allclose(np.abs(run.signals).max(axis=1), found.peaks[:, 0, 0], rtol=1.5e-3)


def test_safe_sets_are_convex():
    """The peak at the middle of two points is at most the mean of both: for every pair of grid points that has one."""
    peaks = threshold_map(MACHINE, 4000.0, OFFSETS, ANGLES).peaks
    generator = np.random.default_rng(1)
    first = np.stack([generator.integers(0, n, 4000) for n in (OFFSETS.size, ANGLES.size)])
    second = np.stack([generator.integers(0, n, 4000) for n in (OFFSETS.size, ANGLES.size)])
    even = np.all((first + second) % 2 == 0, axis=0)
    (i, j), (k, m) = first[:, even], second[:, even]
    middle = peaks[:, (i + k) // 2, (j + m) // 2]
    assert even.sum() > 500
    assert np.all(middle <= (peaks[:, i, j] + peaks[:, k, m]) / 2 * (1 + 1e-12))


def test_zones_are_those_of_the_clearance():
    found = threshold_map(MACHINE, 4000.0, OFFSETS, ANGLES)
    zones = found.zones(125e-6)
    for zone, (low, high) in enumerate(((0, 37.5), (37.5, 50), (50, 62.5), (62.5, np.inf))):
        expected = (found.peaks > low * 1e-6) & (found.peaks <= high * 1e-6)
        assert np.array_equal(zones == zone, expected)
    with pytest.raises(InvalidValueError, match="Clearance"):
        found.zones(0.0)


def test_largest_misalignment_within_a_limit():
    found = threshold_map(MACHINE, 4000.0, OFFSETS, ANGLES)
    largest = found.largest_offset_m(100e-6)
    for probe in range(4):
        at = int(np.argmin(np.abs(OFFSETS - largest[probe])))
        assert found.peaks[probe, at, 0] <= 100e-6 < found.peaks[probe, at + 1, 0]
    assert np.all(np.isnan(found.largest_angle_rad(1e-9)))


def test_a_misalignment_that_is_there_already_is_added_to():
    shifted = MACHINE.with_effects(CouplingMisalignment(offset_m=2e-4, angle_rad=0.0))
    found = threshold_map(shifted, 4000.0, np.array([0.0, 1e-4]), np.array([0.0]))
    whole = threshold_map(MACHINE, 4000.0, np.array([2e-4, 3e-4]), np.array([0.0]))
    np.testing.assert_allclose(found.peaks, whole.peaks, rtol=1e-8)


def test_peaks_do_not_depend_on_phase_without_unbalance_and_with_a_constant_coupling():
    machine = MACHINE.with_parameters(unbalance_kg_m=0.0, harmonic_1=0.0, harmonic_2=0.0, harmonic_3=0.0)
    first = threshold_map(machine, 4000.0, OFFSETS, np.array([0.0]))
    second = threshold_map(machine, 4000.0, OFFSETS, np.array([0.0]), offset_phase_rad=1.3)
    # A peak between two of the 256 instants is missed by up to 1 - cos(pi / 256).
    np.testing.assert_allclose(first.peaks, second.peaks, rtol=8e-5, atol=1e-18)


def test_a_nonlinear_machine_is_refused():
    from rotorwise.simulators.machine import machine_catalogue

    nonlinear = [
        machine.with_effects(Unbalance())
        for name, machine in machine_catalogue().items()
        if name != "amb_rotor" and not machine.system(speed_rpm=1800.0).is_linear
    ]
    assert nonlinear, "no nonlinear machine with a coupling to try"
    for machine in nonlinear:
        with pytest.raises(InvalidValueError):
            threshold_map(machine, 1800.0, OFFSETS, np.array([0.0]))


def test_a_full_map_takes_a_fraction_of_the_direct_solutions():
    offsets, angles = np.linspace(0, 5e-4, 101), np.radians(np.linspace(0, 2, 101))
    threshold_map(MACHINE, 4000.0, offsets, angles)
    start = time.process_time()
    found = threshold_map(MACHINE, 4000.0, offsets, angles)
    took = time.process_time() - start
    start = time.process_time()
    harmonic_balance(MACHINE, speed_rpm=4000.0)
    once = time.process_time() - start
    assert found.peaks.shape == (4, 101, 101)
    assert took < 200 * once, "10201 direct solutions are what it replaces"
