"""The measuring chain: transfer functions, noise density, converter, tacho, and that a seed fixes all of it."""

import numpy as np
import pytest
from rotorwise.simulators.effects.clipping import Clipping
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.sensor_chain import SensorChain
from rotorwise.simulators.sensor_record import filtered, sampled
from rotorwise.simulators.sensor_run import run_chain
from rotorwise.simulators.speed_profile import ramp

from .effects.sensor_records import RATE_HZ, amplitude, record, seconds

ROTOR = find_machine("amb_rotor")
OPTIONS = {"speed_rpm": 3000, "duration_s": 1.0, "rate_hz": 1000.0}


def through(chain, given, seed=0):
    return run_chain(given, [], samples=given.signals.shape[1], seed=seed, chain=chain)


@pytest.mark.parametrize("frequency_hz", [2, 5, 10, 100, 800])
def test_band_of_the_sensor(frequency_hz):
    given = record(np.cos(2 * np.pi * frequency_hz * seconds(4)))
    made = through(SensorChain(high_pass_hz=5.0, pole_hz=800.0), given).signals[0]
    expected = 1j * frequency_hz / (5 + 1j * frequency_hz) / (1 + 1j * frequency_hz / 800)
    # Away from the ends of the record, where the continuation is a guess: two of four seconds.
    inside = slice(4096, 3 * 4096)
    assert amplitude(made[inside], frequency_hz) == pytest.approx(expected, abs=2e-3)


def test_ac_coupling_removes_the_mean():
    made = through(SensorChain(high_pass_hz=1.0), record(np.sin(2 * np.pi * 50 * seconds(2)) + 7.0))
    assert made.signals.mean() == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("phase_rad", [0.0, 1.0, np.pi / 2, 3.0])
def test_ac_coupling_of_a_steady_vibration_starts_without_a_transient(phase_rad):
    """A chain that has run for long shows the vibration and no mean, from the first sample to the last."""
    signal = np.cos(2 * np.pi * 300 * seconds(2) + phase_rad)
    made = through(SensorChain(high_pass_hz=0.5), record(signal)).signals[0]
    assert made == pytest.approx(signal, abs=0.005)  # 0.5 / 300 of it is what the filter leaves out of phase


@pytest.mark.parametrize("frequency_hz", [100, 500, 1000])
def test_anti_alias_filter_is_a_butterworth(frequency_hz):
    made = through(
        SensorChain(anti_alias_hz=500.0, anti_alias_order=8), record(np.cos(2 * np.pi * frequency_hz * seconds(4)))
    )
    expected = 1 / np.sqrt(1 + (frequency_hz / 500) ** 16)
    assert abs(amplitude(made.signals[0][4096 : 3 * 4096], frequency_hz)) == pytest.approx(expected, abs=1e-3)


def test_mounted_resonance_of_accelerometers_only():
    wave = np.cos(2 * np.pi * 500 * seconds())
    chain = SensorChain(mounting_hz=1000.0, mounting_damping_ratio=0.1)
    made = through(chain, record(wave)).signals[0]
    assert abs(amplitude(made, 500)) == pytest.approx(1 / np.hypot(0.75, 0.1), rel=1e-2)
    assert np.array_equal(through(chain, record(wave, quantity="displacement")).signals[0], wave)


@pytest.mark.parametrize("corner_hz", [0.0, 40.0])
def test_noise_density(corner_hz):
    from scipy.signal import welch

    chain = SensorChain(noise={"m/s2": 3e-3}, noise_corner_hz=corner_hz)
    made = through(chain, record(np.zeros(200_000))).signals[0]
    frequency, density = welch(made, RATE_HZ, nperseg=4096)
    for low, high in ((10, 20), (100, 200), (1000, 1800)):
        band = (frequency >= low) & (frequency < high)
        expected = np.mean(9e-6 * (1 + corner_hz / frequency[band]))
        # Some hundred averages of the band's bins.
        assert density[band].mean() == pytest.approx(expected, rel=0.08)


def test_noise_of_channels_is_independent_and_by_unit():
    chain = SensorChain(noise={"m/s2": 1e-3})
    one, two = through(chain, record(*np.zeros((2, 50_000)))).signals
    assert abs(np.corrcoef(one, two)[0, 1]) < 0.03
    assert not through(chain, record(np.zeros(100), quantity="displacement")).signals.any()


