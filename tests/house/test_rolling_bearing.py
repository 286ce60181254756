"""Bearing kinematics: theory, published orders of the catalogue, properties."""

import math
import tomllib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.rotor_dynamics.rolling_bearing import (
    BearingGeometry,
    bearing_catalogue,
    find_bearing,
    normalised_designation,
)

CATALOGUE = Path(__file__).resolve().parents[2] / "simulators" / "rotor_dynamics" / "bearings.toml"
ROWS = tomllib.loads(CATALOGUE.read_text(encoding="utf-8"))["bearing"]
#: Orders from the makers' and data sets' own tables (outer race, inner race, cage), typed in a second time.
PUBLISHED = {
    "6205-2RS JEM": (3.5848, 5.4152, 0.39828),
    "6203": (3.0530, 4.9469, 0.3817),
    "ER-12K": (3.052, 4.948, 0.381),
    "MaFaulDa": (2.998, 5.002, 0.375),
}

geometries = st.builds(
    lambda balls, pitch, ratio, angle: BearingGeometry(balls, ratio * pitch, pitch, angle),
    st.integers(3, 60),
    st.floats(1e-3, 10.0),
    st.floats(0.01, 0.95),
    st.floats(0.0, 1.5),
)


@given(geometries)
def test_races_share_the_balls(geometry):
    orders = geometry.defect_orders()
    assert orders.outer_race + orders.inner_race == pytest.approx(geometry.balls, rel=1e-12)
    assert orders.outer_race == pytest.approx(geometry.balls * orders.cage, rel=1e-12)


@given(geometries)
def test_cage_is_slower_than_half_the_shaft_and_inner_race_above_outer(geometry):
    orders = geometry.defect_orders()
    assert 0.0 < orders.cage < 0.5
    assert orders.outer_race < geometry.balls / 2 < orders.inner_race < geometry.balls
    assert orders.ball_spin > 0.0


@given(geometries, st.floats(0.01, 100.0))
def test_only_the_ratio_of_the_diameters_matters(geometry, scale):
    larger = BearingGeometry(
        geometry.balls,
        geometry.ball_diameter_m * scale,
        geometry.pitch_diameter_m * scale,
        geometry.contact_angle_rad,
    )
    one, other = geometry.defect_orders(), larger.defect_orders()
    assert other.outer_race == pytest.approx(one.outer_race, rel=1e-9)
    assert other.ball_spin == pytest.approx(one.ball_spin, rel=1e-9)


@given(geometries)
def test_rolling_without_slip_at_both_races(geometry):
    # The contact points of a ball move with the races: cage speed x pitch radius -+ spin x ball radius.
    if geometry.contact_angle_rad != 0.0:
        geometry = BearingGeometry(geometry.balls, geometry.ball_diameter_m, geometry.pitch_diameter_m)
    orders = geometry.defect_orders()
    pitch, ball = geometry.pitch_diameter_m / 2, geometry.ball_diameter_m / 2
    # Spin relative to the cage, at the outer race (fixed, so it moves at minus the cage speed in the cage's
    # frame).
    assert orders.cage * (pitch + ball) == pytest.approx(orders.ball_spin * ball, rel=1e-9)
    assert (1 - orders.cage) * (pitch - ball) == pytest.approx(orders.ball_spin * ball, rel=1e-9)


def test_limits_of_small_balls_and_steep_contact():
    small = BearingGeometry(12, 1e-9, 1.0).defect_orders()
    assert (small.outer_race, small.inner_race, small.cage) == pytest.approx((6.0, 6.0, 0.5))
    thrust = BearingGeometry(12, 0.2, 1.0, math.pi / 2 - 1e-9).defect_orders()
    assert (thrust.outer_race, thrust.inner_race) == pytest.approx((6.0, 6.0))
    assert thrust.ball_spin == pytest.approx(2.5)


@pytest.mark.parametrize(("name", "expected"), PUBLISHED.items())
def test_published_orders(name, expected):
    orders = find_bearing(name).defect_orders()
    assert (orders.outer_race, orders.inner_race, orders.cage) == pytest.approx(expected, abs=0.002)


def test_the_ball_spin_quoted_for_the_6205_is_twice_the_spin():
    assert 2 * find_bearing("6205").defect_orders().ball_spin == pytest.approx(4.7135, abs=0.002)
    assert 2 * find_bearing("6203").defect_orders().ball_spin == pytest.approx(3.9874, abs=0.002)


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row["designation"])
def test_catalogue_row(row):
    geometry = bearing_catalogue()[normalised_designation(row["designation"])]
    orders = geometry.defect_orders()
    assert orders.outer_race + orders.inner_race == pytest.approx(row["balls"], rel=1e-12)
    assert orders.outer_race == pytest.approx(row["balls"] * orders.cage, rel=1e-12)
    assert len(row["source"]) > 20
    assert row["confidence"] in ("H", "M", "L")
    have = {
        "outer_race": orders.outer_race,
        "inner_race": orders.inner_race,
        "cage": orders.cage,
        "twice_ball_spin": 2 * orders.ball_spin,
    }
    for name, value in row.get("published", {}).items():
        assert have[name] == pytest.approx(value, abs=0.002), name


def test_no_two_rows_share_a_name():
    names = [normalised_designation(name) for row in ROWS for name in (row["designation"], *row.get("also", ()))]
    assert len(names) == len(set(names)) == len(bearing_catalogue())


@pytest.mark.parametrize("name", ["6205", "6205-2RS", "6205/C3", "6205 2Z", " 6205-2RS JEM "])
def test_suffixes_do_not_matter(name):
    assert find_bearing(name).balls == 9


def test_unknown_bearing_lists_the_known_and_the_way_out():
    with pytest.raises(InvalidValueError, match=r"(?s)NU-9999.*6205.*--bearing"):
        find_bearing("NU-9999")


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        ((2, 0.01, 0.04), "2 balls"),
        ((8, 0.04, 0.01), "order of the two numbers"),
        ((8, 0.0, 0.01), "0.0 m"),
        ((8, 0.01, 0.04, 15.0), "Check the unit"),
        ((8, 0.01, 0.04, -0.1), "-5.73 deg"),
        ((8, math.nan, 0.04), "nan m"),
    ],
)
def test_impossible_geometry_is_refused(fields, said):
    with pytest.raises(InvalidValueError, match=said):
        BearingGeometry(*fields)
