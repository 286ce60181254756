"""The machine's own unknowns from its healthy lines, the model's error, and where the tacho's pulse sits."""

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.diagnose.gap import calibration
from rotorwise.diagnose.gap.baseline import Baseline, again, linearised, machine_at, shifted, start
from rotorwise.diagnose.gap.calibration import (
    OWN_SHARE,
    calibrated,
    corrected,
    left_variance,
    objective,
    residual_error,
    settled_further,
    size_error,
)
from rotorwise.diagnose.gap.coordinates import coordinates_of
from rotorwise.diagnose.gap.healthy_machine import healthy_machine
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.model_error import ModelError, error_covariance, model_error
from rotorwise.diagnose.gap.out_of_reach import out_of_reach
from rotorwise.diagnose.gap.predict import Predictor, UnpredictableError
from rotorwise.diagnose.gap.prepared import settled_in_both
from rotorwise.diagnose.gap.pulse_place import turned
from rotorwise.simulators.machine import find_machine

ORDERS = (1.0, 2.0, 3.0)
SPEEDS_RPM = (1200.0, 1700.0, 2300.0, 2900.0, 3500.0, 4100.0)
NOISE_M = 1e-8
CONDITIONS_OF_RIG = tuple(Condition(speed) for speed in (817.5, 1177.8, 1543.8, 1925.4, 2444.5, 2984.0))
#: Away from what is given, within the priors.
OFF = {"coupling_stiffness_n_m": 1.06, "coupling_rotational_stiffness_n_m_rad": 0.95, "unbalance_kg_m": 1.05,
       "shaft_diameter_m": 1.002, "shaft_length_m": 0.997}  # fmt: skip
#: What the calibration cannot move is off as well.
WRONG = {"derivative": 1.05, "integral": 1.1, "current_stiffness_n_a": 1.03, "displacement_stiffness_n_m": 0.96,
         "first_amplifier_time_s": 1.05}  # fmt: skip


def _predictor(name: str) -> Predictor:
    probes = tuple(p.name for p in find_machine(name).bare_assembly().probes if p.quantity == "displacement")
    count = len(SPEEDS_RPM)
    conditions = tuple(Condition(speed) for speed in SPEEDS_RPM)
    kinds = (LineKind(),) * len(ORDERS)
    return Predictor(conditions, probes, ORDERS, (10_000.0,) * count, (20_000,) * count, kinds, (0,) * len(ORDERS))


def _healthy(predictor: Predictor, *, seed: int, **factors: float) -> OrderLines:
    machine = find_machine("amb_rotor")
    machine = machine.with_parameters(**{name: own * machine.values[name] for name, own in factors.items()})
    lines = predictor.amplitudes(machine)
    generator = np.random.default_rng(seed)
    noise = NOISE_M * (generator.normal(size=lines.shape) + 1j * generator.normal(size=lines.shape))
    return OrderLines(predictor.conditions, predictor.probes, ORDERS, lines + noise, np.full(lines.shape, NOISE_M))


def test_slopes_corrected_along_a_step_lead_to_where_it_led_and_stay_across_it():
    predictor, machine = _predictor("amb_rotor"), find_machine("amb_rotor")
    before = start(machine, predictor)
    own = before.position.size
    move = np.where(before.active, 0.3 * np.random.default_rng(1).normal(size=own), 0.0)
    after = shifted(before, machine, move, predictor)
    slopes = corrected(before, after).slopes[:own]
    np.testing.assert_allclose(np.tensordot(move, slopes, 1), after.lines - before.lines, rtol=1e-9, atol=1e-15)
    across = np.random.default_rng(2).normal(size=own)
    across -= (across @ move) / (move @ move) * move
    kept = np.tensordot(across, before.slopes[:own], 1)
    np.testing.assert_allclose(np.tensordot(across, slopes, 1), kept, rtol=1e-9, atol=1e-15)


def test_a_calibrated_machine_has_the_slopes_of_where_it_is():
    predictor, machine = _predictor("amb_rotor"), find_machine("amb_rotor")
    found = calibrated(machine, _healthy(predictor, seed=1, **OFF), predictor)
    np.testing.assert_array_equal(found.slopes, again(found, machine, predictor).slopes)


