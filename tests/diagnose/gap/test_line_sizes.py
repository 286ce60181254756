"""Sizes of lines without phase: closed forms, and noise that must not look like a line."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.line_sizes import (
    envelope_noise,
    high_envelope,
    least_seconds,
    line_sizes,
    mean_envelope_in_noise,
)
from rotorwise.diagnose.gap.lines import LineKind

RATE_HZ, SPEED_HZ, SAMPLES = 5000.0, 25.0, 20000
TIME_S = np.arange(SAMPLES) / RATE_HZ
TURNS = SPEED_HZ * TIME_S
PLAIN, ENVELOPE = LineKind(phase=False), LineKind(phase=False, envelope=True)
LOCKED = np.array([1.0, 2.0, 3.0])


def _sizes(signal, orders, kinds, *, locked=(0.0, 0.0, 0.0)):
    found = line_sizes(
        signal[None],
        rate_hz=RATE_HZ,
        turns=TURNS,
        locked=(LOCKED, np.array([locked], dtype=complex)),
        orders=orders,
        kinds=kinds,
        accelerations=[True],
    )
    return found[0][0], found[1][0]


def test_a_sine_between_the_orders_has_its_amplitude():
    size, _ = _sizes(0.3 * np.cos(2 * np.pi * 2.44 * TURNS + 0.4), [2.44], [PLAIN])
    assert size == pytest.approx([0.3], rel=0.01)


def test_a_line_at_a_fixed_frequency():
    kind = LineKind(phase=False, frequency_hz=60.0)
    size, _ = _sizes(0.2 * np.sin(2 * np.pi * 60 * TIME_S), [0.0], [kind])
    assert size == pytest.approx([0.2], rel=0.01)


def test_a_slipping_line_keeps_its_power():
    # Its frequency wanders by half a percent: the peak sinks, the band's power stays.
    wander = np.cumsum(np.random.default_rng(0).normal(size=SAMPLES)) * 2e-3
    size, _ = _sizes(0.3 * np.cos(2 * np.pi * 12.37 * TURNS + wander), [12.37], [PLAIN])
    assert size == pytest.approx([0.3], rel=0.15)


def test_orders_of_the_shaft_do_not_leak_into_their_neighbours():
    signal = np.cos(2 * np.pi * 3 * TURNS)
    size, _ = _sizes(signal, [3.12], [PLAIN], locked=(0.0, 0.0, 1.0))
    assert size[0] < 1e-3


@pytest.mark.parametrize(("speed_hz", "beside"), [(40.0, 0.05), (17.0, 0.0)])
def test_a_sideband_at_an_order_is_no_line_at_that_distance_in_hz(speed_hz, beside):
    """The wheel's sideband lies 4.8 Hz beside the mesh at 17 Hz: a line 5 Hz beside it is not told there."""
    turns = speed_hz * TIME_S
    mesh, own = np.cos(2 * np.pi * 23 * turns), np.cos(2 * np.pi * (23 - 23 / 81) * turns)
    kinds = [PLAIN, LineKind(phase=False, frequency_hz=-5.0)]
    noise = 1e-4 * np.random.default_rng(2).normal(size=SAMPLES)
    (sizes,), (deviations,) = line_sizes(
        (mesh + 0.1 * own + beside * np.cos(2 * np.pi * (23 * turns - 5.0 * TIME_S)) + noise)[None],
        rate_hz=RATE_HZ,
        turns=turns,
        locked=(LOCKED, np.zeros((1, 3), dtype=complex)),
        orders=[23 - 23 / 81, 23.0],
        kinds=kinds,
        accelerations=[True],
    )
    assert sizes[1] > 0.03
    assert (sizes[1] > 3 * deviations[1]) == bool(beside)
    assert sizes[0] == pytest.approx(0.1, rel=0.05)
    assert sizes[0] > 3 * deviations[0]


