"""A machine from its healthy lines, few or many, right or wrong in form."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.baseline import start
from rotorwise.diagnose.gap.healthy_machine import healthy_machine
from rotorwise.diagnose.gap.lacking_terms import lacking_terms
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines, different_speeds
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.diagnose.gap.pulse_place import turned
from rotorwise.simulators import amb_rotor, rigid_coupling, test_rig
from rotorwise.simulators.effects.gravity import Gravity
from rotorwise.simulators.effects.residual_unbalance import ResidualUnbalance
from rotorwise.simulators.machine import Machine

from .made_campaigns import altered

slow = pytest.mark.slow

SPEEDS_RPM, TOP_RPM = (1200.0, 1700.0, 2300.0, 2900.0, 3500.0, 4100.0), 4100.0
ORDERS, NOISE_M = (1.0, 2.0, 3.0), 2e-8
OFF_BALANCE = ResidualUnbalance(at="coupling_hub", moment_x_kg_m=-2e-6, moment_y_kg_m=3e-6)


def _predictor(speeds: tuple[float, ...], machine: Machine = amb_rotor, *, without: str = "") -> Predictor:
    """Return the predictor of all probes but those of one direction."""
    probes = tuple(one.name for one in machine.bare_assembly().probes if one.direction != without)
    conditions, count = tuple(Condition(speed) for speed in speeds), len(speeds)
    kinds = (LineKind(),) * len(ORDERS)
    return Predictor(conditions, probes, ORDERS, (1e4,) * count, (20_000,) * count, kinds, (0,) * len(ORDERS))


def _noisy(lines: np.ndarray, predictor: Predictor) -> OrderLines:
    generator = np.random.default_rng(4)
    noise = NOISE_M * (generator.normal(size=lines.shape) + 1j * generator.normal(size=lines.shape))
    return OrderLines(predictor.conditions, predictor.probes, ORDERS, lines + noise, np.full(lines.shape, NOISE_M))


@pytest.mark.parametrize(
    "speeds",
    [pytest.param((2300.0,), marks=slow), pytest.param((1700.0, 2900.0), marks=slow), (2900.0, 2905.0, 2910.0)],
)
def test_at_few_speeds_nothing_is_added_and_the_pulse_is_told_all_the_same(speeds: tuple[float, ...]) -> None:
    # Three recordings at one speed do not tell how a spring grows with it.
    predictor = _predictor(speeds)
    healthy = _noisy(predictor.amplitudes(altered(amb_rotor, share=0.02, seed=3)), predictor)
    found = healthy_machine(amb_rotor, turned(healthy, -1.1), predictor, reference_rpm=TOP_RPM)
    assert found.form is not None
    assert not found.form.added
    assert found.errors is None
    assert np.isfinite(found.at_healthy.lines).all()
    assert found.pulse_rad == pytest.approx(1.1, abs=0.1)


@pytest.mark.slow
def test_what_keeps_being_missed_is_no_reason_to_change_supports_but_unbalance_stays() -> None:
    predictor = _predictor(SPEEDS_RPM)
    lines = predictor.amplitudes(altered(amb_rotor, share=0.02, seed=3).with_effects(OFF_BALANCE))
    generator = np.random.default_rng(8)
    # Smooth in speed, another at each probe and order, a seventh of each line.
    speeds = np.log(np.array(SPEEDS_RPM) / SPEEDS_RPM[0])
    waves = generator.normal(size=(2, 4, len(ORDERS), 2)) @ np.array([1, 1j])
    wrong = 1 + 0.1 * (waves[0] * np.cos(3 * speeds)[:, None, None] + waves[1] * np.sin(3 * speeds)[:, None, None])
    found = healthy_machine(amb_rotor, _noisy(lines * wrong, predictor), predictor, reference_rpm=TOP_RPM)
    assert found.form is not None
    assert found.form.missed > 0.7 * found.form.missed_before
    (added,) = found.at_healthy.machine.effects
    assert (added.NAME, added.at) == ("residual_unbalance", "coupling_hub")
    assert added.values()["moment_x_kg_m"] == pytest.approx(OFF_BALANCE.moment_x_kg_m, abs=1.5e-6)
    assert added.values()["moment_y_kg_m"] == pytest.approx(OFF_BALANCE.moment_y_kg_m, abs=1.5e-6)


@pytest.mark.slow
def test_weight_and_own_unbalance_and_pulse_anywhere_are_told_together() -> None:
    # As given the machine has no weight and its unbalance points along x: far from the lines at the right place.
    real = amb_rotor.with_parameters(unbalance_angle_rad=2.6).with_effects(Gravity())
    predictor = _predictor(SPEEDS_RPM)
    healthy = _noisy(predictor.amplitudes(altered(real, share=0.02, seed=3)), predictor)
    found = healthy_machine(amb_rotor, turned(healthy, 0.66), predictor, reference_rpm=TOP_RPM)
    assert found.pulse_rad == pytest.approx(-0.66, abs=0.05)
    values = {one.NAME: one.values() for one in found.at_healthy.machine.effects}
    assert values["gravity"]["gravity_m_s2"] == pytest.approx(9.81, rel=0.1)


def test_bolts_that_are_unlike_do_not_turn_the_pulse() -> None:
    # By 1 %: with the offset of the axes they make as large a torque at 1X as the offset of the holes does.
    speeds = (700.0, 1000.0, 1300.0, 1600.0)
    real = altered(rigid_coupling, share=0.02, seed=3).with_parameters(
        bolt_unevenness_x=0.008, bolt_unevenness_y=-0.006
    )
    predictor = _predictor(speeds, rigid_coupling)
    lines = predictor.amplitudes(real)
    generator = np.random.default_rng(4)
    deviations = np.maximum(3e-3 * np.abs(lines).max(axis=(0, 2)), 1e-9)[None, :, None] + np.zeros(lines.shape)
    noise = deviations * (generator.normal(size=lines.shape) + 1j * generator.normal(size=lines.shape))
    healthy = OrderLines(predictor.conditions, predictor.probes, ORDERS, lines + noise, deviations)
    found = healthy_machine(rigid_coupling, turned(healthy, -1.3), predictor, reference_rpm=1600.0)
    assert found.pulse_rad == pytest.approx(1.3, abs=0.03)
    assert not found.at_healthy.machine.effects
    own = found.at_healthy.machine.values
    assert own["bolt_unevenness_x"] == pytest.approx(0.008, abs=0.004)
    assert own["bolt_unevenness_y"] == pytest.approx(-0.006, abs=0.004)


def test_weight_is_no_term_where_it_moves_next_to_nothing_or_is_there_already() -> None:
    others = (amb_rotor.with_effects(Gravity()), test_rig, rigid_coupling)
    for machine, expected in ((amb_rotor, True), *((one, False) for one in others)):
        # The sag of the offset flange shows in the twist only.
        predictor = _predictor(SPEEDS_RPM[:2], machine, without="torsion")
        terms = lacking_terms(start(machine, predictor), predictor, reference_rpm=TOP_RPM)
        assert ("gravity" in {term.effect.NAME for term in terms}) is expected
        # A strength of one standard deviation is one that it can have.
        assert all(term.effect.with_values(**{n: term.deviation for n in term.strengths}) for term in terms)


def test_speeds_that_lie_together_count_as_one() -> None:
    assert different_speeds([Condition(speed) for speed in (1000.0, 1010.0, 2000.0, 990.0)]) == 2
    assert different_speeds([Condition(700.0)]) == 1
    assert different_speeds([]) == 0
