"""Features that carry over: gain, length and sampling rate change nothing; the noise of machines is as stated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.datasets import build
from rotorwise.datasets.recording import Channel, MountedBearing, Nameplate, OperatingCondition, Recording
from rotorwise.diagnose.learning.absolute_features import absolute_features
from rotorwise.diagnose.learning.feature_table import feature_table
from rotorwise.diagnose.learning.machine_noise import NOISE_RMS_M_S2, MachineNoise, with_machine_noise
from rotorwise.diagnose.learning.relative_features import level_names, levels, relative_features
from rotorwise.diagnose.observe import observe
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.rotor_dynamics.rolling_bearing import find_bearing

SPEED_HZ, BEARING = 25.0, find_bearing("6205")


def record(*, seconds: float = 4.0, rate_hz: float = 12_000.0, gain: float = 1.0) -> Recording:
    """Return a shaft's lines with noise whose power beats at the outer race's order, by half."""
    stream = np.random.default_rng(0)
    time = np.arange(round(seconds * rate_hz)) / rate_hz
    order = BEARING.defect_orders().outer_race
    beat = 1 + 0.7 * np.cos(2 * np.pi * order * SPEED_HZ * time)
    signal = np.cos(2 * np.pi * SPEED_HZ * time) + 0.2 * np.cos(4 * np.pi * SPEED_HZ * time + 1)
    # Noise of the same density, whatever the rate.
    signal += 0.3 * np.sqrt(rate_hz / 12_000.0) * beat * stream.normal(size=time.size)
    return Recording(
        gain * signal[None],
        rate_hz,
        (Channel("a", "acceleration"),),
        OperatingCondition(60 * SPEED_HZ),
        Nameplate(bearings=(MountedBearing(BEARING),)),
    )


def test_gain_changes_nothing_but_levels() -> None:
    one, many = (observe(record(gain=gain)) for gain in (1.0, 37.0))
    for name, value in relative_features(one).items():
        assert relative_features(many)[name] == pytest.approx(value, rel=1e-6, abs=1e-9, nan_ok=True), name
    for name in level_names():
        assert levels(many)[name] - levels(one)[name] == pytest.approx(np.log10(37.0), abs=1e-6)


@pytest.mark.parametrize("other", [{"seconds": 12.0}, {"rate_hz": 24_000.0}], ids=["longer", "faster"])
def test_length_and_rate_hardly_change_contrasts_and_depths(other) -> None:
    first, second = relative_features(observe(record())), relative_features(observe(record(**other)))
    assert first["outer_race_depth"] > 0.3
    assert second["outer_race_depth"] == pytest.approx(first["outer_race_depth"], abs=0.12)
    for name in ("1x_contrast", "2x_contrast"):
        # The noise is the median of the 100 bins or more of one order: 0.06 decades (1 / (ln 2 sqrt 100) of the power)
        # of scatter in each of the two, whose difference stays within four standard deviations.
        assert second[name] == pytest.approx(first[name], abs=4 * np.sqrt(2) * 0.063), name
    assert second["inner_race_depth"] < 0.15
    assert first["inner_race_depth"] < 0.15


def test_absolute_features_are_amplitudes_and_rms() -> None:
    found = absolute_features(observe(record(gain=2.0)))
    assert found["a.1x_amplitude"] == pytest.approx(2.0, rel=0.02)
    assert found["a.2x_amplitude"] == pytest.approx(0.4, rel=0.1)
    # 2X leads 1X turned twice by 1 rad: relative phases need no tacho.
    angle = np.angle(found["a.2x_relative_real"] + 1j * found["a.2x_relative_imaginary"])
    assert angle == pytest.approx(1.0, abs=0.1)
    velocity = np.hypot(2.0 / (2 * np.pi * SPEED_HZ), 0.4 / (4 * np.pi * SPEED_HZ)) / np.sqrt(2)
    assert found["a.velocity_rms"] == pytest.approx(velocity, rel=0.05)


def test_a_machines_noise_is_its_own_and_stays_within_its_range() -> None:
    silent = record()
    silent = replace(silent, signals=np.zeros_like(silent.signals))

    def noise(group: str, seed: int, **parts: bool) -> np.ndarray:
        row = {"machine": "m", "group": group, "seed": seed, "speed_rpm": 60 * SPEED_HZ}
        return with_machine_noise(silent, row, MachineNoise(1, **parts)).signals[0]

    assert np.array_equal(noise("m-1", 5), noise("m-1", 5))
    assert not np.array_equal(noise("m-1", 5), noise("m-1", 6))
    assert np.all(noise("m-1", 5, broadband=False, lines=False) == 0)
    sizes = {group: [noise(group, seed, lines=False).std() for seed in range(4)] for group in ("m-1", "m-2", "m-3")}
    low, high = NOISE_RMS_M_S2
    for own in sizes.values():
        assert low / 5 < min(own) <= max(own) < 5 * high
        # The same machine, record by record, within a factor; e^(4 x 0.17 x sqrt 2) for two of them.
        assert max(own) / min(own) < 2.7


def test_a_table_has_a_row_a_signal_whoever_computes_it(tmp_path) -> None:
    store = build("tiny", tmp_path / "set", workers=1, limit=6)
    told: list[tuple[int, int]] = []
    table = feature_table(store, kinds=("relative", "levels", "absolute"), tell=lambda *at: told.append(at))
    again = feature_table(str(tmp_path / "set"), kinds=("relative", "levels", "absolute"))
    assert len(table) + len(table.left_out) == sum(facts["rows"] for facts in store.parts().values())
    assert np.array_equal(table.values, again.values, equal_nan=True)
    assert told[-1][0] == told[-1][1]
    assert len(table.groups) == len(table)
    assert any(name.startswith("absolute.") for name in table.names)
    only = table.only(["1x_contrast"]).where(np.arange(len(table)) < 2)
    assert only.values.shape == (2, 1)
    with pytest.raises(InvalidValueError, match="No feature"):
        table.only(["loudness"])
    with pytest.raises(InvalidValueError, match="Kind of features"):
        feature_table(store, kinds=("all",))