def test_a_sensor_that_warms_up_makes_no_slow_line_and_hides_none():
    noise = 0.05 * np.random.default_rng(3).normal(size=SAMPLES)
    drift = 100 * np.exp(-TIME_S / (6 * TIME_S[-1]))
    periods = 3.4 / (SPEED_HZ * TIME_S[-1])
    size, deviation = _sizes(noise + drift, [periods], [PLAIN])
    assert size[0] < 2 * deviation[0] < 0.02
    there, _ = _sizes(noise + drift + 0.3 * np.cos(2 * np.pi * periods * TURNS + 0.4), [periods], [PLAIN])
    assert there == pytest.approx([0.3], rel=0.05)


def test_a_line_too_close_to_a_shaft_order_is_not_seen():
    _, deviation = _sizes(np.cos(2 * np.pi * 2.005 * TURNS), [2.005], [PLAIN])
    assert np.isinf(deviation[0])


def test_a_line_on_the_flank_of_a_shaft_order_is_seen_where_the_order_is_the_smaller_one():
    # An oil whirl in a record of 50 turns is so near half an order.
    order = 3 - 2.6 / TURNS[-1]
    line = 0.3 * np.cos(2 * np.pi * order * TURNS + 0.4)
    size, deviation = _sizes(line + 0.01 * np.cos(6 * np.pi * TURNS), [order], [PLAIN], locked=(0.0, 0.0, 0.01))
    assert size == pytest.approx([0.3], rel=0.1)
    assert deviation[0] < 0.05
    # What is left of an order that hunts is no line.
    left = np.cos(6 * np.pi * TURNS + 0.3 * np.sin(2 * np.pi * TIME_S))
    size, deviation = _sizes(left, [order], [PLAIN])
    assert size[0] < 2 * deviation[0]


def test_the_envelope_shows_the_depth_of_a_modulation():
    carrier = np.cos(2 * np.pi * 1200 * TIME_S)
    size, _ = _sizes((1 + 0.5 * np.cos(2 * np.pi * 2.95 * TURNS)) * carrier, [2.95], [ENVELOPE])
    assert size == pytest.approx([0.5], rel=0.02)


@pytest.mark.parametrize("kind", [PLAIN, ENVELOPE])
def test_noise_is_no_line(kind):
    generator = np.random.default_rng(1)
    far = 0
    for _ in range(40):
        size, deviation = _sizes(generator.normal(size=SAMPLES), [2.44, 2.95, 4.4, 5.6], [kind] * 4)
        far += int((size > 3 * deviation).sum())
    # 160 looks; a normal variable would be beyond 3 in 0.2 of them.
    assert far <= 1


def test_channels_that_are_no_accelerations_have_no_envelope_lines():
    _, deviation = line_sizes(
        np.ones((1, SAMPLES)) * np.cos(7 * TIME_S),
        rate_hz=RATE_HZ,
        turns=TURNS,
        locked=(LOCKED, np.zeros((1, 3), dtype=complex)),
        orders=[2.95],
        kinds=[ENVELOPE],
        accelerations=[False],
    )
    assert np.isinf(deviation).all()


def test_a_band_beside_a_larger_line_says_little():
    # Three lines of the spectrum apart: what the small one's band holds is the large one's lobe.
    apart = 3 / (SAMPLES / RATE_HZ) / SPEED_HZ
    size, deviation = _sizes(0.3 * np.cos(2 * np.pi * 2.4 * TURNS), [2.4, 2.4 + apart], [PLAIN, PLAIN])
    assert size[0] == pytest.approx(0.3, rel=0.01)
    assert size[1] > 0.01
    assert deviation[0] < 0.1
    assert deviation[1] > 0.29