@pytest.mark.parametrize("fails", ["shifted", "again"])
def test_where_the_machine_is_unstable_on_the_way_the_calibration_ends_nearly_as_well(monkeypatch, fails):
    predictor, machine = _predictor("amb_rotor"), find_machine("amb_rotor")
    healthy = _healthy(predictor, seed=1, **OFF)
    usual = calibrated(machine, healthy, predictor)
    able, calls = getattr(calibration, fails), []

    def unstable_at_first(*arguments):
        calls.append(fails)
        if len(calls) < 3:
            raise UnpredictableError("unstable")
        return able(*arguments)

    monkeypatch.setattr(calibration, fails, unstable_at_first)
    found = calibrated(machine, healthy, predictor)
    assert len(calls) > 2
    error = model_error(usual.lines)
    worth = [objective(one, healthy, error) for one in (start(machine, predictor), found, usual)]
    assert worth[1] - worth[2] < 0.01 * (worth[0] - worth[2])


def test_a_calibration_ends_where_the_truth_is_no_better():
    predictor, machine = _predictor("amb_rotor"), find_machine("amb_rotor")
    healthy = _healthy(predictor, seed=1, **OFF)
    found = calibrated(machine, healthy, predictor)
    given = start(machine, predictor)
    truth = given.position.copy()
    for number, one in enumerate(given.coordinates):
        factor = OFF.get(one.parameter.name, 1.0)
        truth[number] = one.coordinate(factor * machine.values[one.parameter.name])
    there = linearised(machine, given.coordinates, truth, given.given, given.active, predictor)
    error = model_error(given.lines)
    assert objective(found, healthy, error) < objective(there, healthy, error) + 0.5
    assert objective(found, healthy, error) < 0.2 * objective(given, healthy, error)


def test_a_calibration_ends_where_the_truth_is_no_better_where_much_is_unknown():
    # Of steps that were damped ever less as long as they gained anything, the last ones here gained nothing at all.
    machine = find_machine("test_rig")
    full = _predictor("test_rig")
    predictor = replace(full, probes=("housing_a_x", "housing_b_x", "housing_b_y"), conditions=CONDITIONS_OF_RIG)
    given = start(machine, predictor)
    truth = given.given + np.random.default_rng(2).uniform(-0.8, 0.8, given.given.size)
    there = linearised(machine, given.coordinates, truth, given.given, given.active, predictor)
    deviations = 0.005 * np.abs(there.lines) + 1e-4
    healthy = OrderLines(predictor.conditions, predictor.probes, ORDERS, there.lines, deviations)
    found = calibrated(machine, healthy, predictor)
    error = model_error(given.lines)
    assert objective(found, healthy, error) < objective(there, healthy, error)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_calibration_gets_on_where_the_model_is_wrong(seed):
    # A Newton step cut coordinate by coordinate goes nowhere here.
    predictor, machine = _predictor("amb_rotor"), find_machine("amb_rotor")
    healthy = _healthy(predictor, seed=seed, **OFF, **WRONG)
    given = start(machine, predictor)
    error = model_error(given.lines)
    found = calibrated(machine, healthy, predictor)
    assert objective(found, healthy, error) < 0.02 * objective(given, healthy, error)


@pytest.mark.parametrize("angle_rad", [pytest.param(2.3, marks=pytest.mark.slow), 0.12])
def test_the_pulse_s_place_on_the_shaft_is_found(angle_rad):
    predictor, machine = _predictor("amb_rotor"), find_machine("amb_rotor")
    healthy = _healthy(predictor, seed=2, **OFF)
    placed = healthy_machine(machine, turned(healthy, -angle_rad), predictor, reference_rpm=SPEEDS_RPM[-1])
    found = placed.at_healthy
    assert placed.pulse_rad == pytest.approx(angle_rad, abs=0.05)
    straight = calibrated(machine, healthy, predictor)
    assert np.abs(found.lines - straight.lines).max() < 0.01 * np.abs(straight.lines).max()


def test_a_pulse_at_the_model_s_zero_stays_there():
    predictor, machine = _predictor("amb_rotor"), find_machine("amb_rotor")
    assert (
        healthy_machine(machine, _healthy(predictor, seed=3, **OFF), predictor, reference_rpm=SPEEDS_RPM[-1]).pulse_rad
        == 0.0
    )


