"""Order amplitudes of a recording: closed forms, and noise that is what repeated recordings scatter by."""

import numpy as np
import pytest
from rotorwise.datasets.recording import Channel, OperatingCondition, Recording
from rotorwise.diagnose.gap.line_noise import (
    Scatter,
    UnusableRecordingError,
    _slowness,
    deviations_of,
    order_amplitudes_with_noise,
    scatter_of,
)
from rotorwise.diagnose.gap.observe import observe_orders, with_reference, with_still_phases
from scipy.signal import lfilter

ORDERS = np.array([0.5, 1.0, 2.0, 3.0])
TURNS = np.arange(8000) / 100


def test_amplitude_and_phase_of_a_sum_of_lines():
    wanted = np.array([0.2j, 1.5 - 0.5j, 0.0, 0.3])
    signal = np.real(wanted @ np.exp(2j * np.pi * np.outer(ORDERS, TURNS)))
    found, _ = order_amplitudes_with_noise(signal[None] + 7.0, turns=TURNS, orders=ORDERS)
    assert found[0] == pytest.approx(wanted, abs=2e-4)


def test_deviation_is_the_scatter_of_repeated_records():
    generator = np.random.default_rng(1)
    clean = np.cos(2 * np.pi * TURNS)
    found, stated = [], []
    for _ in range(150):
        signal = clean + generator.normal(size=TURNS.size)
        amplitude, deviation = order_amplitudes_with_noise(signal[None], turns=TURNS, orders=ORDERS)
        found.append(amplitude[0])
        stated.append(deviation[0] ** 2)
    scatter = np.array(found)
    real = 0.5 * (scatter.real.var(axis=0) + scatter.imag.var(axis=0))
    # 300 numbers a variance: 8 % standard deviation. Theory: 1.5 (Hann) x 2 / samples.
    assert real == pytest.approx(np.full(4, 1.5 * 2 / TURNS.size), rel=0.3)
    assert np.mean(stated, axis=0) == pytest.approx(real, rel=0.3)


