"""Cost and agreement of a linear rotor against ROSS 3.1.0's documented misalignment example.

    OPENBLAS_NUM_THREADS=1 python tests/benchmarks/ross_speed.py ROSS_PYTHON

ROSS_PYTHON is the Python of an environment with ross-rotordynamics 3.1.0; `ross_side.py` runs there. The rotor is
ROSS's `rotor_example_with_damping`: 34 nodes with six degrees of freedom, two discs, two bearings, 1200 rpm, step
1e-4 s. Ours has the same 204: bending from `shaft_elements`, torsion from `shaft_torsion`, and bars along the axis,
which are made here because no machine of ours needs them. Its coupling force is a given function of the shaft angle,
as ROSS's is, with ROSS's own harmonics.

The truth is ROSS's default way after 4 s, exact but for the force between its samples (1e-5). Errors are relative rms
over the last revolution, the mean left out, the worst of x and y of both discs. Process CPU time, smallest of several.
Ours is run with ROSS's step, and with one of 2 ms, 12 to a period of 2X: the force is integrated to fourth order and
need not be sampled as finely. "Stepping alone" divides the slopes of cost over duration; "all included" has matrices,
modes, tables and low-pass filter on our side, the finished rotor object on ROSS's.
"""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from rotorwise.simulators.assembly import Place, Probe
from rotorwise.simulators.law import InterfaceForce, Law
from rotorwise.simulators.machine import Machine, MachineDefinition, Preset
from rotorwise.simulators.rotor_dynamics.harmonic_force import rotating_mass
from rotorwise.simulators.rotor_dynamics.shaft_elements import COORDINATES, assemble_rotor
from rotorwise.simulators.rotor_dynamics.shaft_parts import Disc, Material, ShaftElement
from rotorwise.simulators.rotor_dynamics.shaft_torsion import assemble_torsion
from rotorwise.simulators.solvers import frequency_response
from rotorwise.simulators.solvers import harmonic_balance as solver
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance
from rotorwise.simulators.solvers.simulate import simulate_batch
from rotorwise.simulators.solvers.stepper import LaneGroup, Stepper
from rotorwise.simulators.speed_profile import steady

# The documented rotor, in SI units. Poisson's ratio follows from E = 217 GPa and G = 81.2 GPa.
MATERIAL = Material(2.17e11, 7850.0, 2.17 / (2 * 0.812) - 1)
DIAMETER_M = 0.019
DISCS = [Disc(node, 2.6375, 0.003844540885417, 0.0075132484375) for node in (12, 24)]
BEARINGS = {4: (4.4e5, 4.6114e5, 27.4, 2.505), 31: (9.5e5, 1.09e8, 50.4, 100.4553)}
MASS_DAMPING_1_S, STIFFNESS_DAMPING_S = 8.0501, 1e-5
UNBALANCE_KG_M, UNBALANCE_PHASE_RAD = 5e-4, -np.pi / 2
#: Harmonics of the coupling force beyond this are below 1e-7 of the second.
HARMONICS = 5
#: Modes above it are left out; a step for 1X and 2X at 20 and 40 Hz.
HIGHEST_HZ, LONG_STEP_S = 2000.0, 2e-3
DURATIONS_S = (0.5, 2.0)


def coupling_signals(timeline, parameters):
    """Return the forces in x and y; parameters are cosine and sine coefficients of the orders 0, 1, ..."""
    x, y = np.zeros(timeline.time_s.shape), np.zeros(timeline.time_s.shape)
    for order, (cos_x, sin_x, cos_y, sin_y) in enumerate(parameters.reshape(-1, 4, parameters.shape[1])):
        cos, sin = timeline.cos_sin(float(order))
        x += cos_x * cos + sin_x * sin
        y += cos_y * cos + sin_y * sin
    return np.stack([x, y])


COUPLING_FORCE = Law("given coupling force", coupling_signals)