def test_a_line_that_no_parameter_makes_bends_none():
    # Lines of 1, moved by 0.1 by a deviation of the one parameter; the third order is 0, and nothing moves it by much.
    slopes = 0.1 * np.ones((1, 2, 1, 3), dtype=complex)
    slopes[..., 2] = 1e-3
    made, one = np.array([[[1.0, 1.0, 0.0]]] * 2, dtype=complex), np.ones(1)
    machine = Baseline(None, (None,), 0 * one, 0 * one, one > 0, made, slopes, one, 0 * one, 0 * one)
    conditions = (Condition(1000.0), Condition(2000.0))
    lines = np.array([[[1.2, 5.0, 0.3j]]] * 2)
    healthy = OrderLines(conditions, ("a",), (1.0, 2.0, 3.0), lines, np.full(lines.shape, 1e-3))
    assert out_of_reach(machine, healthy) == pytest.approx(np.array([[0.0, 0.0, 0.3 / np.sqrt(2)]]))


@pytest.mark.parametrize("factor", [1 / 3, 3.0])
def test_a_size_too_small_by_a_factor_is_as_far_off_as_one_too_large(factor):
    lines, one = np.full((2, 1, 2), 2.0, dtype=complex), np.zeros(0)
    machine = Baseline(None, (), one, one, one > 0, factor * lines, lines[:0][None][:0], one, one, one)
    kinds = (LineKind(phase=False), LineKind())
    conditions = (Condition(1000.0), Condition(2000.0))
    healthy = OrderLines(conditions, ("a",), (23.0, 1.0), lines, np.full(lines.shape, 1e-9), kinds)
    found = size_error(machine, healthy)
    # Two thirds of the larger one, the miss itself; nothing of lines with phase.
    assert found[..., 0] == pytest.approx(np.abs(factor - 1) * 2.0)
    assert (found[..., 1] == 0).all()


def test_sizes_that_are_right_count_as_they_are_measured():
    lines, one = np.full((2, 1, 1), 2.0, dtype=complex), np.zeros(0)
    machine = Baseline(None, (), one, one, one > 0, lines, lines[:0][None][:0], one, one, one)
    healthy = OrderLines((Condition(1000.0), Condition(2000.0)), ("a",), (23.0,), lines, np.full(lines.shape, 1e-9),
                         (LineKind(phase=False),))  # fmt: skip
    assert size_error(machine, healthy) == pytest.approx(0.1 * 2.0)


def test_lines_without_phase_and_untied_conditions_do_not_turn():
    conditions = (Condition(1000.0), Condition(2000.0, tied=False))
    amplitudes = np.array([[[1.0 + 1.0j, 0.5]], [[2.0 - 1.0j, 0.3]]])
    lines = OrderLines(
        conditions, ("a",), (2.0, 0.4), amplitudes, np.ones(amplitudes.shape), (LineKind(), LineKind(phase=False))
    )
    found = turned(lines, 0.3).amplitudes
    assert found[0, 0, 0] == pytest.approx((1 + 1j) * np.exp(-0.6j))
    assert found[0, 0, 1] == 0.5
    assert (found[1] == amplitudes[1]).all()


def test_one_loud_condition_does_not_hide_what_the_quiet_ones_show():
    # Misses of 1.0 in five quiet conditions; noise of 20 in the sixth. Sum of squares less sum of noise is negative.
    generator = np.random.default_rng(5)
    deviations = np.array([0.04] * 5 + [20.0])[:, None, None]
    miss = np.exp(1j * generator.uniform(-np.pi, np.pi, 6))[:, None, None]
    miss[5] = 10.0
    shape = (6, 1, 1)
    conditions = tuple(Condition(600.0 * 2**k) for k in range(6))
    healthy = OrderLines(conditions, ("a",), (1.0,), 0.01 + miss, np.broadcast_to(deviations, shape).copy())
    none = np.zeros(0)
    current = Baseline(None, (), none, none, none.astype(bool), np.full(shape, 0.01 + 0j), np.zeros((0, *shape)), none,
                       none, none)  # fmt: skip
    found = left_variance(current, healthy)
    # Each quiet condition has |miss|^2 / 2 = 0.5 a part.
    assert found[0, 0] == pytest.approx(0.5, rel=0.15)
    assert error_covariance(conditions, np.sqrt(found), healthy.parts).shape == (12, 12)