@pytest.mark.parametrize("beside", [-5.0, 5.0])
def test_a_record_of_the_least_length_tells_a_line_from_the_mesh_that_it_stands_beside(beside):
    swing, kind = 0.2, LineKind(phase=False, frequency_hz=beside)
    part = slice(round(least_seconds(23.0, kind, SPEED_HZ) * RATE_HZ) + 1)
    angle = 2 * np.pi * TURNS[part]
    found = line_sizes(
        ((1 + swing * np.cos(2 * np.pi * 5.0 * TIME_S)[part]) * np.cos(23 * angle))[None],
        rate_hz=RATE_HZ,
        turns=TURNS[part],
        locked=(LOCKED, np.zeros((1, 3), dtype=complex)),
        orders=[23.0],
        kinds=[kind],
        accelerations=[True],
        doubted=False,
    )[0]
    # The floor beside the line holds some of the mesh's skirt; sizes are compared to a half.
    assert found[0, 0] == pytest.approx(swing / 2, rel=0.2)


def test_an_envelope_in_noise_has_the_mean_of_rice():
    random = np.random.default_rng(0)
    size = np.array([[0.0, 0.3, 1.0, 3.0, 50.0]])
    noise = random.normal(size=(400_000, 2))
    drawn = [np.hypot(m + 0.7 * noise[:, 0], 0.7 * noise[:, 1]).mean() for m in size[0]]
    found = mean_envelope_in_noise(size, np.array([[0.7]]))[0]
    assert found == pytest.approx(drawn, rel=3e-3)
    # Closed forms: of nothing, and of much more than the noise.
    assert found[0] == pytest.approx(0.7 * np.sqrt(np.pi / 2), rel=1e-12)
    assert found[-1] == pytest.approx(50 + 0.7**2 / 100, rel=1e-6)
    assert mean_envelope_in_noise(size, np.zeros((1, 1)))[0] == pytest.approx(size[0], abs=1e-6)


def test_a_simulated_envelope_is_hidden_by_the_noise_of_the_recordings():
    """The same modulation, in noise and without: told of the noise, the silent record shows what the noisy one does."""
    carrier = 0.2 * (1 + 0.5 * np.cos(2 * np.pi * 2.95 * TURNS)) * np.cos(2 * np.pi * 1200 * TIME_S)
    noisy = carrier + 0.5 * np.random.default_rng(2).normal(size=SAMPLES)
    noise = envelope_noise(noisy[None], rate_hz=RATE_HZ, speed_hz=SPEED_HZ)
    # White noise, of which the band from 0.1 to 0.4 of the rate holds 60 %.
    assert noise[0] == pytest.approx(0.5 * np.sqrt(0.6), rel=0.03)
    how = {"rate_hz": RATE_HZ, "turns": TURNS, "locked": (LOCKED, np.zeros((1, 3))), "orders": [2.95]}
    how |= {"kinds": [ENVELOPE], "accelerations": [True]}
    measured, deviation = (one[0, 0] for one in line_sizes(noisy[None], **how))
    plain, told = (line_sizes(carrier[None], **how, missing_noise=given)[0][0, 0] for given in (None, noise))
    assert told < 0.4 * plain
    assert abs(told - measured) < 2 * deviation


def test_the_envelope_is_that_of_the_high_band():
    signal = np.cos(2 * np.pi * 30 * TIME_S) + 0.4 * np.cos(2 * np.pi * 1200 * TIME_S)
    middle = high_envelope(signal[None], rate_hz=RATE_HZ, speed_hz=SPEED_HZ)[0, 1000:-1000]
    assert middle == pytest.approx(np.full(middle.size, 0.4), rel=1e-3)


