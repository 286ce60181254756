"""Sources of shaft lines: recovered exactly from the machine's own lines, whatever the mark; a zone that follows."""

import numpy as np
import pytest
from rotorwise.datasets.recording import Channel, Recording
from rotorwise.diagnose.learning.severity.feature_row import ShaftLines, feature_row, shaft_lines
from rotorwise.diagnose.learning.severity.predicted_zone import disagreement, margin, predicted_zone
from rotorwise.diagnose.learning.severity.unit_responses import fit_sources, source_features
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

from .drawn_machines import shown_zone

TRUTH = {"offset": 8e-5 * np.exp(0.7j), "angle": 4e-3 * np.exp(-1.1j), "unbalance": 3e-5 * np.exp(2.0j)}
STEP = 800  # of the speed: 2981 rpm


def lines_of(responses, vectors, *, mark: float = 0.0, step: int = STEP) -> ShaftLines:
    speed = responses.speed_rpm(step)
    found = harmonic_balance(responses.machine_with(vectors), speed_rpm=speed).amplitudes[:, 1:4]
    found = found * np.exp(-1j * mark * np.arange(1, 4))
    return ShaftLines(responses.probes, speed, found, np.full(found.shape, 1e-10))


@pytest.mark.parametrize("turn", [0, 17])
def test_the_sources_of_a_linear_machine_are_found_back(responses, turn):
    fit = fit_sources(responses, lines_of(responses, TRUTH, mark=turn * 2 * np.pi / 72))
    assert fit.speed_rpm == pytest.approx(responses.speed_rpm(STEP))
    assert fit.mark_rad == pytest.approx(turn * 2 * np.pi / 72)
    for name, vector in TRUTH.items():
        # The balance of eight harmonics differs from that of six by less than 1e-4.
        assert abs(fit.vectors[name] - vector) < 1e-4 * abs(vector)
    assert fit.misfit < 1e-3


def test_a_machine_with_higher_modes_is_recognised_as_such(responses):
    """Lines of the reference machine at 0.9 of the speed, told to be of the full speed."""
    slow = lines_of(responses, TRUTH, step=STEP - 10)
    told = ShaftLines(slow.probes, responses.speed_rpm(STEP), slow.amplitudes, slow.noise)
    values = source_features(responses, told)
    assert values["speed_ratio"] == pytest.approx(-0.1)
    assert values["unshifted.misfit"] > values["offset+angle+unbalance.misfit"] + 1.0


def test_the_zone_of_the_true_sizes_is_the_zone_of_the_machine(responses):
    lines = lines_of(responses, TRUTH)
    shown = shown_zone(responses.machine_with(TRUTH), lines.speed_rpm)
    sizes = {name: abs(TRUTH[name]) for name in ("offset", "angle")}
    found = predicted_zone(responses, lines, sizes, low=sizes, high=sizes)
    assert found.level == pytest.approx(shown.value, rel=2e-3)
    assert (found.zone, found.lowest, found.highest) == (shown.zone, shown.zone, shown.zone)
    assert disagreement(found, shown) == ""


def test_ends_of_an_interval_widen_the_zone_and_a_contradiction_is_told(responses):
    lines = lines_of(responses, {**TRUTH, "unbalance": 0.0})
    shown = shown_zone(responses.machine_with(TRUTH), lines.speed_rpm)
    assert shown.zone == "D"
    sizes = {"offset": 8e-5, "angle": 4e-3}
    wide = predicted_zone(responses, lines, sizes, low={"offset": 0.0, "angle": 0.0}, high=sizes)
    assert wide.lowest == "A"
    small = {"offset": 1e-6, "angle": 1e-5, "unbalance": 1e-7}
    found = predicted_zone(responses, lines, small, low=small, high=small)
    assert found.zone == "A"
    assert margin(shown) > 0.1
    assert "something else vibrates" in disagreement(found, shown)


def test_lines_of_a_known_signal():
    rate, speed = 2000.0, 25.0
    time = np.arange(4000) / rate
    stream = np.random.default_rng(0)
    waves = [2e-5 * np.cos(2 * np.pi * speed * time + 0.4), 1e-5 * np.cos(2 * np.pi * speed * time + 1.4)]
    waves[0] = waves[0] + 3e-6 * np.cos(4 * np.pi * speed * time + 1.0)
    signals = np.array(waves) + 1e-8 * stream.normal(size=(2, time.size))
    pulses = (time * speed % 1.0 < 0.3).astype(float)
    channels = (Channel("a", "displacement"), Channel("b", "displacement"), Channel("tacho", "tacho"))
    there = Recording(np.vstack([signals, pulses]), rate, channels)
    lines = shaft_lines(there, probes=["a", "b"])
    values = feature_row(there, lines)
    assert lines.speed_rpm == pytest.approx(1500, rel=1e-3)
    assert 10 ** values["a.1x"] == pytest.approx(2e-5, rel=1e-3)
    assert 10 ** values["b.1x"] == pytest.approx(1e-5, rel=1e-3)
    assert np.arctan2(values["b.1x_sin"], values["b.1x_cos"]) == pytest.approx(1.0, abs=1e-2)
    # 2X leads by 1.0 rad, twice the phase of 1X is 0.8 rad.
    assert np.arctan2(values["a.2x_sin"], values["a.2x_cos"]) == pytest.approx(0.2, abs=1e-2)
    # Nothing turns at 3X: the phase has no weight.
    assert np.hypot(values["b.3x_sin"], values["b.3x_cos"]) < 0.9
    assert 10 ** values["b.3x"] < 1e-8
    with pytest.raises(InvalidValueError, match="No channel 'c'; the recording has a, b, tacho"):
        shaft_lines(there, probes=["c"])