def rotor_machine(nodes_m, coupling_force_n, *, all_directions=True):
    """Return the documented rotor as a machine of ours."""
    elements = [ShaftElement(float(length), DIAMETER_M) for length in np.diff(nodes_m)]
    spectrum = np.fft.rfft(coupling_force_n)[:, : HARMONICS + 1] / coupling_force_n.shape[1]
    spectrum[:, 1:] *= 2
    series = np.stack([spectrum[0].real, -spectrum[0].imag, spectrum[1].real, -spectrum[1].imag], axis=1)

    def build(assembly, values, switches):
        add_shaft(assembly, elements, all_directions=all_directions)
        for node, (stiffness_x, stiffness_y, damping_x, damping_y) in BEARINGS.items():
            assembly.add_spring({f"node_{node}.x": 1.0}, stiffness=stiffness_x, damping=damping_x)
            assembly.add_spring({f"node_{node}.y": 1.0}, stiffness=stiffness_y, damping=damping_y)
        add_discs(assembly)
        across = tuple({f"node_0.{axis}": 1.0, f"node_1.{axis}": -1.0} for axis in "xy")
        assembly.forces.append(InterfaceForce("coupling", COUPLING_FORCE, tuple(series.ravel()), across))

    presets = {"plausible": Preset("as documented")}
    return Machine(
        MachineDefinition("documented rotor", "two discs, 0.9 m", (), presets, build, step_s=1e-4, settle_s=4.0)
    )


def add_shaft(assembly, elements, *, all_directions):
    """Add the shaft with the discs' mass, in bending or in all six directions."""
    nodes = range(len(elements) + 1)
    bending = assemble_rotor(elements, material=MATERIAL, discs=DISCS)
    names = [f"node_{node}.{axis}" for node in nodes for axis in COORDINATES]
    add_proportionally_damped(assembly, names, bending.mass, bending.stiffness)
    assembly.add_matrix("gyroscopic", names, bending.gyroscopic)
    if all_directions:
        torsion = assemble_torsion(elements, material=MATERIAL, discs=DISCS)
        names = [f"node_{node}.torsion" for node in nodes]
        add_proportionally_damped(assembly, names, torsion.inertia, torsion.stiffness)
        add_proportionally_damped(assembly, [f"node_{node}.axial" for node in nodes], *bars(elements))


def add_discs(assembly):
    """Add places and probes at the discs, and the unbalance of the first one."""
    for disc in DISCS:
        directions = {axis: {f"node_{disc.node}.{axis}": 1.0} for axis in "xy"}
        place = Place(f"disc_{disc.node}", frozenset({"rotor", "disc"}), directions)
        assembly.add_place(place)
        for axis in "xy":
            name = f"{place.name}.{axis}"
            assembly.probes.append(Probe(name, "displacement", "m", place.name, axis, directions[axis]))
    first = assembly.places[f"disc_{DISCS[0].node}"]
    assembly.forces.append(rotating_mass("unbalance", first, moment_kg_m=UNBALANCE_KG_M, angle_rad=UNBALANCE_PHASE_RAD))


def add_proportionally_damped(assembly, names, mass, stiffness):
    for name in names:
        assembly.add_coordinate(name)
    assembly.add_matrix("mass", names, mass)
    assembly.add_matrix("stiffness", names, stiffness)
    assembly.add_matrix("damping", names, MASS_DAMPING_1_S * mass + STIFFNESS_DAMPING_S * stiffness)


def bars(elements):
    """Return mass and stiffness of the shaft along its axis, consistent bar elements, discs included."""
    size = len(elements) + 1
    mass, stiffness = np.zeros((size, size)), np.zeros((size, size))
    for number, element in enumerate(elements):
        rows = slice(number, number + 2)
        mass[rows, rows] += MATERIAL.density_kg_m3 * element.area_m2 * element.length_m / 6 * np.array([[2, 1], [1, 2]])
        stretch = MATERIAL.youngs_modulus_pa * element.area_m2 / element.length_m
        stiffness[rows, rows] += stretch * np.array([[1, -1], [-1, 1]])
    for disc in DISCS:
        mass[disc.node, disc.node] += disc.mass_kg
    return mass, stiffness


def relative_error(found, truth):
    """Return the worst relative rms difference of the alternating parts, arrays (samples, probes)."""
    found, truth = found - found.mean(axis=0), truth - truth.mean(axis=0)
    return float(np.sqrt(np.mean((found - truth) ** 2, axis=0) / np.mean(truth**2, axis=0)).max())


def least_cpu_s(work, repeats):
    spent = []
    for _ in range(repeats):
        begun = time.process_time()
        work()
        spent.append(time.process_time() - begun)
    return min(spent)


def advance(stepper, steps):
    parts = []
    while sum(map(len, parts)) < steps:
        parts.append(stepper.advance(min(stepper.block, steps - sum(map(len, parts)))))
    return np.concatenate(parts)[:, :, 0]


