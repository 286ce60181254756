"""Run-out: a pattern of the surface, the same at every speed, a quarter turn later on the second probe."""

import numpy as np
import pytest
from rotorwise.simulators.effects.run_out import RunOut
from rotorwise.simulators.machine import find_machine

from .sensor_records import record, run

MACHINE = find_machine("amb_rotor")
OPTIONS = {"duration_s": 1.0, "rate_hz": 4000.0}


def added(effect, speed_rpm, machine=MACHINE):
    one, two = (m.simulate(speed_rpm=speed_rpm, **OPTIONS) for m in (machine, machine.with_effects(effect)))
    return one.phase_rad, two.signals - one.signals, one.probes


def test_pattern_does_not_change_with_speed():
    effect = RunOut(harmonic_1_m=1e-5, angle_2_rad=2.4, angle_3_rad=-1.4, angle_4_rad=1.0, angle_6_rad=-2.0)
    angles = np.linspace(1.0, 7.0, 50)
    patterns = []
    for speed_rpm in (300, 1500):
        phase, signals, _ = added(effect, speed_rpm)
        patterns.append(np.interp(angles, phase, signals[0]))
    assert patterns[0] == pytest.approx(patterns[1], abs=3e-7)


def test_harmonics_have_their_heights_and_high_spots(figure):
    heights = {n: 1e-5 / n for n in range(1, 13)}
    places = {n: 0.4 * n - 1.0 for n in heights}
    values = {f"harmonic_{n}_m": height for n, height in heights.items()}
    phase, signals, _ = added(RunOut(**values, **{f"angle_{n}_rad": place for n, place in places.items()}), 1500)
    for n, height in heights.items():
        line = 2 * np.mean(signals[0] * np.exp(-1j * n * phase))
        assert line == pytest.approx(height * np.exp(1j * n * places[n]), rel=1e-6)
        figure("1X to 12X against the harmonics of the surface", abs(line), height)


def test_second_probe_reads_the_pattern_a_quarter_turn_later():
    turns = np.arange(4096) / 4096 * 8
    silent = record(0 * turns, 0 * turns, quantity="displacement", directions="xy", rate_hz=4096,
                    speed_rad_s=2 * np.pi * 8)  # fmt: skip
    x, y = run(RunOut(), silent).signals
    assert y == pytest.approx(np.roll(x, 128), abs=1e-15)
    assert silent.phase_rad[512] == pytest.approx(2 * np.pi)


def test_slow_shaft_has_its_own_order():
    gearbox = find_machine("gearbox")
    effect = RunOut(at="wheel x")
    ratio = gearbox.bare_assembly().places["wheel"].shaft_ratio
    assert effect.signature(gearbox)[0].order == pytest.approx(ratio)
    silent = record(np.zeros(4096), quantity="displacement", ratio=0.5)
    line = 2 * np.mean(run(RunOut(harmonic_1_m=1e-4), silent).signals[0] * np.exp(-0.5j * silent.phase_rad))
    # 12.5 turns of the shaft in the record: leakage of the neighbours at a distance of 12 bins.
    assert abs(line) == pytest.approx(1e-4, rel=0.1)
