"""What a well-known rotor-dynamics package gets wrong (ROSS 3.1.0, seen by running it), asked of our machines.

Its rigid misalignment of 0.2 mm moves the shaft by 99 mm; load torque has no lateral effect; the coupling's force does
not depend on the motion, so that 1X never changes; gravity is off and says nothing; the API 617 limit has lost a square
root; each fault has a run method of its own, so that two cannot be in one run.
"""

import cmath
import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.bolt_loss import BoltLoss
from rotorwise.simulators.effects.coupling_misalignment import CouplingMisalignment
from rotorwise.simulators.effects.coupling_stiffness_harmonics import CouplingStiffnessHarmonics
from rotorwise.simulators.effects.gravity import Gravity
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

ROOT = Path(__file__).parents[2]
ALIGNED = find_machine("rigid_coupling").with_parameters(hole_circle_offset_m=0.0, axis_offset_m=0.0)
AMB_ROTOR = find_machine("amb_rotor")
#: Constant coupling, no unbalance: whatever moves comes from what a test adds.
QUIET_AMB = AMB_ROTOR.with_parameters(harmonic_1=0.0, harmonic_2=0.0, harmonic_3=0.0, unbalance_kg_m=0.0)
BOLT = ALIGNED.values["bolt_stiffness_n_m"]
RADIUS, BOLTS = 0.3, 4


def two_rotor_motion(coupling_n_m, force_n, *, speed_rpm):
    """Return the complex motion of both rotors (x + i y, turning) under a force between them; 0 rpm: at rest."""
    values, omega = ALIGNED.values, speed_rpm * math.pi / 30
    own = [
        values[f"support_{n}_n_m"]
        - values[f"mass_{n}_kg"] * omega**2
        + 1j * omega * values[f"support_damping_{n}_n_s_m"]
        for n in (1, 2)
    ]
    spring = coupling_n_m * np.array([[1, -1], [-1, 1]])
    return np.linalg.solve(np.diag(own) + spring, np.array([-force_n, force_n]))


# -- rigid misalignment of 0.2 mm moves the shaft by 99 mm ------------------------------------------------------


@settings(deadline=None, max_examples=25)
@given(offset_m=st.floats(1e-5, 1e-3), speed_rpm=st.floats(300.0, 1800.0), phase=st.floats(-3.0, 3.0))
def test_rigid_misalignment_has_the_closed_form_of_two_rotors_on_a_spring(offset_m, speed_rpm, phase):
    # Near the torsional resonance and its half the twist answers; the closed form has none.
    torsional_rpm = 60 * 20.0 * math.sqrt(1 + 9 / 160)
    assume(all(abs(speed_rpm / (share * torsional_rpm) - 1) > 0.05 for share in (1.0, 0.5)))
    machine = ALIGNED.with_effects(CouplingMisalignment(offset_m=offset_m, offset_phase_rad=phase))
    motion = harmonic_balance(machine, speed_rpm=speed_rpm, harmonics=4)
    stiffness = BOLTS * BOLT
    expected = np.abs(two_rotor_motion(stiffness, stiffness * offset_m, speed_rpm=speed_rpm))
    found = [abs(motion.amplitude(f"rotor_{n}.x", 1.0)) for n in (1, 2)]
    # What the twist changes grows with the square of the offset.
    assert found == pytest.approx(expected, rel=1e-3)


def test_rigid_misalignment_of_a_fifth_of_a_millimetre_moves_the_shaft_by_less_than_that():
    # 1200 rpm is half the lateral resonance: the motion is a share of the offset, never a multiple.
    machine = ALIGNED.with_effects(CouplingMisalignment(offset_m=2e-4, offset_phase_rad=math.pi / 2))
    result = machine.simulate(speed_rpm=1200, duration_s=1.0, rate_hz=500)
    for name in ("rotor_2.x", "rotor_2.y"):
        assert 1e-5 < np.abs(result.probe(name)).max() < 2e-4


# -- load torque has no lateral effect --------------------------------------------------------------------------


@pytest.mark.parametrize("torque", [200.0, 1000.0])
def test_load_torque_shakes_a_flange_with_a_lost_bolt(torque):
    # Three bolts share the torque T; what the fourth would carry is a force turning with the shaft, K r twist at 1X.
    # The shafts give way to it by R K r twist, which turns the flange a little further:
    # twist = T / (3 K r^2 - K^2 r^2 Re R). Left out is the square of the twist, at most 1e-4.
    machine = ALIGNED.with_parameters(load_torque_n_m=torque).with_effects(BoltLoss(loss=1.0, angle_rad=0.0))
    motion = harmonic_balance(machine, speed_rpm=600)
    unit = two_rotor_motion(3 * BOLT, 1.0, speed_rpm=600)
    gives_way = (unit[1] - unit[0]).real
    twist = torque / (3 * BOLT * RADIUS**2 - (BOLT * RADIUS) ** 2 * gives_way)
    expected = BOLT * RADIUS * twist * np.abs(unit)
    assert expected[1] > 1e-5
    found = [abs(motion.amplitude(f"rotor_{n}.x", 1.0)) for n in (1, 2)]
    assert found == pytest.approx(expected, rel=1e-4)


