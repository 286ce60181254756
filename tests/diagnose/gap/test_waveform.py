"""Effects that the waveform shows, each made by the effect itself, and none of them in a healthy record."""

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.datasets.recording import Channel, Recording
from rotorwise.diagnose.gap.lost_samples import LEFT
from rotorwise.diagnose.gap.waveform import WANDER, WANDER_GROWTH, seen_in_waveform, variations

SAMPLES, RATE_HZ = 8000, 1000.0


def _recording(signal: np.ndarray) -> Recording:
    return Recording(signal[None], RATE_HZ, (Channel("a", "displacement"),))


def _healthy(seed: int) -> np.ndarray:
    time = np.arange(SAMPLES) / RATE_HZ
    noise = 0.02 * np.random.default_rng(seed).normal(size=SAMPLES)
    return np.round((np.sin(2 * np.pi * 17.3 * time) + noise) * 2**14) / 2**14


def _gaps(signal: np.ndarray) -> np.ndarray:
    held = signal.copy()
    for start in range(100, SAMPLES, 300):
        held[start : start + 9] = held[start]
    return held


DEFECTS = {
    "clipping": lambda x: np.clip(x, -0.6, 0.6),
    "dropped_samples": _gaps,
    "quantisation": lambda x: np.round(x * 32) / 32,
    "dc_drift": lambda x: x + np.linspace(0.0, 0.5, SAMPLES),
}


@pytest.mark.parametrize("effect", DEFECTS)
def test_each_defect_is_seen_and_no_other(effect):
    healthy = [_recording(_healthy(i)) for i in range(3)]
    bad = [_recording(DEFECTS[effect](_healthy(10 + i))) for i in range(3)]
    assert seen_in_waveform(bad, healthy, ["a"]) == {effect: ("a",)}


def test_single_held_samples_are_lost_ones_where_neighbours_differ_by_many_steps():
    random = np.random.default_rng(4)
    healthy = [_recording(random.normal(size=SAMPLES)) for _ in range(3)]
    lost = random.normal(size=(3, SAMPLES))
    lost[:, 101::40] = lost[:, 100::40][:, : lost[:, 101::40].shape[1]]
    assert seen_in_waveform([_recording(one) for one in lost], healthy, ["a"]) == {"dropped_samples": ("a",)}
    # Equal neighbours by chance, one in twelve where samples differ by five steps, are none.
    for bits in (5.0, 100.0):
        sound = [_recording(np.round(bits * random.normal(size=SAMPLES)) / bits) for _ in range(6)]
        assert "dropped_samples" not in seen_in_waveform(sound[:3], sound[3:], ["a"])


def test_how_many_neighbours_are_equal_by_chance_scatters():
    # 12 bits over a slow line: of 8000 samples some hundred pairs are equal, give or take a dozen.
    random, time = np.random.default_rng(6), np.arange(SAMPLES) / 6400.0
    made = [np.round(120 * np.sin(2 * np.pi * 20.3 * time) + 6 * random.normal(size=SAMPLES)) for _ in range(60)]
    pairs = zip(made[:30], made[30:], strict=True)
    seen = [seen_in_waveform([_recording(now)], [_recording(healthy)], ["a"]) for now, healthy in pairs]
    assert seen == [{}] * 30


def test_a_healthy_record_shows_nothing_and_an_old_defect_is_not_new():
    healthy = [_recording(_healthy(i)) for i in range(3)]
    assert seen_in_waveform([_recording(_healthy(7))], healthy, ["a"]) == {}
    clipped = [_recording(DEFECTS["clipping"](_healthy(i))) for i in range(3)]
    assert seen_in_waveform([_recording(DEFECTS["clipping"](_healthy(8)))], clipped, ["a"]) == {}


