"""The orbit in the report of ``analyse``: the probes' motion, and what its orders alone run through."""

from __future__ import annotations

import numpy as np
import pytest
from rotorwise.datasets import Metadata
from rotorwise.diagnose import analyse
from rotorwise.diagnose.report.payload import build_payload

from .look_files import RATE, write_csv

TIME = np.arange(20_000) / RATE
TURN = 2 * np.pi * 25.0 * TIME


@pytest.fixture(scope="module")
def analysed(tmp_path_factory):
    """1X forward, 40 x 20 um; 2X backward, a circle of 10 um; noise of 1 um."""
    rng = np.random.default_rng(5)
    x = 40 * np.cos(TURN) + 10 * np.cos(2 * TURN) + rng.normal(0, 1, TIME.size)
    y = 20 * np.sin(TURN) - 10 * np.sin(2 * TURN) + rng.normal(0, 1, TIME.size)
    path = write_csv(tmp_path_factory.mktemp("orbit") / "probes.csv", {"x (um)": x, "y (um)": y})
    return analyse(path, metadata=Metadata(speed_rpm=1500))


def test_each_order_has_its_axes_and_its_way(analysed):
    found = {one["name"]: one for one in analysed.pictures.orbit["orders"]}
    first, second = found["1X"], found["2X"]
    assert (first["way"], second["way"]) == ("forward", "backward")
    assert np.abs(first["x"]).max() == pytest.approx(40e-6, rel=0.03)
    assert np.abs(first["y"]).max() == pytest.approx(20e-6, rel=0.03)
    assert np.hypot(second["x"], second["y"]) == pytest.approx(10e-6, rel=0.06)
    # Forward is run through from x towards y: the area that it encloses has that sign.
    for one, sign in ((first, 1), (second, -1)):
        area = 0.5 * np.sum(one["x"][:-1] * np.diff(one["y"]) - one["y"][:-1] * np.diff(one["x"]))
        assert np.sign(area) == sign


def test_the_page_draws_them_in_its_unit(analysed):
    drawn = build_payload(analysed, limit=4000)["orbit"]
    assert [one["name"] for one in drawn["orders"]][:2] == ["1X forward", "2X backward"]
    assert "forward turns from x towards y" in drawn["note"]
