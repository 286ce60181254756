"""What the default model must do on the measured recordings, of which it has seen none."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest
from rotorwise.diagnose.learning.default_model import default_model

_HERE = Path(__file__).parent
_DATA = _HERE.parents[2] / "shared" / "data"

pytestmark = [
    pytest.mark.measured,
    pytest.mark.skipif(not _DATA.is_dir(), reason=f"measured recordings are not at {_DATA}"),
]


@pytest.fixture(scope="module")
def counted():
    spec = importlib.util.spec_from_file_location("learning_table", _HERE / "learning_table.py")
    assert spec is not None
    assert spec.loader is not None
    learning = importlib.util.module_from_spec(spec)
    sys.modules["learning_table"] = learning
    spec.loader.exec_module(learning)
    model = default_model()
    return learning.totals([(one, learning.answers(one, model)) for one in learning.seen()])


@pytest.mark.slow
def test_both_find_every_bearing_fault_that_shows(counted) -> None:
    right, of = counted["bearing faults that show, right first"]["both"]
    assert of == 9
    assert right >= 0.95 * of


@pytest.mark.slow
def test_both_find_every_unbalance_against_a_baseline(counted) -> None:
    assert counted["unbalance against a baseline, right first"]["both"] == (12, 12)


def test_no_way_alarms_on_a_healthy_machine(counted) -> None:
    assert counted["healthy, called faulty"] == {"rules": (0, 4), "model": (0, 4), "both": (0, 4)}


def test_what_is_not_visible_gets_no_wrong_name(counted) -> None:
    assert counted["not visible by the card, called something else"]["both"][0] == 0
