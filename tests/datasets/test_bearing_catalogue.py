"""The bearing catalogue: identities of the kinematics for every row, then the published orders."""

from __future__ import annotations

import tomllib
from importlib import resources

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rotorwise.datasets.errors import InvalidValueError
from rotorwise.simulators.rotor_dynamics.rolling_bearing import (
    BearingGeometry,
    bearing_catalogue,
    find_bearing,
)

ROWS = tomllib.loads(
    resources.files("rotorwise.simulators.rotor_dynamics").joinpath("bearings.toml").read_text("utf-8")
)["bearing"]


@given(st.integers(3, 40), st.floats(0.01, 0.6), st.floats(0, 1.2))
def test_identities_of_the_kinematics(balls: int, ratio: float, angle: float) -> None:
    # Randall and Antoni 2011: BPFO + BPFI = Z; BPFO = Z FTF; BSF = (D/2d)(1 - (d/D cos a)^2).
    orders = BearingGeometry(balls, ratio, 1.0, angle).defect_orders()
    assert orders.outer_race + orders.inner_race == pytest.approx(balls)
    assert orders.outer_race == pytest.approx(balls * orders.cage)
    assert orders.ball_spin == pytest.approx(2 * orders.cage * (1 - orders.cage) / ratio)


@pytest.mark.parametrize("row", [row for row in ROWS if "published" in row], ids=lambda row: row["designation"])
def test_published_orders(row: dict) -> None:
    orders = find_bearing(row["designation"]).defect_orders()
    found = {
        "outer_race": orders.outer_race,
        "inner_race": orders.inner_race,
        "cage": orders.cage,
        "twice_ball_spin": 2 * orders.ball_spin,
    }
    for name, value in row["published"].items():
        assert found[name] == pytest.approx(value, rel=2e-3), name


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row["designation"])
def test_every_row_has_a_source_and_is_found_by_all_its_names(row: dict) -> None:
    assert row["source"]
    assert row["confidence"] in "HML"
    for name in (row["designation"], *row.get("also", ())):
        assert find_bearing(name.lower()).balls == row["balls"]


def test_suffixes_and_unknown_names() -> None:
    assert find_bearing("6205-2RS/C3") == find_bearing("6205")
    with pytest.raises(InvalidValueError, match=r"ER-12K.*--bearing"):
        find_bearing("9999")
    assert len(bearing_catalogue()) >= len(ROWS)