def test_of_a_size_all_that_is_left_is_in_its_one_part():
    generator = np.random.default_rng(8)
    shape = (400, 1, 2)
    conditions = tuple(Condition(600.0 + k) for k in range(400))
    miss = generator.normal(size=shape) + 1j * generator.normal(size=shape) * [1.0, 0.0]
    kinds = (LineKind(), LineKind(phase=False))
    healthy = OrderLines(conditions, ("a",), (1.0, 0.4), 10.0 + miss, np.full(shape, 0.1), kinds)
    assert left_variance(_bare(shape, 10.0), healthy) == pytest.approx(np.ones((1, 2)), rel=0.2)


def test_on_the_scale_a_size_may_be_off_as_all_of_them_are():
    """Nine lines are off by 0.5 D and one fits, by chance; another is not there at all."""
    shape = (4, 1, 11)
    conditions = tuple(Condition(600.0 * 1.1**k) for k in range(4))
    sizes = np.full(shape, 5.0 + 0j)
    sizes[:, 0, :9] += 0.5 * np.array([1, -1, 1, -1])[:, None]
    sizes[:, 0, 10] = 0.0
    kinds = (LineKind(phase=False),) * 11
    orders = tuple(3.1 + k for k in range(11))
    current = _bare(shape, 5.0)
    current = replace(current, lines=np.where(np.arange(11) == 10, 0.0, current.lines))
    plain = OrderLines(conditions, ("a",), orders, sizes, np.full(shape, 0.01), kinds)
    scaled = replace(plain, knees=np.ones((1, 11)))
    apart, together = (residual_error(current, one).at(conditions)[:, 0].mean(axis=0) for one in (plain, scaled))
    assert apart[9] < 0.1
    # Three records like all others, which have 0.9 of that variance, beside its own four.
    assert together[9] == pytest.approx(0.5 * np.sqrt(0.9 * 3 / 7), rel=0.1)
    assert together[10] < 0.05
    assert together[:9].max() < 0.9
    assert (residual_error(current, plain).own_share, residual_error(current, scaled).own_share) == (0.0, OWN_SHARE)


def test_a_share_of_the_error_is_of_one_condition_alone():
    conditions = (Condition(1000.0), Condition(1000.0), Condition(1300.0))
    error = ModelError(np.full((1, 1), 2.0), np.zeros((1, 1)), own_share=0.1)
    found = error_covariance(conditions, error, np.ones((2, 3, 1, 1), dtype=bool))[:3, :3]
    common = 3.6 * np.exp(-0.5 * (np.log(1.3) / error.length) ** 2)
    assert found == pytest.approx(np.array([[4.0, 3.6, common], [3.6, 4.0, common], [common, common, 4.0]]))


def _bare(shape: tuple[int, ...], lines: float) -> Baseline:
    """Return a machine without unknowns whose lines are all alike."""
    none = np.zeros(0)
    return Baseline(
        None, (), none, none, none.astype(bool), np.full(shape, lines + 0j), np.zeros((0, *shape)), none, none, none
    )


def test_what_a_machine_lacks_grows_with_its_speed():
    generator = np.random.default_rng(6)
    conditions = tuple(Condition(speed) for speed in (1000.0, 1500.0, 2000.0, 3000.0))
    shape = (4, 1, 8)
    growing = np.array([one.speed_rpm / 1000 for one in conditions])[:, None, None] ** 2
    miss = growing * np.exp(1j * generator.uniform(-np.pi, np.pi, shape))
    orders = tuple(float(k) for k in range(1, 9))
    noise = 0.05 * growing * np.ones(shape)
    found = residual_error(_bare(shape, 1e-3), OrderLines(conditions, ("a",), orders, 1e-3 + miss, noise))
    assert (found.growth == 2).all()
    # |miss|^2 / 2 a part, and one standard deviation of what four conditions tell of it.
    assert found.deviation == pytest.approx(np.full((1, 8), np.sqrt(0.5)), rel=0.6)
    each = found.at(conditions)
    assert each[:, 0, 0] / each[0, 0, 0] == pytest.approx(growing[:, 0, 0])
    same = error_covariance(conditions, found, np.ones((2, *shape), dtype=bool))
    assert np.diag(same)[:8] == pytest.approx(each[0, 0] ** 2)