def test_without_torque_a_lost_bolt_alone_moves_nothing():
    machine = ALIGNED.with_parameters(load_torque_n_m=0.0).with_effects(BoltLoss(loss=1.0, angle_rad=0.0))
    motion = harmonic_balance(machine, speed_rpm=600)
    assert np.abs(motion.amplitudes[:4]).max() < 1e-15


def test_load_torque_turns_the_force_of_a_misaligned_flange():
    # All bolts there: the twist of rotor 2 turns its hole circle, and 1X with it.
    effect = CouplingMisalignment(offset_m=2e-4, offset_phase_rad=math.pi / 2)
    lines = [
        harmonic_balance(ALIGNED.with_parameters(load_torque_n_m=torque).with_effects(effect), speed_rpm=600).amplitude(
            "rotor_1.y", 1.0
        )
        for torque in (0.0, 2000.0)
    ]
    twist = math.asin(2000.0 / (BOLTS * BOLT * RADIUS**2))
    assert cmath.phase(lines[1] / lines[0]) == pytest.approx(-twist, rel=1e-3)


# -- the coupling's force does not depend on the motion, 1X never changes ---------------------------------------


def test_misaligned_flexible_coupling_pushes_less_where_the_shaft_gives_way():
    # F = -k (z + delta) with z = G F, G the shaft without the coupling: z = -(1 + k G)^-1 k G delta. A force given in
    # advance, -k delta, would make z = -k G delta.
    offset, stiffness = 2e-4, AMB_ROTOR.values["coupling_stiffness_n_m"]
    speed_rpm = 1800.0
    uncoupled = QUIET_AMB.with_parameters(coupling_stiffness_n_m=0.0).system(speed_rpm=speed_rpm)
    hub = [uncoupled.coordinates.index(f"node_0.{axis}") for axis in "xy"]
    n = len(uncoupled.coordinates)
    columns = np.zeros((uncoupled.states, 2))
    columns[n : 2 * n] = np.linalg.inv(uncoupled.mass_matrix)[:, hub]
    pencil = 1j * speed_rpm * math.pi / 30 * np.eye(uncoupled.states) - uncoupled.core
    states = np.linalg.solve(pencil, columns)
    turning = offset * np.array([1.0, -1j])
    own = stiffness * states[hub]
    hub_motion = -np.linalg.solve(np.eye(2) + own, own @ turning)
    expected = uncoupled.probe_rows @ states @ (-stiffness * (hub_motion + turning))
    given_in_advance = uncoupled.probe_rows @ states @ (-stiffness * turning)
    machine = QUIET_AMB.with_effects(CouplingMisalignment(offset_m=offset, angle_rad=0.0, offset_phase_rad=0.0))
    found = harmonic_balance(machine, speed_rpm=speed_rpm).amplitudes[:, 1]
    # Two ways to solve 124 equations whose coefficients span many decades.
    assert found == pytest.approx(expected, rel=1e-7)
    assert np.abs(found - given_in_advance).max() > 0.1 * np.abs(found).max()


def test_1x_changes_with_misalignment_and_may_fall():
    # Misalignment and unbalance add as vectors: the phase of the offset decides whether 1X rises or falls.
    def line(effects):
        return abs(harmonic_balance(AMB_ROTOR.with_effects(*effects), speed_rpm=1800).amplitude("path_1", 1.0))

    phases = np.linspace(-math.pi, math.pi, 12, endpoint=False)
    lines = [line([CouplingMisalignment(offset_m=5e-5, angle_rad=0.0, offset_phase_rad=p)]) for p in phases]
    aligned = line([])
    assert max(lines) > 1.1 * aligned
    assert min(lines) < 0.9 * aligned


# -- gravity is off and says nothing ----------------------------------------------------------------------------


def test_weight_sags_both_rotors_on_their_springs():
    motion = harmonic_balance(ALIGNED.with_effects(Gravity(gravity_m_s2=9.81)), speed_rpm=1200)
    values = ALIGNED.values
    spring = BOLTS * BOLT * np.array([[1, -1], [-1, 1]])
    stiffness = np.diag([values["support_1_n_m"], values["support_2_n_m"]]) + spring
    expected = np.linalg.solve(stiffness, -9.81 * np.array([values["mass_1_kg"], values["mass_2_kg"]]))
    found = [motion.amplitude(f"rotor_{n}.y", 0.0).real for n in (1, 2)]
    assert found == pytest.approx(expected, rel=1e-9)
    assert abs(motion.amplitude("rotor_2.x", 0.0)) < 1e-12


