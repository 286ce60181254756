"""Coupling reaction: forces of springs that turn with, against and along the shaft, at 2X and 3X alone."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effects.axis_misalignment import AxisMisalignment
from rotorwise.simulators.effects.coupling_reaction import CouplingReaction
from rotorwise.simulators.effects.residual_coupling_harmonic import ResidualCouplingHarmonic
from rotorwise.simulators.machine import find_machine, machine_from_toml
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

RIG, AMB = find_machine("test_rig"), find_machine("amb_rotor")
#: So soft a coupling that its ends do not give way to it, and nothing else that moves.
SOFT = AMB.with_parameters(unbalance_kg_m=0.0, coupling_stiffness_n_m=8.0, coupling_rotational_stiffness_n_m_rad=0.01)
NOTHING = {f"{way}_{n}_n": 0.0 for way in ("forward", "backward", "axial") for n in (2, 3)}


def amplitudes(machine, *effects, speed_rpm=2100.0):
    return harmonic_balance(machine.with_effects(*effects), speed_rpm=speed_rpm).amplitudes


@pytest.mark.parametrize("n", [2, 3])
@pytest.mark.parametrize("direction_rad", [0.0, 0.9])
def test_forwards_and_backwards_alike_it_pulses_as_an_offset_that_stands_still(n, direction_rad, figure):
    # A spring k (1 + a_n cos n phi) between axes apart by s along a direction: k a_n s cos(n phi), half of it each way.
    share = AMB.values[f"harmonic_{n}"]
    half = 8.0 * share * 2e-4 / 2
    pulling = direction_rad + math.pi
    reaction = CouplingReaction(
        **{
            **NOTHING,
            f"forward_{n}_n": half,
            f"backward_{n}_n": half,
            f"forward_{n}_rad": pulling / n,
            f"backward_{n}_rad": -pulling / n,
        }
    )
    offset = AxisMisalignment(offset_m=2e-4, angle_rad=0.0, offset_direction_rad=direction_rad)
    one, two = amplitudes(SOFT, reaction)[:, n], amplitudes(SOFT, offset)[:, n]
    assert one == pytest.approx(two, abs=5e-4 * np.abs(two).max())
    figure("Against an offset that stands still, the coupling soft", one, two)


@pytest.mark.parametrize("n", [2, 3])
def test_it_is_the_forces_that_it_states_with_the_moment_of_its_lever(n):
    # 3 N forwards at angle a: x 3 cos(n phi + n a), y 3 sin(n phi + n a); 2 N backwards: the y part turned round.
    a, b, lever = 0.3, -0.8, 0.04
    x = 3 * np.exp(1j * n * a) + 2 * np.exp(1j * n * b)
    y = -3j * np.exp(1j * n * a) + 2j * np.exp(1j * n * b)
    along = 5 * np.exp(1j * n * 0.2)
    sizes = {f"forward_{n}_n": 3.0, f"backward_{n}_n": 2.0, f"axial_{n}_n": 5.0}
    angles = {f"forward_{n}_rad": a, f"backward_{n}_rad": b, f"axial_{n}_rad": 0.2}
    reaction = CouplingReaction(**{**NOTHING, **sizes, **angles}, lever_m=lever)
    stated = ResidualCouplingHarmonic(
        order=float(n),
        x_cosine_n=x.real,
        x_sine_n=-x.imag,
        y_cosine_n=y.real,
        y_sine_n=-y.imag,
        axial_cosine_n=along.real,
        axial_sine_n=-along.imag,
        angle_y_cosine_n_m=lever * x.real,
        angle_y_sine_n_m=-lever * x.imag,
        angle_x_cosine_n_m=-lever * y.real,
        angle_x_sine_n_m=lever * y.imag,
    )
    one, two = amplitudes(RIG, reaction), amplitudes(RIG, stated)
    assert one == pytest.approx(two, rel=1e-9, abs=1e-9 * np.abs(two).max())


@pytest.mark.parametrize("way", ["forward", "backward"])
@pytest.mark.parametrize("n", [2, 3])
def test_the_shaft_circles_the_way_that_the_force_turns(way, n):
    system = AMB.with_parameters(unbalance_kg_m=0.0).with_effects(CouplingReaction(**{**NOTHING, f"{way}_{n}_n": 4.0}))
    found = harmonic_balance(system, speed_rpm=1500.0).amplitudes
    x, y = found[0, n], found[1, n]
    forwards, backwards = abs(x + 1j * y), abs(np.conj(x) + 1j * np.conj(y))
    ahead, behind = (forwards, backwards) if way == "forward" else (backwards, forwards)
    # The uneven coupling sends a little of each order the other way.
    assert ahead > 5 * behind


def test_its_angles_repeat_as_often_as_it_pushes():
    one = CouplingReaction(forward_2_rad=0.1, backward_3_rad=0.2)
    other = CouplingReaction(forward_2_rad=0.1 + math.pi, backward_3_rad=0.2 - 2 * math.pi / 3)
    first = amplitudes(RIG, one)
    assert first == pytest.approx(amplitudes(RIG, other), abs=1e-9 * np.abs(first).max())


def test_lines_are_those_that_it_declares_and_a_file_keeps_it():
    machine = RIG.with_effects(CouplingReaction(axial_3_n=0.0, lever_m=0.01))
    assert [line.order for line in machine.effects[0].signature(RIG)] == [2.0, 3.0]
    change = np.abs(amplitudes(machine) - amplitudes(RIG)).max(axis=0)
    assert np.delete(change, [2, 3]).max() < 1e-9 * change[[2, 3]].min()
    assert machine_from_toml(machine.to_toml()) == machine


def test_a_rigid_flange_and_a_machine_without_coupling_halves_say_so():
    for name in ("rigid_coupling", "gearbox"):
        with pytest.raises(MissingPartError, match="coupling"):
            find_machine(name).with_effects(CouplingReaction()).system(speed_rpm=1000)