def test_converter_clips_and_rounds():
    wave = 2 * np.sin(2 * np.pi * 37.7 * seconds())
    made = through(SensorChain(full_scale={"m/s2": 1.0}, bits=8), record(wave)).signals[0]
    assert made.min() == -1.0
    assert made.max() == pytest.approx(1 - 2 / 256)
    assert np.unique(made).size <= 256
    inside = np.abs(wave) < 0.99
    assert np.abs(made - wave)[inside].max() <= 1 / 256


def test_stated_range_rules_the_effects():
    wave = np.sin(2 * np.pi * 32 * seconds())
    chain, effect = SensorChain(full_scale={"m/s2": 10.0}), Clipping(lost_range=0.95)
    made = run_chain(record(wave), [effect], samples=wave.size, seed=None, chain=chain)
    assert made.signals.max() == pytest.approx(0.5)


def test_ideal_chain_is_the_simulation():
    measured = SensorChain().measure(ROTOR, **OPTIONS)
    plain = ROTOR.simulate(**OPTIONS)
    assert np.array_equal(measured.signals, plain.signals)
    assert np.array_equal(measured.phase_rad, plain.phase_rad)
    assert measured.tacho is None


@pytest.mark.parametrize("pulses", [1, 8])
def test_tacho_counts_turns_of_a_run_up(pulses):
    chain = SensorChain(pulses_per_revolution=pulses, tacho_ratio=0.5)
    profile = ramp(start_rpm=600, stop_rpm=3000, duration_s=1.0)
    measured = chain.measure(ROTOR, **{**OPTIONS, "rate_hz": 4000.0, "speed_rpm": profile})
    rising = np.flatnonzero(np.diff(measured.tacho) > 0)
    turns = measured.phase_rad[-1] / (2 * np.pi) * 0.5
    assert rising.size == pytest.approx(turns * pulses, abs=1)
    # A share of the angle, not of the time: 30 turns are whole pulses.
    assert np.average(measured.tacho, weights=measured.speed_rad_s) == pytest.approx(0.3, abs=0.01)
    # Edges lie where the angle passes whole pulses, to within a sample.
    passed = measured.phase_rad[rising + 1] * 0.5 * pulses / (2 * np.pi) % 1
    assert passed.max() < 0.5 * pulses * 50 / 4000 * 1.1


def test_tacho_jitter():
    chain = SensorChain(pulses_per_revolution=4, pulse_jitter=0.01)
    given = record(np.zeros(400_000), rate_hz=1e6, speed_rad_s=2 * np.pi * 1000)
    level = chain.tacho(given, np.random.default_rng(0))
    edges = np.flatnonzero(np.diff(level) > 0) / 250
    scatter = (edges - np.arange(edges.size) - (edges[0] - 0)) % 1
    scatter = (scatter + 0.5) % 1
    assert scatter.std() == pytest.approx(0.01, rel=0.1)


def test_seed_fixes_the_measurement_and_is_required():
    chain = SensorChain(noise={"m": 1e-9})
    one, two, other = (chain.measure(ROTOR, seed=seed, **OPTIONS).signals for seed in (1, 1, 2))
    assert np.array_equal(one, two)
    assert not np.array_equal(one, other)
    with pytest.raises(InvalidValueError, match="seed"):
        chain.measure(ROTOR, **OPTIONS)
    with pytest.raises(InvalidValueError, match="seed"):
        ROTOR.simulate(**OPTIONS, seed=-1)


@pytest.mark.parametrize(
    "wrong",
    [{"pole_hz": 0.0}, {"high_pass_hz": -1.0}, {"bits": 0}, {"noise": {"m": -1.0}}, {"pulse_width": 1.0},
     {"pulse_jitter": 0.5}, {"full_scale": {"m": float("nan")}}],
)  # fmt: skip
def test_refuses_what_no_chain_can_be(wrong):
    with pytest.raises(InvalidValueError, match=next(iter(wrong))):
        SensorChain(**wrong)


def test_filter_helper_leaves_a_line_alone_and_its_continuation_is_smooth():
    time = seconds(1)
    line = 3 * time - 1
    assert filtered(line[None], RATE_HZ, lambda f: np.ones(f.shape))[0] == pytest.approx(line)


def test_refuses_a_rate_that_is_no_multiple():
    with pytest.raises(InvalidValueError, match="multiple"):
        sampled(record(np.zeros(10), rate_hz=1000.0, output_rate_hz=300.0))