@pytest.mark.parametrize(("drift_hz", "away_hz"), [(0.1, 0.9), (0.2, 1.0), (0.2, -1.0), (0.4, 1.2)])
def test_the_skirt_of_a_drifting_order_is_no_line(drift_hz, away_hz):
    # Without a tacho the speed counts as steady: the order smears, and what is taken off leaves its skirts.
    phase = 2 * np.pi * TURNS + drift_hz * TIME_S[-1] * np.cos(2 * np.pi * TIME_S / TIME_S[-1])
    signal, kind = np.cos(phase), LineKind(phase=False, frequency_hz=SPEED_HZ + away_hz)
    held = 2 * np.mean(signal * np.exp(-2j * np.pi * TURNS))
    size, deviation = _sizes(signal, [0.0], [kind], locked=(held, 0.0, 0.0))
    assert not size[0] > 3 * deviation[0]


def test_a_line_stands_beside_a_steady_order():
    signal = np.cos(2 * np.pi * TURNS) + 0.02 * np.cos(2 * np.pi * (SPEED_HZ + 1.5) * TIME_S)
    size, deviation = _sizes(
        signal, [0.0], [LineKind(phase=False, frequency_hz=SPEED_HZ + 1.5)], locked=(1.0, 0.0, 0.0)
    )
    assert size[0] == pytest.approx(0.02, rel=0.05)
    assert size[0] > 5 * deviation[0]


def test_at_a_rate_too_low_for_an_envelope_its_lines_are_not_seen():
    # The band would begin at 15 times the speed, above its end.
    turns = np.arange(3000) / 1000.0 * 48.0
    signals = np.random.default_rng(3).normal(size=(1, turns.size))
    options = {"rate_hz": 1000.0, "turns": turns, "locked": (np.array([1.0]), np.zeros((1, 1), dtype=complex))}
    kinds = [LineKind(phase=False, envelope=True), LineKind(phase=False)]
    _, deviations = line_sizes(signals, orders=[2.95, 2.95], kinds=kinds, accelerations=[True], **options)
    assert np.isinf(deviations[0, 0])
    assert np.isfinite(deviations[0, 1])


@pytest.mark.parametrize("speed_hz", [30.0, 37.0, 44.0, 60.0])
@pytest.mark.parametrize(("share", "sideband"), [(5e-4, 0.0), (2e-4, 0.0), (2e-4, 0.1)])
def test_the_wander_of_a_mesh_is_no_line_beside_it_and_hides_none(speed_hz, share, sideband):
    random = np.random.default_rng(5)
    seconds, rate_hz = 3.0, 10_000.0
    time_s = np.arange(round(seconds * rate_hz)) / rate_hz
    # Slower than 2 Hz and so little that a tacho with one pulse a turn tells nothing of it.
    rates, phases = random.uniform(0.3, 2.0, 8), random.uniform(0, 2 * np.pi, 8)
    wander = (
        share
        * np.sqrt(2 / 8)
        * np.sum(
            [
                np.sin(2 * np.pi * rate * time_s + at) / (2 * np.pi * rate)
                for rate, at in zip(rates, phases, strict=True)
            ],
            axis=0,
        )
    )
    mesh = 2 * np.pi * 23 * speed_hz * (time_s + wander)
    signal = np.cos(mesh) * (1 + sideband * np.cos(2 * np.pi * 5 * time_s))
    signal = signal + 0.05 * random.normal(size=signal.size)
    sizes, deviations = line_sizes(
        signal[None],
        rate_hz=rate_hz,
        turns=speed_hz * time_s,
        locked=(LOCKED, np.zeros((1, 3), dtype=complex)),
        orders=[23.0, 23.0, 23.0],
        kinds=[PLAIN, *(LineKind(phase=False, frequency_hz=away) for away in (-5.0, 5.0))],
        accelerations=[True],
    )
    assert sizes[0, 0] == pytest.approx(1.0, rel=0.02)
    if sideband:
        assert sizes[0, 1:] == pytest.approx([sideband / 2] * 2, rel=0.2)
    # Where the mesh wanders as far as the line is away, it is not told.
    told = 0.004 * 23 * speed_hz + 2.5 / seconds < 5.0
    assert list(sizes[0, 1:] > 3 * deviations[0, 1:]) == [bool(sideband) and told] * 2