def measure(machine, known, *, step_s, highest_hz):
    """Print accuracy and cost of one way to run ours, and how much faster than ROSS it is."""
    speed_rpm, every = float(known["speed_rpm"]), round(step_s / float(known["step_s"]))
    group = LaneGroup([machine], [steady(speed_rpm=speed_rpm)], [machine.system(speed_rpm=speed_rpm)])

    def stepper():
        return Stepper(group, step_s=step_s, start_s=0.0, highest_hz=highest_hz)

    def all_included(duration_s):
        options = {"rate_hz": 0.5 / step_s, "settle_s": 0.0, "step_s": step_s, "highest_hz": highest_hz}
        simulate_batch([(machine, speed_rpm)], duration_s=duration_s, **options)

    # From rest, as ROSS: the transient is compared as well.
    resting = stepper()
    resting.states[:] = 0.0
    truth = known["documented"][::every]
    found = advance(resting, len(truth))
    turn, second = round(60 / speed_rpm / step_s), round(1 / step_s)
    states = f"{resting.states.shape[0]} of {group.systems[0].states}"
    print(f"  step {step_s:g} s, modes up to {highest_hz} Hz: {states} states")
    print(f"    error of the last revolution {relative_error(found[-turn:], truth[-turn:]):.1e}", end="; ")
    print(f"of the first second from rest {relative_error(found[:second], truth[:second]):.1e}")
    running, steps = stepper(), round(2 / step_s)
    stepping = least_cpu_s(lambda: advance(running, steps), 7) / 2
    matrices = least_cpu_s(lambda: machine.system(speed_rpm=speed_rpm), 3)
    print(f"    CPU s: stepping {stepping:.4f} per simulated s; once, matrices {matrices:.3f}", end="")
    print(f" and modes and tables {least_cpu_s(stepper, 3):.3f}")
    costs = {duration: least_cpu_s(lambda duration=duration: all_included(duration), 3) for duration in DURATIONS_S}
    for way in ("documented", "12 modes"):
        of_ross = {duration: float(known[f"{way}, cpu for {duration:g} s"]) for duration in DURATIONS_S}
        ratios = ", ".join(f"{of_ross[d] / costs[d]:.1f} x in a run of {d:g} s" for d in DURATIONS_S)
        slope = (of_ross[DURATIONS_S[1]] - of_ross[DURATIONS_S[0]]) / (DURATIONS_S[1] - DURATIONS_S[0])
        print(f"    faster than {way}: all included {ratios}; stepping alone {slope / stepping:.0f} x")


def balance(machine, known):
    speed_rpm, step_s = float(known["speed_rpm"]), float(known["step_s"])
    truth = known["documented"]
    turn = round(60 / speed_rpm / step_s)
    phase = speed_rpm * np.pi / 30 * step_s * np.arange(len(truth) - turn, len(truth))
    motion = harmonic_balance(machine, speed_rpm=speed_rpm, harmonics=HARMONICS)
    error = relative_error(motion.waveform(phase).T, truth[-turn:])

    def anew():
        solver.forget()
        frequency_response.forget()
        harmonic_balance(machine, speed_rpm=speed_rpm, harmonics=HARMONICS)

    cost = least_cpu_s(anew, 3)
    print(f"  harmonic balance, all included: error {error:.1e}, {cost:.3f} CPU s whatever the duration")


def main(ross_python):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "ross.npz"
        side = Path(__file__).with_name("ross_side.py")
        subprocess.run([ross_python, str(side), str(path)], check=True, cwd=folder, capture_output=True)
        known = dict(np.load(path))
    report(known)


def report(known):
    turn = round(60 / float(known["speed_rpm"]) / float(known["step_s"]))
    error = relative_error(known["12 modes"][-turn:], known["documented"][-turn:])
    print(f"ROSS, {known['degrees_of_freedom']} degrees of freedom; error of its 12 modes {error:.1e}")
    for way in ("documented", "12 modes", "newmark"):
        costs = " and ".join(f"{float(known[f'{way}, cpu for {d:g} s']) / d:.3f}" for d in DURATIONS_S)
        print(f"  {way}: {costs} CPU s per simulated s in runs of {' and '.join(f'{d:g}' for d in DURATIONS_S)} s")
    same_step = float(known["step_s"])
    for all_directions in (True, False):
        machine = rotor_machine(known["nodes_m"], known["coupling_force_n"], all_directions=all_directions)
        print("rotorwise, 204 degrees of freedom" if all_directions else "rotorwise, bending only, 136")
        measure(machine, known, step_s=same_step, highest_hz=None)
        measure(machine, known, step_s=same_step, highest_hz=HIGHEST_HZ)
        measure(machine, known, step_s=LONG_STEP_S, highest_hz=HIGHEST_HZ)
        balance(machine, known)


if __name__ == "__main__":
    main(sys.argv[1])
