"""Long recordings in blocks, tacho and order tracking, and the feature vector."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rotorwise.datasets import Metadata
from rotorwise.datasets.metadata import parse_bearing
from rotorwise.datasets.recording import Channel, GearPair, Nameplate, OperatingCondition, Recording
from rotorwise.diagnose import analyse, analyse_recording, pipeline
from rotorwise.diagnose.feature_transformer import RecordingFeatures
from rotorwise.diagnose.features import FEATURES, feature_names, features
from rotorwise.diagnose.observe import observe
from rotorwise.simulators.rotor_dynamics.rolling_bearing import find_bearing
from rotorwise.simulators.synthetic_vibration import ImpactTrain

from .conftest import RATE_HZ, SPEED_HZ, Make

ORDERS = find_bearing("6205").defect_orders()


@pytest.fixture
def growing(make: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a recording of six blocks whose outer race fails in the fourth."""
    block = 32_768
    monkeypatch.setattr(pipeline, "BLOCK_SAMPLES", block)
    seconds = 3 * block / RATE_HZ
    sound = make(seconds=seconds).signals
    failing = make(seconds=seconds, impacts=(ImpactTrain(ORDERS.outer_race, 5.0, 3000.0),), seed=3).signals
    path = tmp_path / "long.npy"
    np.save(path, np.concatenate([sound, failing], axis=1))
    return path


def test_blocks_are_merged_and_trended(growing: Path) -> None:
    metadata = Metadata(rate_hz=RATE_HZ, units=("m/s2",), speed_rpm=1480.0, bearings=(parse_bearing("6205"),))
    seen = []
    analysis = analyse(growing, metadata=metadata, progress=lambda done, total: seen.append((done, total)))
    assert len(analysis.blocks) == 6
    assert seen[-1] == (6 * 32_768, 6 * 32_768)
    assert analysis.findings[0].fault == "bearing_outer_race"
    # It came and stayed: what counts is the state at the end, not the mean over the file.
    assert analysis.findings[0].probability > 0.9
    assert "3 of 6 blocks, first at 8 s" in analysis.findings[0].summary
    assert [row["top_finding"] for row in analysis.blocks[:3]] == [None] * 3


def test_one_block_and_whole_file_agree(make: Make, tmp_path: Path) -> None:
    recording = make(impacts=(ImpactTrain(ORDERS.outer_race, 5.0, 3000.0),))
    path = tmp_path / "one.npy"
    np.save(path, recording.signals)
    metadata = Metadata(rate_hz=RATE_HZ, units=("m/s2",), speed_rpm=1480.0, bearings=(parse_bearing("6205"),))
    from_file = analyse(path, metadata=metadata)
    in_memory = analyse_recording(replace(recording, nameplate=metadata.nameplate))
    assert from_file.findings[0].probability == pytest.approx(in_memory.findings[0].probability)


def test_tacho_tracks_a_varying_speed() -> None:
    """A run-up smears every line; at constant shaft angle they are sharp again."""
    rate, seconds = 10_000.0, 6.0
    time = np.arange(int(rate * seconds)) / rate
    turns = 20 * time + 0.5 * 2.0 * time**2  # 20 to 32 Hz
    noise = np.random.default_rng(0).normal(0, 0.3, (1, time.size))
    vibration = np.cos(2 * np.pi * turns) + 0.5 * np.cos(2 * np.pi * 7 * turns) + noise
    pulses = (turns % 1.0 < 0.1).astype(float)
    channels = (Channel("x", "acceleration"), Channel("tacho", "tacho"))
    observation = observe(Recording(np.vstack([vibration, pulses]), rate, channels))
    assert observation.order_tracked
    assert observation.speed is not None
    assert observation.speed.method == "tacho"
    assert observation.line(1.0, channel=0).amplitude == pytest.approx(1.0, rel=0.02)
    assert observation.line(7.0, channel=0).amplitude == pytest.approx(0.5, rel=0.03)


def test_features_are_named_documented_and_complete(make: Make) -> None:
    assert len(feature_names()) == len(set(feature_names()))
    assert all(feature.unit and feature.meaning for feature in FEATURES)
    values = features(observe(make()))
    assert tuple(values) == feature_names()
    assert values["1x_amplitude"] == pytest.approx(0.3, rel=0.05)
    assert values["2x_amplitude"] == pytest.approx(0.12, rel=0.1)
    assert values["speed"] == pytest.approx(SPEED_HZ, rel=1e-3)
    assert values["kurtosis"] == pytest.approx(3.0, abs=0.3)
    shares = [values[f"band_{name}_share"] for name in ("low", "middle", "high")]
    assert sum(shares) == pytest.approx(1.0, abs=1e-6)


def test_features_of_bearing_and_gear(make: Make) -> None:
    outer = features(observe(make(impacts=(ImpactTrain(ORDERS.outer_race, 5.0, 3000.0),))))
    assert outer["outer_race_modulation"] > 0.8 > outer["inner_race_modulation"]
    lines = {1: 0.3, 23.0: 1.0, 22.0: 0.2, 24.0: 0.2}
    gear = features(observe(make(lines=lines, nameplate=Nameplate(gears=(GearPair(23),)))))
    assert gear["mesh_1_signal_to_noise"] > 20
    assert gear["mesh_modulation_index"] == pytest.approx(0.4, rel=0.1)
    assert np.isnan(gear["outer_race_modulation"])


def test_phase_difference_of_two_channels() -> None:
    time = np.arange(40_000) / 8000.0
    angle = 2 * np.pi * 25.0 * time
    noise = np.random.default_rng(1).normal(0, 0.05, (2, time.size))
    signals = np.array([np.cos(angle), np.cos(angle - np.pi / 2)]) + noise
    channels = (Channel("h", "acceleration", None, "horizontal"), Channel("v", "acceleration", None, "vertical"))
    values = features(observe(Recording(signals, 8000.0, channels, OperatingCondition(1500.0))))
    assert values["1x_phase_difference"] == pytest.approx(-90.0, abs=2.0)


def test_phase_against_the_tacho() -> None:
    rate = 8000.0
    time = np.arange(40_000) / rate
    turns = 25.0 * time + 0.0137  # no pulse on a sample, none at the start
    noise = np.random.default_rng(2).normal(0, 0.05, (1, time.size))
    vibration = np.cos(2 * np.pi * turns + np.radians(40.0)) + noise
    pulses = (turns % 1.0 < 0.1).astype(float)
    channels = (Channel("x", "acceleration"), Channel("tacho", "tacho"))
    values = features(observe(Recording(np.vstack([vibration, pulses]), rate, channels)))
    # The edge of a pulse is known to half a sample: 0.6 degrees at this rate and speed.
    assert values["1x_phase"] == pytest.approx(40.0, abs=1.5)


def test_transformer_in_a_pipeline(make: Make) -> None:
    from sklearn.ensemble import HistGradientBoostingClassifier
    from sklearn.pipeline import make_pipeline

    recordings = [make(seed=seed, seconds=1.0, lines={1: 0.3 if seed % 2 else 3.0}) for seed in range(8)]
    labels = [seed % 2 for seed in range(8)]
    model = make_pipeline(RecordingFeatures(missing=-1.0), HistGradientBoostingClassifier(min_samples_leaf=1))
    assert list(model.fit(recordings, labels).predict(recordings)) == labels
    assert len(model[0].get_feature_names_out()) == len(FEATURES)
