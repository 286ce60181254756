"""Which lines are looked at."""

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.datasets.recording import Campaign
from rotorwise.diagnose.gap.coordinates import coordinates_of
from rotorwise.diagnose.gap.evidence import Comparison
from rotorwise.diagnose.gap.explain import observed
from rotorwise.diagnose.gap.hypotheses import Candidate
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.diagnose.gap.shown_lines import may_show
from rotorwise.diagnose.gap.transfer_error import none_of
from rotorwise.diagnose.gap.wanted_lines import same_line, wanted_lines
from rotorwise.simulators import gearbox
from rotorwise.simulators.effect import effect_catalogue
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine

from .made_campaigns import recorded

SPEEDS_RPM = (1200.0, 1800.0, 2400.0)


@pytest.mark.parametrize("name", ["amb_rotor", "gearbox", "rigid_coupling", "test_rig"])
def test_lines_with_phase_are_shaft_orders_and_no_line_comes_twice(name):
    orders, kinds = wanted_lines(find_machine(name), highest=6.0, speeds_rpm=SPEEDS_RPM)
    with_phase = [order for order, kind in zip(orders, kinds, strict=True) if kind.phase]
    assert {0.5, 1.0, 2.0, 3.0} <= set(with_phase)
    assert max(with_phase) <= 6
    assert len(set(with_phase)) == len(with_phase)
    others = [(order, kind) for order, kind in zip(orders, kinds, strict=True) if not kind.phase]
    for number, (order, kind) in enumerate(others):
        for other, its in others[:number]:
            if kind.envelope == its.envelope:
                places = (order, kind.frequency_hz), (other, its.frequency_hz)
                assert not same_line(*places, SPEEDS_RPM, within=0.01 if kind.envelope else 0.004)


def test_bearing_lines_are_looked_for_in_the_envelope():
    rig = find_machine("test_rig")
    orders, kinds = wanted_lines(rig, highest=6.0, speeds_rpm=SPEEDS_RPM)
    envelope = [order for order, kind in zip(orders, kinds, strict=True) if kind.envelope]
    bearing = rig.bare_assembly().component("bearing", "")
    pass_order = bearing.geometry.balls * bearing.damage.cage_order(bearing.geometry, bearing.shaft_ratio)
    assert any(order == pytest.approx(pass_order, rel=0.02) for order in envelope)


def test_a_line_that_may_lie_anywhere_is_found_and_not_looked_for():
    orders, kinds = wanted_lines(find_machine("rigid_coupling"), highest=6.0, speeds_rpm=SPEEDS_RPM)
    frequencies = {kind.frequency_hz for order, kind in zip(orders, kinds, strict=True) if order == 0}
    assert frequencies
    # Of a process: 5 Hz is the middle of its prior, and no more likely than its neighbours.
    assert 5.0 not in frequencies


def test_the_supply_is_looked_for_at_its_own_frequency():
    orders, kinds = wanted_lines(find_machine("rigid_coupling"), highest=6.0, speeds_rpm=SPEEDS_RPM)
    assert (0.0, LineKind(phase=False, frequency_hz=100.0)) in zip(orders, kinds, strict=True)


def test_an_effect_whose_line_may_lie_anywhere_is_tried_only_where_one_was_found():
    rotor, speeds = find_machine("amb_rotor"), SPEEDS_RPM
    orders, kinds = wanted_lines(rotor, highest=6.0, speeds_rpm=speeds)
    assert not may_show(_candidate("load_fluctuation"), rotor, _silent(orders, kinds))
    found = LineKind(phase=False, frequency_hz=7.3)
    there = _silent((*orders, 0.0), (*kinds, found), clear=len(orders))
    assert may_show(_candidate("load_fluctuation", frequency_hz=7.3), rotor, there)
    assert not may_show(_candidate("load_fluctuation"), rotor, there)
    # Effects that state no line, or one of the shaft's, are always looked at.
    assert may_show(_candidate("clock_error"), rotor, there)
    # A soft mount may resonate anywhere.
    assert may_show(_candidate("mounting_resonance"), rotor, there)
    assert may_show(_candidate("unbalance"), rotor, there)


def test_a_defect_of_a_bearing_is_looked_for_where_the_balls_pass_whatever_its_slip():
    """One strength is asked for at a time: a pit without slip passes elsewhere, where only noise is."""
    rig = find_machine("test_rig")
    orders, kinds = wanted_lines(rig, highest=6.0, speeds_rpm=SPEEDS_RPM)
    stated, still = (_candidate("outer_race_defect", slip=slip).effect.signature(rig)[0].order for slip in (0.015, 0.0))
    # A line of another effect lies where the balls pass without slip.
    orders, kinds = (*orders, still), (*kinds, LineKind(phase=False, envelope=True))
    silent = _silent(orders, kinds)
    passing = min(range(len(orders)), key=lambda k: (not kinds[k].envelope, abs(orders[k] - stated)))
    assert orders[passing] == pytest.approx(stated, rel=0.005)
    heard = _silent(orders, kinds, clear=passing)
    for slip in (0.015, 0.0):
        assert may_show(_candidate("outer_race_defect", slip=slip), rig, heard)
        assert not may_show(_candidate("outer_race_defect", slip=slip), rig, silent)