def test_a_clipped_probe_is_left_out_where_others_remain():
    from rotorwise.diagnose.gap.lines import Condition, OrderLines
    from rotorwise.diagnose.gap.waveform import with_doubt

    values, steady = np.ones((1, 2, 1)), np.zeros(1)
    lines = OrderLines((Condition(600.0),), ("a", "b"), (1.0,), values.astype(complex), 0.1 * values)
    assert with_doubt(lines, {"clipping": ("a",)}, steady).seen.ravel().tolist() == [False, True]
    # The only probes there are stay, with doubt; a drift loses nothing.
    both = with_doubt(lines, {"clipping": ("a", "b")}, steady)
    assert both.seen.all()
    assert both.deviations.ravel() == pytest.approx(np.hypot(0.1, 0.2))
    assert with_doubt(lines, {"dc_drift": ("a",)}, steady).seen.all()
    # Where the lost samples were put back, by a part of what that changed.
    raw = replace(lines, amplitudes=1.1 * lines.amplitudes)
    doubted = with_doubt(lines, {"clipping": ("a", "b")}, steady, raw)
    assert doubted.deviations == pytest.approx(np.hypot(lines.deviations, LEFT * 0.1 * np.abs(lines.amplitudes)))


def test_where_the_speed_wanders_lines_are_known_no_better_than_a_resonance_lets_them():
    from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
    from rotorwise.diagnose.gap.waveform import with_doubt

    # A resonance with 5 % of damping, at its half-power point: so much its response changes with the speed.
    damping, step = 0.05, 1e-6
    response = [1 / (1 - x**2 + 2j * damping * x) for x in (1 - damping, 1 - damping + step)]
    slope = abs(response[1] - response[0]) / step / abs(response[0])
    conditions = (Condition(600.0), Condition(900.0))
    values = np.full((2, 1, 1), 3.0)
    lines = OrderLines(conditions, ("a",), (1.0,), values.astype(complex), 1e-3 * values)
    variation = np.array([0.01, 0.0])
    doubted = with_doubt(lines, {"speed_wander": ()}, variation).deviations.ravel()
    assert doubted[0] == pytest.approx(3.0 * 0.01 * slope, rel=0.5)
    assert doubted[1] == pytest.approx(3e-3)
    beside = tuple(LineKind(phase=False, frequency_hz=f) for f in (1.0, 11.0))
    wide = OrderLines(conditions, ("a",), (1.0, 1.0), np.ones((2, 1, 2), dtype=complex), np.ones((2, 1, 2)), beside)
    # A sideband at a controller's frequency is the wander's own, one at 11 Hz is not.
    assert with_doubt(wide, {"speed_wander": ()}, variation).seen[:, 0].tolist() == [[False, True], [False, True]]
    # Nor can one at 0.887X be told from it 1.1 Hz below 1X; 20 Hz below it can.
    slow = tuple(replace(one, speed_rpm=rpm) for one, rpm in zip(conditions, (600.0, 12000.0), strict=True))
    found = (LineKind(), LineKind(phase=False))
    line = OrderLines(slow, ("a",), (1.0, 0.887), np.ones((2, 1, 2), dtype=complex), np.ones((2, 1, 2)), found)
    assert with_doubt(line, {"speed_wander": ()}, variation).seen[:, 0].tolist() == [[True, False], [True, True]]
    # A probe of the turning itself shows as much as the speed wanders; what has its phase to the shaft is no wander.
    shown = with_doubt(wide, {"speed_wander": ()}, variation, turning=["a"]).deviations[:, 0, 1]
    assert shown[0] == pytest.approx(
        np.hypot(with_doubt(wide, {"speed_wander": ()}, variation).deviations[0, 0, 1], 0.01 * 20 * np.pi)
    )
    assert shown[1] == pytest.approx(1.0)
    assert with_doubt(lines, {"speed_wander": ()}, variation, turning=["a"]).deviations.ravel() == pytest.approx(
        doubted
    )
    # A speed that varies no more than on the healthy machine says nothing.
    assert with_doubt(lines, {}, variation).deviations == pytest.approx(lines.deviations)


def test_a_slow_vibration_and_coarse_steps_are_no_drift():
    healthy = [_recording(_healthy(i)) for i in range(3)]
    time = np.arange(SAMPLES) / RATE_HZ
    slow = [_recording(_healthy(10 + i) + 0.5 * np.sin(2 * np.pi * (0.5 + 0.05 * i) * time)) for i in range(3)]
    assert seen_in_waveform(slow, healthy, ["a"]) == {}
    # A speed that hardly changes, in steps as large as its deviation.
    random = np.random.default_rng(5)
    still = [_recording(100 + 1e-4 * random.normal(size=SAMPLES)) for _ in range(6)]
    coarse = [_recording(np.round(1e4 * one.signals[0]) / 1e4) for one in still[3:]]
    assert seen_in_waveform(coarse, still[:3], ["a"]).keys() == {"quantisation"}


