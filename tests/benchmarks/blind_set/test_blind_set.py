"""The generator against theory: modal response, impact rates, whirl order, repeatability."""

import numpy as np
import pytest
from blind_cases import build_case
from impact_sources import ball_pass, defect
from machine import draw_machine
from shaft_sources import shaft_angle
from structure import Clock, Structure, acceleration_spectrum, to_time

TURN = 2 * np.pi


def test_one_mode_answers_as_the_textbook_oscillator() -> None:
    clock = Clock(1000.0, 4, 3000)
    structure = Structure(np.array([50.0]), np.array([0.05]), np.array([10.0]), np.eye(6)[:1])
    force = np.zeros((6, clock.fine_samples))
    force[0] = 20.0 * np.cos(TURN * 30.0 * clock.fine_time_s)
    motion = to_time(acceleration_spectrum(structure, force, clock), clock)
    own, omega = TURN * 50.0, TURN * 30.0
    expected = 20.0 * omega**2 / (10.0 * abs(own**2 - omega**2 + 2j * 0.05 * own * omega))
    assert np.sqrt(2) * motion[0].std() == pytest.approx(expected, rel=1e-4)
    assert not motion[1:].any()


@pytest.mark.parametrize("part", ["outer_race", "inner_race", "ball", "cage"])
def test_impacts_come_at_the_defect_order_less_one_to_two_per_cent(part: str) -> None:
    rng = np.random.default_rng(3)
    machine = draw_machine(np.random.default_rng(5), "bearing_outer_race")
    clock = Clock(20000.0, 2, 19 * 20000)
    angle = shaft_angle(rng, clock, 20.0, 0.0)
    bearing = machine.bearings[0]
    train = defect(machine, bearing, part, angle, clock, rng)[1]
    starts = np.flatnonzero((train[1:] > 0) & (train[:-1] == 0))
    order = (starts.size - 1) / ((angle[starts[-1]] - angle[starts[0]]) / TURN)
    theory = bearing.geometry.defect_orders()
    cage = {"outer_race": theory.outer_race, "ball": 2 * theory.ball_spin, "cage": theory.cage}
    # The cage lags, so the inner race meets more balls and every other part fewer.
    inner = (bearing.geometry.balls - order) / theory.outer_race
    lag = inner if part == "inner_race" else order / cage[part]
    assert 0.978 < lag < 0.992


def test_ball_pass_line_of_a_sound_bearing_lies_at_the_slipped_order() -> None:
    machine = draw_machine(np.random.default_rng(5), "bearing_outer_race")
    clock = Clock(5000.0, 8, 45000)
    angle = shaft_angle(np.random.default_rng(1), clock, 25.0, 0.0)
    spectrum = np.abs(np.fft.rfft(ball_pass(machine, angle)[1]))
    order = np.fft.rfftfreq(angle.size, 1 / clock.fine_rate_hz)[spectrum.argmax()] / 25.0
    assert 0.978 < order / machine.bearings[0].geometry.defect_orders().outer_race < 0.992


@pytest.mark.parametrize("index", range(4))
def test_whirl_turns_a_little_under_half_the_shaft_speed(index: int) -> None:
    case = build_case(5, index, "oil_whirl")
    speed_hz = draw_machine(np.random.default_rng([5, index]), "oil_whirl").speed_hz
    frequency = np.fft.rfftfreq(case.recording.samples, 1 / case.recording.rate_hz)
    signal = case.recording.signals[0] - case.recording.signals[0].mean()
    spectrum = np.abs(np.fft.rfft(signal * np.hanning(signal.size)))
    below = (frequency > 0.2 * speed_hz) & (frequency < 0.8 * speed_hz)
    assert 0.34 < frequency[below][spectrum[below].argmax()] / speed_hz < 0.5
    calm = case.baseline.signals[0] - case.baseline.signals[0].mean()
    quiet = np.abs(np.fft.rfft(calm * np.hanning(calm.size))) / calm.size
    axis = np.fft.rfftfreq(calm.size, 1 / case.baseline.rate_hz)
    assert quiet[(axis > 0.2 * speed_hz) & (axis < 0.6 * speed_hz)].max() < spectrum[below].max() / signal.size / 3


@pytest.mark.slow
def test_the_same_seed_gives_the_same_case() -> None:
    first, second = (build_case(11, 4, "looseness") for _ in range(2))
    assert np.array_equal(first.recording.signals, second.recording.signals)
    assert np.array_equal(first.baseline.signals, second.baseline.signals)
    assert not np.array_equal(first.recording.signals, build_case(12, 4, "looseness").recording.signals)