def test_a_line_that_wanders_is_less_certain():
    generator = np.random.default_rng(2)
    wander = np.repeat(1 + 0.3 * generator.normal(size=16), TURNS.size // 16)
    signal = wander * np.cos(2 * np.pi * TURNS) + 0.01 * generator.normal(size=TURNS.size)
    _, deviation = order_amplitudes_with_noise(signal[None], turns=TURNS, orders=ORDERS)
    assert deviation[0, 1] > 10 * deviation[0, 3]


def test_lines_that_change_slowly_are_less_certain_than_their_segments_say():
    # Each line wanders about its mean with a memory of a quarter of the record: segments are not independent.
    generator = np.random.default_rng(3)
    orders = np.arange(1.0, 7.0)
    found, stated = [], []
    for _ in range(60):
        steps = generator.normal(size=(2, orders.size, 2 * TURNS.size))
        memory = np.exp(-4 / TURNS.size)
        wander = lfilter([np.sqrt(1 - memory**2)], [1.0, -memory], steps, axis=2)[:, :, -TURNS.size :]
        lines = 1 + 0.2 * (wander[0] + 1j * wander[1])
        signal = np.real((lines * np.exp(2j * np.pi * np.outer(orders, TURNS))).sum(axis=0))
        signal += 0.1 * generator.normal(size=TURNS.size)
        amplitude, deviation = order_amplitudes_with_noise(signal[None], turns=TURNS, orders=orders)
        found.append(amplitude[0])
        stated.append(deviation[0] ** 2)
    scatter = np.array(found)
    real = 0.5 * (scatter.real.var(axis=0) + scatter.imag.var(axis=0)).mean()
    assert 0.3 * real < np.median(stated) < 2 * real
    # Halves that differ by 1 where segments say a deviation of 0.03.
    assert _slowness(np.full(6, 1.0 + 0j), np.full(6, 1e-3)) == pytest.approx(125 / np.log(2))


def test_records_of_a_random_walk_differ_as_stated():
    # Two neighbouring records of a machine whose lines walk: what each states must hold what they differ by.
    generator = np.random.default_rng(7)
    orders = np.arange(1.0, 7.0)
    apart, stated = [], []
    for _ in range(40):
        steps = generator.normal(size=(2, orders.size, 2 * TURNS.size)) * 0.3 / np.sqrt(TURNS.size)
        lines = 2 + np.cumsum(steps[0] + 1j * steps[1], axis=1)
        records = []
        for first in (0, TURNS.size):
            part = lines[:, first : first + TURNS.size]
            signal = np.real((part * np.exp(2j * np.pi * np.outer(orders, TURNS))).sum(axis=0))
            signal += 0.02 * generator.normal(size=TURNS.size)
            records.append(scatter_of(signal[None], turns=TURNS, orders=orders))
        apart.append(np.abs(records[1].amplitudes - records[0].amplitudes)[0] ** 2 / 2)
        stated.append(sum(own[0] ** 2 for own in deviations_of(records)))
    assert 0.4 < np.median(stated) / np.mean(apart) < 2


def test_slow_lines_are_told_by_all_records_together():
    # Three clear lines a record say nothing, those of four records do.
    power, change = np.full((1, 3), 1e-3), np.full((1, 3), 0.3 + 0j)
    records = [Scatter(np.full((1, 3), 5.0 + 0j), power, change)] * 4
    assert deviations_of(records[:1])[0] == pytest.approx(np.sqrt(1e-3))
    assert deviations_of(records)[2][0, 0] > 5 * np.sqrt(1e-3)


def test_steady_lines_are_not_called_slow():
    generator = np.random.default_rng(4)
    noise = generator.normal(size=(2, 400, 12)) * np.sqrt(4.0)
    slow = [_slowness(real + 1j * imaginary, np.ones(12)) > 1 for real, imaginary in zip(*noise, strict=True)]
    # One in a hundred by construction.
    assert np.mean(slow) < 0.04
    assert _slowness(np.full(3, 100.0 + 0j), np.ones(3)) == 1.0


def _recording(signal: np.ndarray, name: str = "a") -> Recording:
    tacho = (np.arange(signal.size) % 100 < 30).astype(float)
    return Recording(np.stack([signal, tacho]), 1000.0, (Channel(name, "acceleration"), Channel("tacho", "tacho")))


def test_speed_and_phase_come_from_the_tacho():
    signal = np.cos(2 * np.pi * np.arange(8000) / 100 - 0.4)
    (lines,) = observe_orders([_recording(signal)], orders=ORDERS.tolist(), channels={"a": "probe"})
    assert lines.conditions[0].speed_rpm == pytest.approx(600, rel=1e-4)
    # The edge is found between samples: half a sample is 1.8 degrees.
    assert np.angle(lines.amplitudes[0, 0, 1]) == pytest.approx(-0.4, abs=0.04)
    assert lines.probes == ("probe",)


def test_lines_near_half_the_rate_are_not_compared():
    (lines,) = observe_orders(
        [_recording(np.random.default_rng(3).normal(size=8000))], orders=[1.0, 45.0], channels={"a": "a"}
    )
    assert lines.seen[0, 0].tolist() == [True, False]


def test_a_short_record_and_a_missing_channel_are_said():
    with pytest.raises(UnusableRecordingError, match="turns of the shaft"):
        observe_orders([_recording(np.ones(600) * np.arange(600))], orders=[1.0], channels={"a": "a"})
    with pytest.raises(UnusableRecordingError, match="no channel 'b'"):
        observe_orders([_recording(np.arange(8000.0))], orders=[1.0], channels={"b": "b"})


def test_a_strong_line_beside_an_order_does_not_pull_the_speed():
    # An outer race at order 3.053, five times as strong as 1X, and no 3X: as on a healthy bench with a small disc.
    time, generator = np.arange(40000) / 20000, np.random.default_rng(6)
    signal = 0.2 * np.cos(2 * np.pi * 20.11 * time) + 1.0 * np.cos(2 * np.pi * 61.4 * time + 1)
    signal += 0.3 * generator.normal(size=time.size)
    turns = 20.15 * time
    still = with_still_phases(signal[None], turns, slack=0.004)
    assert still[-1] / time[-1] == pytest.approx(20.11, abs=0.01)
    # Without a bound it would be the race's third.
    assert with_still_phases(signal[None], turns, slack=1.0)[-1] / time[-1] == pytest.approx(61.4 / 3, abs=0.05)


def test_without_a_tacho_phases_are_those_between_probes():
    # Two records of one motion that begin at different angles, their speed known to 0.05 %.
    found = []
    for start in (0.0, 0.37):
        turns = start + 25.0 * np.arange(8000) / 2000.0
        a = np.cos(2 * np.pi * turns + 0.3) + 0.2 * np.cos(4 * np.pi * turns)
        b = 0.5 * np.cos(2 * np.pi * turns + 1.1) + 0.1 * np.cos(4 * np.pi * turns - 0.5)
        noise = 1e-3 * np.random.default_rng(int(10 * start)).normal(size=(2, 8000))
        recording = Recording(
            np.stack([a, b]) + noise,
            2000.0,
            (Channel("a", "displacement"), Channel("b", "displacement")),
            condition=OperatingCondition(speed_rpm=1500.75),
        )
        found += observe_orders([recording], orders=[1.0, 2.0], channels={"a": "a", "b": "b"})
    first, second = with_reference(*found)
    assert not first.conditions[0].tied
    assert first.reference == (0, 0)
    assert first.conditions[0].speed_rpm == pytest.approx(1500.0, rel=2e-5)
    assert first.amplitudes == pytest.approx(second.amplitudes, abs=2e-3)
    assert first.amplitudes[0, 1] == pytest.approx([0.5 * np.exp(0.8j), 0.1 * np.exp(-0.5j)], abs=2e-3)
    # The reference's own phase says nothing, so that only its size is compared.
    assert first.parts[1, 0].tolist() == [[False, False], [True, True]]
