"""A wandering speed moves the phase of 1X alike at all channels; noise, hum near 1X and a moving sensor do not."""

import numpy as np
import pytest
from rotorwise.datasets.recording import Channel, Recording
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.phase_wander import phase_wander
from rotorwise.diagnose.gap.waveform import seen_in_waveform, without_hunting

SAMPLES, RATE_HZ, SPEED_HZ = 12_000, 1000.0, 17.3
TIME = np.arange(SAMPLES) / RATE_HZ
#: The band's window, as long as two periods of 3.2 Hz, lets this share of 0.5 Hz through.
HUNTING_HZ = 0.5
CHANNELS = (Channel("a", "displacement"), Channel("b", "displacement"), Channel("tacho", "tacho"))


def _recording(
    turns: np.ndarray, *, added: np.ndarray | float = 0.0, seed: int = 0, lag: np.ndarray | float = 0.0
) -> Recording:
    noise = 0.02 * np.random.default_rng(seed).normal(size=(2, SAMPLES))
    lines = np.stack([np.cos(2 * np.pi * turns + lag), 0.5 * np.cos(2 * np.pi * turns + 1.0 + lag)])
    tacho = (turns % 1 < 0.1).astype(float)
    return Recording(np.concatenate([lines + noise + added, tacho[None]]), RATE_HZ, CHANNELS)


def _turns(change: float) -> np.ndarray:
    """The shaft's turns where its speed hunts by a relative amplitude of ``change``."""
    swing = change / (2 * np.pi * HUNTING_HZ) * np.sin(2 * np.pi * HUNTING_HZ * TIME)
    return SPEED_HZ * (TIME + swing) + 0.3


STEADY = _turns(0.0)


@pytest.mark.parametrize("change", [3e-4, 1e-3])
def test_the_change_of_speed_is_measured(change):
    found, shown = phase_wander(_recording(_turns(change)))
    assert shown
    window = np.hanning(2 * round(RATE_HZ / 3.2) + 1)
    offset = np.arange(window.size) - window.size // 2
    passed = (window * np.cos(2 * np.pi * HUNTING_HZ * offset / RATE_HZ)).sum() / window.sum()
    assert found == pytest.approx(passed * change / np.sqrt(2), rel=0.1)


def test_what_only_the_phase_shows_is_named_against_healthy_records():
    healthy = [_recording(STEADY, seed=i) for i in range(3)]
    wandering = [_recording(_turns(1e-3), seed=10 + i) for i in range(3)]
    assert seen_in_waveform(wandering, healthy, ["a", "b"]) == {"speed_wander": ()}
    # Every machine's speed wanders a little: as much as before is nothing new, and alone it is no news.
    assert seen_in_waveform(wandering, wandering, ["a", "b"]) == {}
    assert seen_in_waveform(wandering, [], ["a", "b"]) == {}
    assert seen_in_waveform(wandering, [one.select([0, 1]) for one in healthy], ["a", "b"]) == {}


def test_the_lag_of_a_resonance_behind_a_speed_that_the_tacho_follows_is_no_wander():
    # The speed hunts by 1.2 % before and now; the phase follows it by ten times that, as beside a resonance.
    turns, lag = _turns(1.2e-2), 0.12 * np.sin(2 * np.pi * HUNTING_HZ * TIME)
    healthy = [_recording(turns, seed=i) for i in range(3)]
    now = [_recording(turns, seed=10 + i, lag=lag) for i in range(3)]
    assert phase_wander(now[0])[0] > 3 * phase_wander(healthy[0])[0]
    assert seen_in_waveform(now, healthy, ["a", "b"]) == {}


def test_lines_beside_an_order_that_follows_a_hunting_shaft_are_left_out():
    lag = 0.04 * np.sin(2 * np.pi * HUNTING_HZ * TIME)
    records = [_recording(STEADY), _recording(_turns(1.2e-2), lag=lag, seed=1)]
    # 1X, what lies 1 Hz and 5 Hz beside it, hum at 8 Hz, and the envelope 1 Hz beside it.
    places = ((1.0, 0.0, False), (1.0, 1.0, False), (1.0, 5.0, False), (0.0, 8.0, False), (1.0, 1.0, True))
    kinds = [LineKind(phase=not f, frequency_hz=f, envelope=e) for _, f, e in places]
    shape = (2, 2, len(places))
    lines = OrderLines(
        (Condition(60 * SPEED_HZ),) * 2,
        ("a", "b"),
        tuple(order for order, *_ in places),
        np.ones(shape, dtype=complex),
        np.full(shape, 0.1),
        tuple(kinds),
    )
    seen = without_hunting(lines, records).seen
    assert seen[0].all()
    assert seen[1].tolist() == [[True, False, True, True, True]] * 2


def test_what_noise_makes_of_the_phase_at_another_speed_hides_no_wander():
    slow = (tacho := 0.4 * _turns(0.0)) % 1 < 0.1
    lines = 0.002 * np.stack([np.cos(2 * np.pi * tacho), np.cos(2 * np.pi * tacho + 1.0)])
    noise = 0.02 * np.random.default_rng(5).normal(size=(2, SAMPLES))
    loud = Recording(np.concatenate([lines + noise, slow[None].astype(float)]), RATE_HZ, CHANNELS)
    assert phase_wander(loud)[0] > 1e-3
    healthy = [loud, *(_recording(STEADY, seed=i) for i in range(3))]
    wandering = [_recording(_turns(1e-3), seed=10 + i) for i in range(3)]
    assert seen_in_waveform(wandering, healthy, ["a", "b"]) == {"speed_wander": ()}


def test_a_line_close_to_1x_noise_and_a_swinging_gain_are_no_wander():
    hum = np.stack([0.05 * np.cos(2 * np.pi * 18.1 * TIME), 0.01 * np.cos(2 * np.pi * 18.1 * TIME + 2.0)])
    swinging = 0.05 * np.sin(2 * np.pi * HUNTING_HZ * TIME) * np.cos(2 * np.pi * STEADY)
    for added in (0.0, hum, swinging):
        assert not phase_wander(_recording(STEADY, added=added))[1]


def test_without_a_tacho_or_in_a_short_record_nothing_is_said():
    whole = _recording(_turns(1e-3))
    assert phase_wander(whole.select([0, 1])) == (0.0, False)
    assert phase_wander(Recording(whole.signals[:, :1500], RATE_HZ, CHANNELS)) == (0.0, False)
