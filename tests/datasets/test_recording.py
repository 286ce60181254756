"""Recordings refuse what does not fit together, and select keeps samples with their channels."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from rotorwise.datasets import Channel, Nameplate, OperatingCondition, Recording
from rotorwise.datasets.errors import InvalidValueError
from rotorwise.datasets.recording import GearPair

CHANNELS = (Channel("a", "acceleration"), Channel("b", "tacho"), Channel("c"))


def test_shape_rate_and_duration() -> None:
    recording = Recording(np.zeros((3, 500)), 1000.0, CHANNELS)
    assert (recording.samples, recording.duration_s) == (500, 0.5)
    for signals, rate in (
        (np.zeros((2, 5)), 1.0),
        (np.zeros(5), 1.0),
        (np.zeros((3, 5)), 0.0),
        (np.zeros((3, 5)), math.nan),
    ):
        with pytest.raises(InvalidValueError, match="allowed"):
            Recording(signals, rate, CHANNELS)
    with pytest.raises(dataclasses.FrozenInstanceError):
        recording.rate_hz = 5.0  # pyright: ignore[reportAttributeAccessIssue]


def test_select_keeps_samples_with_their_channels() -> None:
    recording = Recording(np.arange(6.0).reshape(3, 2), 1.0, CHANNELS)
    chosen = recording.select([2, 0])
    assert [one.name for one in chosen.channels] == ["c", "a"]
    np.testing.assert_array_equal(chosen.signals, [[4, 5], [0, 1]])


def test_channels_know_their_unit_and_whether_they_vibrate() -> None:
    assert [one.unit for one in CHANNELS] == ["m/s2", "V", None]
    assert [one.is_vibration for one in CHANNELS] == [True, False, True]
    for wrong in ({"quantity": "speed"}, {"direction": "up"}):
        with pytest.raises(InvalidValueError, match="allowed"):
            Channel("a", **wrong)


@pytest.mark.parametrize("speed", [-1.0, math.nan, math.inf])
def test_impossible_speeds(speed: float) -> None:
    with pytest.raises(InvalidValueError, match="rpm"):
        OperatingCondition(speed_rpm=speed)


def test_gears_and_mounting() -> None:
    pair = GearPair(23, 46, 2.0)
    assert (pair.mesh_order, pair.driven_ratio) == (46.0, 1.0)  # z1 n1 = z2 n2
    assert GearPair(23).driven_ratio is None
    with pytest.raises(InvalidValueError, match="teeth"):
        GearPair(3)
    with pytest.raises(InvalidValueError, match="flexible"):
        Nameplate(mounting="soft")
