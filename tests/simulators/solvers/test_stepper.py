"""The exponential stepper: order, conservation, agreement with closed forms and with independent solvers."""

import importlib.util

import numpy as np
import pytest
from numba.core.event import install_recorder
from rotorwise.simulators.effects import Unbalance
from rotorwise.simulators.effects.ball_defect import BallDefect
from rotorwise.simulators.effects.outer_race_defect import OuterRaceDefect
from rotorwise.simulators.effects.rub import Rub
from rotorwise.simulators.effects.tooth_crack import ToothCrack
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.oracle import oracle
from rotorwise.simulators.solvers.simulate import SimulationError, simulate_batch
from rotorwise.simulators.solvers.stepper import LaneGroup, Stepper
from rotorwise.simulators.speed_profile import ramp, steady, wander

from .small_machines import duffing, rotor, stop, switching

TURN_A_SECOND = 60.0 / (2 * np.pi)


def stepper(machine, speed, *, step_s, modal=True):
    profile = speed if not isinstance(speed, float) else steady(speed_rpm=speed)
    group = LaneGroup([machine], [profile], [machine.system(speed_rpm=profile)])
    return Stepper(group, step_s=step_s, start_s=0.0, modal=modal)


def final_state(machine, speed, start, *, step_s, duration_s):
    run = stepper(machine, speed, step_s=step_s)
    run.states[:, 0] = run.form.inverse @ start
    run.advance(round(duration_s / step_s))
    return (run.form.basis @ run.states)[:, 0]


def orders(machine, speed, start, truth, steps, duration_s):
    errors = [
        np.linalg.norm(final_state(machine, speed, start, step_s=step, duration_s=duration_s) - truth) for step in steps
    ]
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


def test_order_is_four_on_a_smooth_nonlinear_machine():
    machine = duffing(cubic=2.0, parametric=0.7, drive=1.5)
    start, speed, duration = np.array([0.8, -0.3]), 1.3 * TURN_A_SECOND, 12.8
    times = np.array([duration])
    truth = oracle(
        machine, speed_rpm=speed, start_state=start, start_s=0.0, times_s=times, method="DOP853",
        relative_tolerance=1e-13,
    )[:, -1]  # fmt: skip
    found = orders(machine, speed, start, truth, (0.1, 0.05, 0.025, 0.0125), duration)
    assert np.all(found[1:] >= 3.8), found


def test_order_across_stiffness_jumps():
    machine = switching()
    start, speed, duration = np.array([0.4, -0.1, 0.2, 0.3]), 1.1 * TURN_A_SECOND, 12.8
    truth = oracle(
        machine, speed_rpm=speed, start_state=start, start_s=0.0, times_s=np.array([duration]), method="DOP853",
        relative_tolerance=1e-13,
    )[:, -1]  # fmt: skip
    steps = 0.1 / 2.0 ** np.arange(6)
    errors = [
        np.linalg.norm(final_state(machine, speed, start, step_s=step, duration_s=duration) - truth) for step in steps
    ]
    # Where the jumps fall in a step changes with the step, so the order is that of the whole range.
    order = -np.polyfit(np.arange(6), np.log2(errors), 1)[0]
    print("errors", errors, "order", order)
    assert order >= 2.9


def test_undamped_linear_core_keeps_its_energy():
    machine = rotor(damping=0.0)
    system = machine.system(speed_rpm=3000.0)
    n = len(system.coordinates)
    mass, stiffness = system.mass_matrix, -system.mass_matrix @ system.core[n:, :n]
    for modal in (True, False):
        run = stepper(machine, 3000.0, step_s=1e-3, modal=modal)
        start = np.array([1e-3, -2e-3, 1e-2, 2e-2, 0.3, 0.1, -0.5, 0.4])
        run.states[:, 0] = run.form.inverse @ start

        def energy(y):
            return 0.5 * y[n:] @ mass @ y[n:] + 0.5 * y[:n] @ stiffness @ y[:n]

        run.advance(20_000)
        end = (run.form.basis @ run.states)[:, 0]
        assert energy(end) == pytest.approx(energy(start), rel=1e-9)


def test_unbalance_response_is_the_closed_form():
    machine = rotor(damping=2e-3).with_effects(Unbalance(moment_kg_m=2e-4, angle_rad=0.4))
    speed = 900.0
    run = machine.simulate(speed_rpm=speed, duration_s=0.5, rate_hz=2000.0, settle_s=12.0)
    system = machine.without_effects().system(speed_rpm=speed)
    n, w = 4, speed * 2 * np.pi / 60
    force = np.zeros(2 * n, dtype=complex)
    # Real parts of F exp(i w t): x leads y by a quarter turn.
    unbalance = 2e-4 * w**2 * np.exp(0.4j)
    force[n:] = np.linalg.solve(system.mass_matrix, [unbalance, -1j * unbalance, 0, 0])
    amplitude = np.linalg.solve(1j * w * np.eye(2 * n) - system.core, force)
    expected = (amplitude[:2, None] * np.exp(1j * run.phase_rad)).real
    for probe, wave in (("x displacement", expected[0]), ("y displacement", expected[1])):
        # The output filter's pass band is flat to 1e-5.
        assert np.abs(run.probe(probe) - wave).max() < 3e-5 * np.abs(wave).max()


