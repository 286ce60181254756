"""Which channels make an orbit: probes of one place at right angles, as stated, or two without directions."""

from __future__ import annotations

import pytest
from rotorwise.datasets.recording import Channel
from rotorwise.diagnose.probe_pair import probe_pair


def probe(name: str, direction: str | None = None, location: str | None = None, quantity: str = "displacement"):
    return Channel(name, quantity=quantity, direction=direction, location=location)


@pytest.mark.parametrize(
    ("channels", "expected"),
    [
        ([probe("a"), probe("b")], (0, 1)),
        ([probe("a", "vertical"), probe("b", "horizontal")], (1, 0)),
        ([probe("a", "y"), probe("b", "axial"), probe("c", "x")], (2, 0)),
        ([probe("a", "radial"), probe("b", "radial")], (0, 1)),
        ([probe("a", "horizontal"), probe("b", "horizontal")], None),
        ([probe("a", "horizontal"), probe("b", "axial")], None),
        ([probe("a", location="drive end"), probe("b", location="other end")], None),
        ([probe("a", "x", "one"), probe("b", "x", "two"), probe("c", "y", "two")], (1, 2)),
        ([probe("a", quantity="acceleration"), probe("b", quantity="acceleration")], None),
        ([probe("a")], None),
    ],
)
def test_the_pair(channels, expected):
    assert probe_pair(channels) == expected
