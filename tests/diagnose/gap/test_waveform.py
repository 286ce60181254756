"""Effects that the waveform shows, each made by the effect itself, and none of them in a healthy record."""

import numpy as np
import pytest
from rotorwise.datasets.recording import Channel, Recording
from rotorwise.diagnose.gap.waveform import seen_in_waveform

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


def test_a_healthy_record_shows_nothing_and_an_old_defect_is_not_new():
    healthy = [_recording(_healthy(i)) for i in range(3)]
    assert seen_in_waveform([_recording(_healthy(7))], healthy, ["a"]) == {}
    clipped = [_recording(DEFECTS["clipping"](_healthy(i))) for i in range(3)]
    assert seen_in_waveform([_recording(DEFECTS["clipping"](_healthy(8)))], clipped, ["a"]) == {}


def test_a_clipped_probe_is_left_out_where_others_remain():
    from rotorwise.diagnose.gap.lines import Condition, OrderLines
    from rotorwise.diagnose.gap.waveform import with_doubt

    values = np.ones((1, 2, 1))
    lines = OrderLines((Condition(600.0),), ("a", "b"), (1.0,), values.astype(complex), 0.1 * values)
    assert with_doubt(lines, {"clipping": ("a",)}).seen.ravel().tolist() == [False, True]
    # The only probes there are stay, with doubt; a drift loses nothing.
    both = with_doubt(lines, {"clipping": ("a", "b")})
    assert both.seen.all()
    assert both.deviations.ravel() == pytest.approx(np.hypot(0.1, 0.2))
    assert with_doubt(lines, {"dc_drift": ("a",)}).seen.all()


def test_what_the_waveform_shows_joins_every_hypothesis():
    from rotorwise.diagnose.gap.verdict import _with_shown

    found = _with_shown({(): 0.3, ("unknown",): 0.2, ("unbalance",): 0.5}, ("clipping",))
    assert found == {("clipping",): pytest.approx(0.5), ("clipping", "unbalance"): pytest.approx(0.5)}


def test_only_what_spreads_lines_accounts_for_those_that_nothing_explains():
    from rotorwise.diagnose.gap.verdict import _with_shown
    from rotorwise.diagnose.gap.waveform import accounts_for_lines

    assert accounts_for_lines({"clipping": ("a", "b")}, ("a", "b"))
    assert accounts_for_lines({"speed_wander": ()}, ("a",))
    assert not accounts_for_lines({"clipping": ("a",), "quantisation": ("b",)}, ("a", "b"))
    found = _with_shown({(): 0.3, ("unknown",): 0.7}, ("quantisation",), is_unknown_beside=True)
    assert found == {("unknown",): pytest.approx(0.7), ("quantisation",): pytest.approx(0.3)}