@pytest.mark.parametrize("method", [pytest.param("Radau", marks=pytest.mark.slow), "LSODA", "CVODE"])
def test_run_up_agrees_with_an_implicit_solver(method):
    if method == "CVODE" and importlib.util.find_spec("sksundae") is None:
        pytest.skip("scikit-sundae is not installed")
    machine = rotor(parametric=500.0).with_effects(Unbalance(moment_kg_m=1e-4))
    profile = ramp(start_rpm=300.0, stop_rpm=2400.0, duration_s=0.4)
    start = np.zeros(8)
    run = stepper(machine, profile, step_s=1e-4)
    run.states[:] = 0.0
    run.advance(4000)
    found = (run.form.basis @ run.states)[:, 0]
    truth = oracle(
        machine, speed_rpm=profile, start_state=start, start_s=0.0, times_s=np.array([0.4]), method=method,
        relative_tolerance=1e-8, absolute_tolerance=1e-12,
    )[:, -1]  # fmt: skip
    assert np.linalg.norm(found[:4] - truth[:4]) < 2e-5 * np.linalg.norm(truth[:4])


def test_lanes_do_not_influence_each_other():
    machines = [duffing().with_parameters(cubic=c, drive=d) for c, d in ((0.0, 1.0), (2.0, 1.0), (1.0, 0.3))]
    cases = [(machine, speed) for machine, speed in zip(machines, (9.0, 10.0, 12.0), strict=True)]
    cases.append((machines[1], ramp(start_rpm=8.0, stop_rpm=12.0, duration_s=40.0)))
    options = {"duration_s": 40.0, "rate_hz": 5.0, "settle_s": 3.0}
    together = simulate_batch(cases, **options)
    for case, result in zip(cases, together, strict=True):
        assert np.array_equal(simulate_batch([case], **options)[0].signals, result.signals)
    threaded = simulate_batch(cases, threads=2, **options)
    assert all(np.array_equal(a.signals, b.signals) for a, b in zip(together, threaded, strict=True))


def test_many_lanes_change_no_bits():
    # Several blocks, with jumps, contacts and damage.
    machine = find_machine("gearbox").with_effects(OuterRaceDefect(), BallDefect(), ToothCrack())
    cases = [(machine.with_parameters(load_torque_n_m=20.0 + i), 1800.0) for i in range(41)]
    options = {"duration_s": 0.02, "rate_hz": 20_000.0, "settle_s": 0.02}
    together = simulate_batch(cases, **options)
    for lane in (0, 17, 39, 40):
        assert np.array_equal(simulate_batch([cases[lane]], **options)[0].signals, together[lane].signals)
    # Seven are summed by four, two and one.
    for few, many in zip(simulate_batch(cases[:7], **options), together, strict=False):
        assert np.array_equal(few.signals, many.signals)


def test_lanes_whose_parameters_mean_something_else_stay_apart():
    # Three pits have as many parameters as three spots.
    base = find_machine("test_rig")
    pits = base.with_effects(*[OuterRaceDefect(size_m=1e-3 * k) for k in (1, 2, 3)])
    spots = base.with_effects(*[BallDefect(size_m=1e-3 * k) for k in (1, 2, 3)])
    options = {"duration_s": 0.02, "rate_hz": 5000.0, "settle_s": 0.0}
    together = simulate_batch([(pits, 1800.0), (spots, 1800.0)], **options)
    for machine, result in zip((pits, spots), together, strict=True):
        assert np.array_equal(machine.simulate(speed_rpm=1800.0, **options).signals, result.signals)


def test_fewer_probes_change_no_bits_and_limits_stay_watched():
    machine = find_machine("gearbox").with_effects(ToothCrack())
    options = {"speed_rpm": 1800.0, "duration_s": 0.02, "rate_hz": 20_000.0, "settle_s": 0.01}
    whole, some = machine.simulate(**options), machine.simulate(probes=("wheel y", "bearing 1 x"), **options)
    assert [probe.name for probe in some.probes] == ["bearing 1 x", "wheel y"]
    assert all(np.array_equal(some.probe(p.name), whole.probe(p.name)) for p in some.probes)
    rotor_in_magnets = find_machine("amb_rotor").simulate(
        speed_rpm=2000.0, duration_s=0.1, rate_hz=1000.0, settle_s=0.0, probes=("path_2",)
    )
    assert len(rotor_in_magnets.probes) == 4
    with pytest.raises(InvalidValueError, match=r"No probe 'nose'; allowed: accelerometer"):
        machine.simulate(probes=("nose",), **options)


def test_a_new_combination_of_effects_compiles_nothing():
    machine, options = find_machine("test_rig"), {"duration_s": 0.01, "rate_hz": 5000.0, "settle_s": 0.0}
    for effect in (Unbalance(), OuterRaceDefect(), Rub()):
        machine.with_effects(effect).simulate(speed_rpm=1800.0, **options)
    with install_recorder("numba:compile") as compiling:
        together = machine.with_effects(Unbalance(), OuterRaceDefect(), Rub())
        simulate_batch([(together, 1800.0), (together, 1900.0)], **options)
    assert not compiling.buffer


