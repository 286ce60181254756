"""Effects that can choose where their line lies, put where the recordings show one."""

import pytest
from rotorwise.diagnose.gap.tuned import in_band, tuned
from rotorwise.simulators.effect import make_effect
from rotorwise.simulators.machine import find_machine

RIG = find_machine("test_rig")


def _values(effect, name, found):
    return [one.values()[name] for one, given in tuned(effect, RIG, found) if given == {name}]


def test_both_sidebands_of_a_slip_give_one_slip():
    slip, poles = 0.0442, 4.0
    apart = poles * slip / (1 - slip)
    effect = make_effect("pole_pass", {"poles": poles}, at="motor")
    found = _values(effect, "slip", [(1 + apart, 0.0), (1 - apart, 0.0), (apart, 0.0)])
    assert found == [pytest.approx(slip, rel=1e-6)]


def test_a_line_out_of_reach_of_the_prior_tunes_nothing():
    # 4 poles at 5 % slip, the prior's end, reach 0.21 X from 1X.
    assert _values(make_effect("pole_pass", {}, at="motor"), "slip", [(1.5, 0.0), (7.3, 0.0)]) == []


def test_a_line_just_beyond_the_prior_puts_the_effect_at_its_end():
    # Films turn at 0.40 to 0.48 of the shaft's speed; what they drive lies a little beside what is stated.
    effect = make_effect("oil_whirl", {}, at="bearing_a")
    (share,) = _values(effect, "speed_share", [(0.3985, 0.0)])
    assert share == pytest.approx(0.4, abs=1e-3)
    assert _values(effect, "speed_share", [(0.39, 0.0)]) == []
    assert _values(effect, "speed_share", [(0.44, 0.0)]) == [pytest.approx(0.44, rel=1e-6)]


def test_a_frequency_is_taken_as_it_is_found():
    effect = make_effect("load_fluctuation", {"torque_n_m": 1.0}, at="shaft_load")
    assert _values(effect, "frequency_hz", [(0.0, 14.9), (1.3, 0.0)]) == [14.9]


def test_what_states_no_free_line_is_not_tuned():
    assert tuned(make_effect("unbalance", {}, at="disc"), RIG, [(1.3, 0.0), (0.0, 37.0)]) == []


def test_a_whole_order_is_met_exactly():
    # 3X of a bolted coupling: the ripple is at 2, 3 or 4 times a turn; then everything repeats with the shaft.
    effect = make_effect("torque_ripple", {"torque_n_m": 40.0})
    machine = find_machine("rigid_coupling")
    found = [one.values()["order"] for one, given in tuned(effect, machine, [(3.0, 0.0)]) if given == {"order"}]
    assert sorted(found) == [2.0, 3.0, 4.0]


def test_a_line_that_stays_where_it_is_tunes_nothing():
    # Looseness has parameters without a unit, and lines of the shaft's own orders only.
    machine = find_machine("rigid_coupling")
    assert tuned(make_effect("looseness", {}, at="support_2"), machine, [(1.0, 0.0), (2.0, 0.0)]) == []


def test_the_order_a_parameter_has_by_default_is_one_of_the_places():
    # 2X of a bolted coupling: a ripple once a turn, which is the middle of its prior, or twice, or three times.
    effect = make_effect("torque_ripple", {"torque_n_m": 40.0})
    machine = find_machine("rigid_coupling")
    found = [one.values()["order"] for one, given in tuned(effect, machine, [(2.0, 0.0)]) if given == {"order"}]
    assert sorted(found) == [1.0, 2.0, 3.0]


def test_a_slip_is_known_no_better_than_the_band_in_which_its_line_is_looked_for():
    # The band is 2 % either way of the line at the usual slip of 1.5 %: all of the prior, 0 to 3 %, lies in it.
    effect = make_effect("outer_race_defect", {"slip": 0.011, "size_m": 1e-4}, at="bearing_a")
    low, high = in_band(effect, RIG, "slip") or (1.0, 1.0)
    assert low == pytest.approx(0.0, abs=1e-3)
    assert high == pytest.approx(0.03, abs=1e-3)
    assert in_band(effect, RIG, "size_m") is None
    assert in_band(make_effect("pole_pass", {}, at="motor"), RIG, "slip") is None