@pytest.mark.parametrize(("number", "size", "shows"), [(0, 4.0, True), (2, 4.0, False), (2, 7.0, True)])
def test_of_the_lines_that_an_effect_states_the_third_must_be_clear(number, size, shows):
    # A wheel off centre: sidebands of the mesh, and its own turn in the transmission error, which may be all there is.
    gearbox = find_machine("gearbox")
    wheel = _candidate("gear_eccentricity")
    wheel = replace(wheel, effect=replace(wheel.effect, at="wheel"))
    orders = tuple(abs(line.order) for line in wheel.effect.signature(gearbox))
    lines = _silent(orders, (LineKind(phase=False),) * len(orders), clear=number, size=size)
    assert may_show(wheel, gearbox, lines) is shows


def _candidate(name, **values):
    effect = effect_catalogue()[name]().with_values(**values)
    return Candidate(effect, coordinates_of(effect.parameters()))


def _silent(orders, kinds, *, clear=None, size=10.0):
    """Lines of nothing in noise, of which one is clear."""
    shape = (len(SPEEDS_RPM), 1, len(orders))
    amplitudes = np.zeros(shape, dtype=complex)
    if clear is not None:
        amplitudes[:, :, clear] = size
    lines = OrderLines(tuple(map(Condition, SPEEDS_RPM)), ("a",), tuple(orders), amplitudes, np.ones(shape), kinds)
    reals, nothing = int(lines.parts.sum()), np.zeros(0)
    unit, flat = np.eye(reals), np.zeros(shape, dtype=complex)
    return Comparison(lines, flat, unit, unit, np.zeros(reals), 0.0, nothing, np.zeros((0, reals)), none_of(lines))


def test_without_a_speed_no_line_is_told_from_another():
    with pytest.raises(InvalidValueError, match="Give the speeds"):
        wanted_lines(find_machine("test_rig"), highest=6.0, speeds_rpm=())


def test_recordings_whose_speed_only_the_tacho_tells_show_the_same_lines():
    rig = find_machine("test_rig")
    stated = recorded(rig, SPEEDS_RPM[:2], seed=3, rate_hz=4096.0, duration_s=2.0)
    unstated = [replace(one, condition=replace(one.condition, speed_rpm=None)) for one in stated]
    channels = {one.name: one.name for one in rig.bare_assembly().probes if one.name.startswith("housing")}
    known, _, _ = observed(Campaign(stated), rig, channels)
    found, _, _ = observed(Campaign(unstated), rig, channels)
    assert found.orders == known.orders
    assert sum(kind.envelope for kind in found.kinds) > 5
    np.testing.assert_array_equal(found.amplitudes, known.amplitudes)


def test_a_gearbox_has_no_line_beside_its_mesh_unless_an_effect_states_it() -> None:
    # The record would hold 5 Hz beside the mesh clearly; the simulation is shorter and shows the mesh's own skirt.
    kinds = (LineKind(phase=False), LineKind(phase=False, frequency_hz=-5.0))
    predictor = Predictor(
        (Condition(2190.0, 30.0),), ("accelerometer",), (23.0, 23.0), (12_800.0,), (64_000,), kinds, (0, 0)
    )
    swinging = gearbox.with_effects(effect_catalogue()["load_fluctuation"](torque_n_m=5.0, frequency_hz=5.0))
    (((mesh, beside),),), (((_, swung),),) = (np.abs(predictor.amplitudes(one)) for one in (gearbox, swinging))
    assert beside == 0.0
    assert 1e-3 * mesh < swung < mesh


def test_lines_of_both_gears_and_of_every_bearing_are_looked_for() -> None:
    gearbox = find_machine("gearbox")
    orders, kinds = wanted_lines(gearbox, highest=6.0, speeds_rpm=(940.0, 1240.0, 1930.0, 2260.0))
    places = [*zip(orders, kinds, strict=True)]
    wheel = gearbox.bare_assembly().place("gear", "wheel").shaft_ratio
    beside = [order for order, kind in places if not kind.phase and not kind.envelope and not kind.frequency_hz]
    for side in (-wheel, wheel):
        # Sidebands of the slow wheel lie within 1.3 % of the mesh, and are neither it nor lines 5 Hz beside it.
        assert any(order == pytest.approx(23 + side) for order in beside)
    envelope = [order for order, kind in places if kind.envelope]
    for name in ("bearing 1", "bearing 3"):
        bearing = gearbox.bare_assembly().component("bearing", name)
        passes = bearing.geometry.balls * bearing.damage.cage_order(bearing.geometry, bearing.shaft_ratio)
        assert any(order == pytest.approx(passes, rel=0.02) for order in envelope)