def test_modal_coordinates_change_nothing():
    machine = rotor(parametric=900.0).with_effects(Unbalance(moment_kg_m=1e-4))
    options = {"speed_rpm": 1500.0, "duration_s": 0.2, "rate_hz": 2500.0}
    modal = machine.simulate(**options)
    plain = machine.simulate(modal=False, **options)
    assert np.abs(modal.signals - plain.signals).max(axis=1) == pytest.approx(0, abs=1e-9 * np.abs(plain.signals).max())


def test_error_estimate_is_the_error():
    machine = switching()
    options = {"speed_rpm": 1.1 * TURN_A_SECOND, "duration_s": 60.0, "rate_hz": 2.0, "settle_s": 10.0}
    coarse = machine.simulate(step_s=0.25, estimate_error=True, **options)
    exact = machine.simulate(step_s=0.01, **options)
    true = np.std(coarse.signals - exact.signals, axis=1) / np.std(exact.signals, axis=1)
    assert coarse.errors is not None
    assert np.all(coarse.errors < 1.5 * true)
    assert np.all(coarse.errors > 0.5 * true)


def test_speed_wander_has_the_profile_that_was_asked_for():
    profile = wander(speed_rpm=1800.0, deviation=0.01, bandwidth_hz=5.0, duration_s=4.0, seed=3)
    time = np.linspace(0, 4, 40_001)
    speed = profile.speed_rad_s(time)
    assert speed.std() / speed.mean() == pytest.approx(0.01, rel=0.1)
    phase = profile.phase_rad(time)
    assert np.gradient(phase, time)[1:-1] == pytest.approx(speed[1:-1], rel=1e-4)


@pytest.mark.parametrize(("damping", "word"), [(-0.2, "drifts"), (-8.0, "grew beyond"), (-60.0, "grew beyond")])
def test_instability_is_an_error_that_names_the_machine(damping, word):
    machine = duffing(stiffness=100.0, drive=0.1).with_parameters(damping=damping)
    with pytest.raises(SimulationError, match=f"small .*damping.*{word}"):
        machine.simulate(speed_rpm=10.0, duration_s=100.0, rate_hz=4.0)


@pytest.mark.parametrize(
    "options",
    [
        {"duration_s": 0.0, "rate_hz": 10.0},
        {"duration_s": 1.0, "rate_hz": -1.0},
        {"duration_s": 0.01, "rate_hz": 10.0},
        {"duration_s": 1.0, "rate_hz": 10.0, "step_s": 0.0},
        {"duration_s": float("nan"), "rate_hz": 10.0},
    ],
)
def test_bad_requests_are_refused(options):
    with pytest.raises(InvalidValueError, match=r"allowed|longer"):
        duffing().simulate(speed_rpm=60.0, **options)


def test_speed_is_never_guessed():
    for speed in (0.0, -3.0, float("nan"), "fast", True):
        with pytest.raises(InvalidValueError, match="rpm"):
            duffing().simulate(speed_rpm=speed, duration_s=1.0, rate_hz=10.0)


def test_a_hard_contact_shortens_the_step_and_says_so():
    hard = stop(stiffness=1e7)
    options = {"speed_rpm": 8 * TURN_A_SECOND, "duration_s": 2.0}
    run = hard.simulate(rate_hz=100.0, **options)
    assert run.step_s <= 1 / (2 * np.sqrt(1e7))
    assert any("step was shortened" in note and "stop" in note for note in run.notes)
    # Seen at a high rate it strikes, and no deeper than its energy allows.
    run = hard.simulate(rate_hz=20_000.0, **options)
    deepest = run.probe("a displacement").max() - 0.02
    assert 0 < deepest < np.abs(run.probe("a velocity")).max() * np.sqrt(1 / 1e7) * 1.1
    soft = stop(stiffness=10.0).simulate(rate_hz=100.0, **options)
    assert soft.step_s == pytest.approx(5e-3)
    assert not soft.notes


def test_an_impossible_contact_is_refused():
    with pytest.raises(InvalidValueError, match="contact"):
        stop(stiffness=1e18).simulate(speed_rpm=100.0, duration_s=1.0, rate_hz=100.0)


def test_forces_that_read_no_motion_take_the_short_way_to_the_same_answer():
    machine = rotor(damping=2e-3).with_effects(Unbalance(moment_kg_m=1e-4), Unbalance(moment_kg_m=3e-5, angle_rad=2.0))
    profile = ramp(start_rpm=600.0, stop_rpm=620.0, duration_s=1.0)
    options = {"step_s": 5e-4}
    short = stepper(machine, 900.0, **options)
    assert short._open_loop is not None
    long = stepper(machine, 900.0, **options)
    long._open_loop = None
    one, two = short.advance(3000), long.advance(3000)
    assert np.abs(one - two).max(axis=(0, 2)) == pytest.approx(0, abs=1e-12 * np.abs(two).max())
    # A changing speed makes the gyroscopic moment read the motion.
    assert stepper(machine, profile, **options)._open_loop is None