def test_weight_raises_the_lines_of_a_turning_defect():
    # The sag of rotor 2 against rotor 1 makes a torque N K_b sag h once a revolution on the offset flange, which twists
    # two inertias on their spring.
    offset, speed_rpm, values = 2e-4, 600.0, ALIGNED.values
    turning = ALIGNED.with_parameters(hole_circle_offset_m=offset, load_torque_n_m=0.0)
    level, sagged = (harmonic_balance(m, speed_rpm=speed_rpm) for m in (turning, turning.with_effects(Gravity())))
    sag = abs((sagged.amplitude("rotor_2.y", 0.0) - sagged.amplitude("rotor_1.y", 0.0)).real)
    omega = speed_rpm * math.pi / 30
    inertia = [values[f"mass_{n}_kg"] * values[f"gyration_radius_{n}_m"] ** 2 for n in (1, 2)]
    held = values["drive_stiffness_n_m_rad"] + 1j * omega * values["drive_damping_n_m_s_rad"]
    spring = BOLTS * BOLT * RADIUS**2 + 1j * omega * values["torsional_damping_n_m_s_rad"]
    dynamic = np.diag([held, 0.0]) - omega**2 * np.diag(inertia) + spring * np.array([[1, -1], [-1, 1]])
    turns = np.linalg.solve(dynamic, [0.0, BOLTS * BOLT * sag * offset])
    assert abs(sagged.amplitude("twist", 1.0)) == pytest.approx(abs(turns[1] - turns[0]), rel=1e-3)
    assert abs(level.amplitude("twist", 1.0)) < 1e-3 * abs(sagged.amplitude("twist", 1.0))


def test_a_machine_with_its_own_weight_refuses_a_second_one():
    with pytest.raises(MissingPartError, match="weight already"):
        find_machine("test_rig").with_effects(Gravity()).system(speed_rpm=1200)


# -- 12000 / sqrt(N) for sqrt(12000 / N) ------------------------------------------------------------------------

#: 12000 / sqrt(N) and 12000 / N ** 0.5, with any module before the root.
LOST_ROOT = re.compile(r"12_?000(?:\.0*)?\s*/\s*(?:(?:\w+\.)?sqrt\b|[\w.]+\s*\*\*\s*0?\.5)")


@pytest.mark.parametrize("wrong", ["25.4 * 12000 / np.sqrt(n)", "12000.0/sqrt(speed_rpm)", "12_000 / n**0.5"])
def test_search_sees_the_lost_root(wrong):
    assert LOST_ROOT.search(wrong)


@pytest.mark.parametrize(
    "right", ["25.4 * math.sqrt(12000 / n)", "(12000 / n) ** 0.5", "math.sqrt(12000) / math.sqrt(n)"]
)
def test_search_leaves_the_right_root_alone(right):
    assert not LOST_ROOT.search(right)


def test_lost_root_is_nowhere():
    files = [
        path
        for folder in ("simulators", "datasets", "diagnose")
        for suffix in ("py", "toml")
        for path in (ROOT / folder).rglob(f"*.{suffix}")
    ]
    assert len(files) > 100
    assert [path for path in files if LOST_ROOT.search(path.read_text(encoding="utf-8"))] == []


# -- each fault has a run method of its own ---------------------------------------------------------------------


def test_faults_of_a_linear_machine_add_up_in_one_run():
    faults = (
        Unbalance(moment_kg_m=1e-4, angle_rad=0.5),
        CouplingMisalignment(offset_m=1e-4, angle_rad=0.0, offset_phase_rad=1.0),
        CouplingMisalignment(offset_m=0.0, angle_rad=2e-3, angle_phase_rad=-1.0),
    )
    runs = [
        QUIET_AMB.with_effects(*chosen).simulate(speed_rpm=1800, duration_s=0.2, rate_hz=1000)
        for chosen in (faults, *((fault,) for fault in faults))
    ]
    together, parts = runs[0].signals, [run.signals for run in runs[1:]]
    assert min(np.abs(part).max() for part in parts) > 1e-7
    assert together == pytest.approx(sum(parts), abs=1e-9 * np.abs(together).max())


def test_faults_that_act_on_each_other_do_so_in_one_run():
    # Stiffness harmonics and misalignment: neither alone has 2X, both together do (n - 1 and n + 1).
    faults = (CouplingStiffnessHarmonics(x_1=0.3), CouplingMisalignment(offset_m=2e-4, angle_rad=0.0))
    second = [
        abs(harmonic_balance(QUIET_AMB.with_effects(*chosen), speed_rpm=1800).amplitude("path_1", 2.0))
        for chosen in (faults, faults[:1], faults[1:])
    ]
    assert second[0] > 1e-7
    assert max(second[1:]) < 1e-6 * second[0]


def test_four_faults_of_a_nonlinear_machine_in_one_run_agree_with_the_balance():
    machine = ALIGNED.with_effects(
        Unbalance(moment_kg_m=0.02), CouplingMisalignment(offset_m=2e-4), BoltLoss(loss=0.5), Gravity()
    )
    result = machine.simulate(speed_rpm=1000, duration_s=0.3, rate_hz=500)
    motion = harmonic_balance(machine, speed_rpm=1000)
    scale = np.abs(motion.amplitudes[:, 1:]).sum(axis=1, keepdims=True)
    # exp(-60 / 8 s) of the transient is left after settling, and a low-pass filter flat to 1e-4.
    assert np.abs((result.signals - motion.waveform(result.phase_rad)) / scale).max() < 2e-3
