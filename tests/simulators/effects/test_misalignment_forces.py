"""Misalignment forces: forces and moments of springs, with, against and along the shaft, and of a mass that circles."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.axis_misalignment import AxisMisalignment
from rotorwise.simulators.effects.misalignment_forces import MisalignmentForces
from rotorwise.simulators.effects.residual_coupling_harmonic import ResidualCouplingHarmonic
from rotorwise.simulators.machine import find_machine, machine_from_toml
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

RIG, AMB = find_machine("test_rig"), find_machine("amb_rotor")
#: So soft a coupling that its ends do not give way to it, and nothing else that moves.
SOFT = AMB.with_parameters(unbalance_kg_m=0.0, coupling_stiffness_n_m=8.0, coupling_rotational_stiffness_n_m_rad=0.01)
NOTHING = {p.name: 0.0 for p in MisalignmentForces.parameters() if p.zero is not None}


def amplitudes(machine, *effects, speed_rpm=2100.0):
    return harmonic_balance(machine.with_effects(*effects), speed_rpm=speed_rpm).amplitudes


@pytest.mark.parametrize("n", [2, 3])
@pytest.mark.parametrize("direction_rad", [0.0, 0.9])
def test_forwards_and_backwards_alike_it_pulses_as_an_offset_that_stands_still(n, direction_rad, figure):
    # A spring k (1 + a_n cos n phi) between axes apart by s along a direction: k a_n s cos(n phi), half of it each way.
    share = AMB.values[f"harmonic_{n}"]
    half = 8.0 * share * 2e-4 / 2
    pulling = direction_rad + math.pi
    forces = MisalignmentForces(
        **{
            **NOTHING,
            f"forward_{n}_n": half,
            f"backward_{n}_n": half,
            f"forward_{n}_rad": pulling / n,
            f"backward_{n}_rad": -pulling / n,
        }
    )
    offset = AxisMisalignment(offset_m=2e-4, angle_rad=0.0, offset_direction_rad=direction_rad)
    one, two = amplitudes(SOFT, forces)[:, n], amplitudes(SOFT, offset)[:, n]
    assert one == pytest.approx(two, abs=5e-4 * np.abs(two).max())
    figure("Against an offset that stands still, the coupling soft", one, two)


@pytest.mark.parametrize("n", [1, 2, 3, 4])
def test_it_is_the_forces_and_moments_that_it_states(n):
    # 3 N forwards at angle a: x 3 cos(n phi + n a), y 3 sin(n phi + n a); 2 N backwards: the y part turned round.
    a, b, c, d = 0.3, -0.8, 0.2, 1.1
    turned = {name: np.exp(1j * n * at) for name, at in zip("abcd", (a, b, c, d), strict=True)}
    x, y = 3 * turned["a"] + 2 * turned["b"], -3j * turned["a"] + 2j * turned["b"]
    along = 5 * turned["c"]
    # A plane of bending between x and z turns about y, one between y and z about -x.
    about_y, about_x = 0.4 * turned["c"] + 0.1 * turned["d"], -(-0.4j * turned["c"] + 0.1j * turned["d"])
    sizes = {f"forward_{n}_n": 3.0, f"backward_{n}_n": 2.0, f"axial_{n}_n": 5.0}
    sizes |= {f"forward_bend_{n}_n_m": 0.4, f"backward_bend_{n}_n_m": 0.1}
    angles = {f"forward_{n}_rad": a, f"backward_{n}_rad": b, f"axial_{n}_rad": c}
    angles |= {f"forward_bend_{n}_rad": c, f"backward_bend_{n}_rad": d}
    stated = ResidualCouplingHarmonic(
        order=float(n),
        x_cosine_n=x.real,
        x_sine_n=-x.imag,
        y_cosine_n=y.real,
        y_sine_n=-y.imag,
        axial_cosine_n=along.real,
        axial_sine_n=-along.imag,
        angle_y_cosine_n_m=about_y.real,
        angle_y_sine_n_m=-about_y.imag,
        angle_x_cosine_n_m=about_x.real,
        angle_x_sine_n_m=-about_x.imag,
    )
    one, two = amplitudes(RIG, MisalignmentForces(**{**NOTHING, **sizes, **angles})), amplitudes(RIG, stated)
    assert one == pytest.approx(two, rel=1e-9, abs=1e-9 * np.abs(two).max())


@pytest.mark.parametrize("speed_rpm", [900.0, 2400.0])
def test_a_floating_disc_pulls_with_its_centrifugal_force(speed_rpm):
    # Half of U (2 w)^2 on the driven hub; the motor's end stands still on this machine.
    circling = MisalignmentForces(**{**NOTHING, "circling_2_kg_m": 2e-5, "circling_2_rad": 0.4})
    force = 2e-5 * (2 * speed_rpm * math.pi / 30) ** 2 / 2
    turning = MisalignmentForces(**{**NOTHING, "forward_2_n": force, "forward_2_rad": 0.4})
    one = amplitudes(AMB, circling, speed_rpm=speed_rpm)
    assert one == pytest.approx(amplitudes(AMB, turning, speed_rpm=speed_rpm), rel=1e-9, abs=1e-18)
    (line,) = circling.signature(AMB)
    assert (line.order, line.speed_exponent) == (2.0, 2.0)


@pytest.mark.parametrize("way", ["forward", "backward"])
@pytest.mark.parametrize("n", [2, 3])
def test_the_shaft_circles_the_way_that_the_force_turns(way, n):
    system = AMB.with_parameters(unbalance_kg_m=0.0).with_effects(
        MisalignmentForces(**{**NOTHING, f"{way}_{n}_n": 4.0})
    )
    found = harmonic_balance(system, speed_rpm=1500.0).amplitudes
    x, y = found[0, n], found[1, n]
    forwards, backwards = abs(x + 1j * y), abs(np.conj(x) + 1j * np.conj(y))
    ahead, behind = (forwards, backwards) if way == "forward" else (backwards, forwards)
    # The uneven coupling sends a little of each order the other way.
    assert ahead > 5 * behind


def test_lines_are_those_that_it_declares_and_a_file_keeps_it():
    machine = RIG.with_effects(MisalignmentForces(**{**NOTHING, "backward_2_n": 3.0, "axial_3_n": 4.0}))
    assert [line.order for line in machine.effects[0].signature(RIG)] == [2.0, 3.0]
    change = np.abs(amplitudes(machine) - amplitudes(RIG)).max(axis=0)
    assert np.delete(change, [2, 3]).max() < 1e-9 * change[[2, 3]].min()
    assert machine_from_toml(machine.to_toml()) == machine
    every = MisalignmentForces().signature(RIG)
    assert [(line.order, line.speed_exponent) for line in every] == [(2.0, None), (3.0, 0.0), (4.0, 0.0), (1.0, 0.0)]


def test_a_rigid_flange_and_a_machine_without_coupling_halves_say_so():
    for name in ("rigid_coupling", "gearbox"):
        with pytest.raises(MissingPartError, match="coupling"):
            find_machine(name).with_effects(MisalignmentForces()).system(speed_rpm=1000)
