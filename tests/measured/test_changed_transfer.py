"""The measured bench was taken apart between its classes: its axial sensor sees the machine by another way since."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest
from rotorwise.diagnose.gap.changed_transfer import changed_transfers
from rotorwise.diagnose.gap.observe import shaft_speed_rpm

_SPEC = importlib.util.spec_from_file_location("gap_table", Path(__file__).with_name("gap_table.py"))
assert _SPEC is not None
assert _SPEC.loader is not None
table = importlib.util.module_from_spec(_SPEC)
sys.modules["gap_table"] = table
_SPEC.loader.exec_module(table)

pytestmark = [
    pytest.mark.measured,
    pytest.mark.skipif(not table.DATA.is_dir(), reason=f"measured recordings are not at {table.DATA}"),
]
#: Recorded after the machine had been put together anew, says the card of the recordings.
TAKEN_APART = ("misaligned", "bent shaft", "outer race", "inner race")


@pytest.mark.parametrize("name", table.CLASSES)
def test_the_axial_sensor_of_what_was_taken_apart(name: str) -> None:
    read = table.campaign(name)
    speeds = [[shaft_speed_rpm(one) for one in each] for each in (read.recordings, read.baseline)]
    probes = ["housing_b_x", "housing_b_y", "housing_b_axial"]
    found = changed_transfers(read.recordings, speeds[0], read.baseline, speeds[1], probes)
    assert [one.channel for one in found] == (["housing_b_axial"] if name in TAKEN_APART else [])
    # The card: 45 to 200 Hz lower by 7 to 23 dB, 1 to 3 kHz higher by 13 to 20.
    for one in found:
        assert -23 < one.fell[2] < -7
        assert one.fell[0] > 45
        assert one.fell[1] < 210
        assert any(1000 < low < 3000 for low, _ in one.bands_hz)