def test_what_noise_hides_in_healthy_lines_is_nothing_new():
    # Healthy lines as small as their noise: the machine may lack lines of that size, at one speed as at four.
    conditions = tuple(Condition(speed) for speed in (1000.0, 1500.0, 2000.0, 3000.0))
    generator = np.random.default_rng(7)
    shape = (4, 1, 40)
    amplitudes = generator.normal(size=shape) + 1j * generator.normal(size=shape)
    orders = tuple(float(k) for k in range(1, 41))
    for count in (1, 4):
        healthy = OrderLines(conditions[:count], ("a",), orders, amplitudes[:count], np.ones((count, 1, 40)))
        found = residual_error(_bare((count, 1, 40), 1e-6), healthy)
        each = found.at(conditions[:count])
        assert each.max(axis=0).min() > 0.2
        assert np.median(each) < 2


class _Curved:
    """Stands for a predictor of a machine that does not repeat itself, and whose lines are curved in one parameter."""

    knees, reference, conditions = None, (), tuple(Condition(600.0 * 1.3**k) for k in range(5))
    repeating = False

    def repeats(self, machine):
        return self.repeating

    def prepare(self, machines, **_):
        return [True] * len(machines)

    def amplitudes(self, machine):
        off = np.log(machine.values["coupling_stiffness_n_m"] / _GIVEN)
        shape = 1 + 0.2 * np.arange(5)[:, None, None] * np.ones((5, 1, 3))
        return (shape * (1 + off + 8 * off**2)).astype(complex)


_GIVEN = find_machine("amb_rotor").values["coupling_stiffness_n_m"]


def test_where_the_motion_does_not_repeat_the_last_steps_are_simulated():
    machine, predictor = find_machine("amb_rotor"), _Curved()
    coordinates = coordinates_of([p for p in machine.definition.parameters if p.name == "coupling_stiffness_n_m"])
    given = np.array([coordinates[0].coordinate(_GIVEN)])
    known = machine, coordinates, given, given, np.ones(1, dtype=bool)
    current = linearised(*known, predictor)
    truth = predictor.amplitudes(machine_at(machine, coordinates, given + 1.0))
    scatter = 0.01 * np.random.default_rng(3).normal(size=truth.shape)
    healthy = OrderLines(predictor.conditions, ("a",), (1.0, 2.0, 3.0), truth + scatter, np.full(truth.shape, 0.01))
    found = settled_further(current, healthy, predictor)
    error = residual_error(current, healthy)
    assert objective(found, healthy, error) < objective(current, healthy, error) - 10
    assert found.position == pytest.approx(given + 1.0, abs=0.2)
    assert found.lines == pytest.approx(predictor.amplitudes(found.machine))
    predictor.repeating = True
    assert settled_further(current, healthy, predictor) is current


def test_where_the_motion_does_not_repeat_both_sets_of_conditions_have_the_slopes_of_one_place():
    """Calibration keeps the slopes of where it began: beyond a least size they have the other sign."""
    machine, predictor = find_machine("amb_rotor"), _Curved()
    coordinates = coordinates_of([p for p in machine.definition.parameters if p.name == "coupling_stiffness_n_m"])
    given = np.array([coordinates[0].coordinate(_GIVEN)])
    begun = linearised(machine, coordinates, given - 3.0, given, np.ones(1, dtype=bool), predictor)
    reached = shifted(begun, machine, np.array([3.0]), predictor)
    fresh = again(reached, machine, predictor)
    assert (np.sign(begun.slopes[0].real) == -np.sign(fresh.slopes[0].real)).all()
    healthy = OrderLines(predictor.conditions, ("a",), (1.0, 2.0, 3.0), reached.lines, np.full((5, 1, 3), 0.01))
    both = settled_in_both(reached, healthy, predictor, predictor, lambda _: None)
    for one in both:
        assert one.slopes[0] == pytest.approx(fresh.slopes[0])
        assert one.position == pytest.approx(both[0].position)
        assert one.lines == pytest.approx(predictor.amplitudes(one.machine))