def test_a_single_swing_is_no_drift_and_a_wandering_speed_is_none_of_its_sensor():
    healthy = [_recording(_healthy(i)) for i in range(3)]
    time = np.arange(SAMPLES) / RATE_HZ
    swing = [_recording(_healthy(10 + i) + np.sin(2 * np.pi * time / time[-1] + i)) for i in range(3)]
    assert seen_in_waveform(swing, healthy, ["a"]) == {}
    steady, wandering = (_with_tacho(share) for share in (0.0, 0.05))
    assert seen_in_waveform([wandering], [steady], ["speed", "a"]).keys() == {"speed_wander"}


def test_a_speed_that_varies_by_less_is_news_where_the_healthy_record_at_that_speed_has_far_less():
    def picked_up(share: float) -> Recording:
        """The same, with a tacho whose edges are known to far less than a sample."""
        one = _with_tacho(share)
        turns = np.cumsum(17.3 * (1 + share * np.linspace(-0.5, 0.5, SAMPLES))) / RATE_HZ
        return replace(one, signals=np.concatenate([np.sin(2 * np.pi * turns)[None], one.signals[1:]]))

    steady, wandering = picked_up(2e-4), picked_up(1.5e-3)
    assert WANDER_GROWTH * variations([steady])[0] < variations([wandering])[0] < WANDER
    assert seen_in_waveform([wandering] * 2, [steady], ["a"]) == {"speed_wander": ()}
    assert seen_in_waveform([wandering, steady], [steady], ["a"]) == {}
    assert seen_in_waveform([wandering] * 2, [wandering], ["a"]) == {}
    assert seen_in_waveform([wandering] * 2, [], ["a"]) == {}


def _with_tacho(share: float) -> Recording:
    """A shaft of about 17 Hz that becomes faster by a share within the record: tacho, speed sensor, vibration."""
    speed = 17.3 * (1 + share * np.linspace(-0.5, 0.5, SAMPLES))
    turns = np.cumsum(speed) / RATE_HZ
    noise = np.random.default_rng(1).normal(size=(2, SAMPLES))
    tacho = (turns % 1 < 0.3).astype(float)
    signals = np.stack([tacho, 2 * np.pi * speed + 0.01 * noise[0], np.sin(2 * np.pi * turns) + 0.02 * noise[1]])
    channels = (Channel("tacho", "tacho"), Channel("speed", "rotational_speed"), Channel("a", "displacement"))
    return Recording(signals, RATE_HZ, channels, pulses_per_revolution=1)


def test_an_offset_that_dies_out_is_a_drift():
    healthy = [_recording(_healthy(i)) for i in range(3)]
    dying = np.exp(-np.linspace(0.0, 5.0, SAMPLES))
    assert seen_in_waveform([_recording(_healthy(9) + dying)], healthy, ["a"]) == {"dc_drift": ("a",)}


def test_what_the_waveform_shows_joins_every_hypothesis():
    from rotorwise.diagnose.gap.verdict import _with_shown

    found = _with_shown({(): 0.3, ("unknown",): 0.2, ("unbalance",): 0.5}, ("clipping",))
    assert found == {("clipping",): pytest.approx(0.5), ("clipping", "unbalance"): pytest.approx(0.5)}


def test_only_what_spreads_lines_accounts_for_those_that_nothing_explains():
    from rotorwise.diagnose.gap.verdict import _with_shown
    from rotorwise.diagnose.gap.waveform import accounts_for_lines

    assert accounts_for_lines({"clipping": ("a", "b")}, ("a", "b"), mended=False)
    assert not accounts_for_lines({"clipping": ("a", "b")}, ("a", "b"), mended=True)
    assert accounts_for_lines({"speed_wander": ()}, ("a",), mended=True)
    assert not accounts_for_lines({"clipping": ("a",), "quantisation": ("b",)}, ("a", "b"), mended=False)
    found = _with_shown({(): 0.3, ("unknown",): 0.7}, ("quantisation",), is_unknown_beside=True)
    assert found == {("unknown",): pytest.approx(0.7), ("quantisation",): pytest.approx(0.3)}
