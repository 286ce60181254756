"""Small machines with known answers, for the solver tests."""

import numpy as np
from rotorwise.simulators.assembly import Place, Probe
from rotorwise.simulators.law import InterfaceForce, Law, compiled_force, no_signals
from rotorwise.simulators.machine import Machine, MachineDefinition, Preset
from rotorwise.simulators.parameter import Parameter
from rotorwise.simulators.rotor_dynamics.harmonic_force import harmonic_force


def number(name, default):
    return Parameter(name, "", default, (-1e20, 1e20), name, "test")


def define(build, *, step_s=1e-3, settle_s=0.0, **defaults):
    parameters = tuple(number(name, value) for name, value in defaults.items())
    return Machine(
        MachineDefinition("small", "test machine", parameters, {"plausible": Preset("")}, build, step_s, settle_s)
    )


def add_probes(assembly, *names):
    for name in names:
        for quantity, unit in (("displacement", "m"), ("velocity", "m/s"), ("acceleration", "m/s2")):
            assembly.probes.append(Probe(f"{name} {quantity}", quantity, unit, name, "x", {name: 1.0}))


@compiled_force
def _cubic(signals, parameters, x, inputs, outputs, u):
    for lane in range(x.shape[1]):
        position = x[inputs[0], lane]
        u[outputs[0], lane] -= parameters[0, lane] * position * position * position


CUBIC = Law("cubic spring", no_signals, _cubic)


def _parametric(timeline, parameters):
    cos, _ = timeline.cos_sin(1.0)
    return np.stack([np.zeros_like(cos), -parameters[0] * cos])


PARAMETRIC = Law("stiffness that turns", _parametric)


def _build_duffing(assembly, values, switches):
    assembly.add_coordinate("a", mass=1.0, vertical=True)
    assembly.add_spring({"a": 1.0}, stiffness=values["stiffness"], damping=values["damping"])
    x = ({"a": 1.0},)
    if values["cubic"]:
        assembly.forces.append(InterfaceForce("cubic", CUBIC, (values["cubic"],), x, x))
    assembly.forces.append(InterfaceForce("parametric", PARAMETRIC, (values["parametric"],), x, x))
    assembly.forces.append(harmonic_force("drive", x, order=1.0, cos=(values["drive"],), sin=(0.0,)))
    add_probes(assembly, "a")


def duffing(**values):
    """x'' + damping x' + stiffness x + cubic x^3 + parametric cos(phi) x = drive cos(phi)."""
    defaults = {"stiffness": 1.0, "damping": 0.1, "cubic": 0.0, "parametric": 0.0, "drive": 0.0}
    return define(_build_duffing, step_s=0.05, settle_s=0.0, **{**defaults, **values})


def _switch_signals(timeline, parameters, *, branch_rad):
    stiff = np.floor(branch_rad / (2 * np.pi) * 3.0 + 0.3) % 2
    cos, _ = timeline.cos_sin(3.0)
    # Each branch is smooth by itself and differs from the other in value and slope.
    return (parameters[0] * np.where(stiff == 1, 1.0 + 0.2 * cos, -1.0))[None]


def _switch_jumps(parameters, start_rad, stop_rad):
    first, last = np.floor(start_rad / (2 * np.pi) * 3.0 + 0.3), np.floor(stop_rad / (2 * np.pi) * 3.0 + 0.3)
    return (np.arange(first + 1, last + 1) - 0.3) * 2 * np.pi / 3.0


@compiled_force
def _switched(signals, parameters, x, inputs, outputs, u):
    for lane in range(x.shape[1]):
        u[outputs[0], lane] -= signals[0, lane] * x[inputs[0], lane]


SWITCHED = Law("switching spring", _switch_signals, _switched, _switch_jumps)


def _build_switching(assembly, values, switches):
    assembly.add_coordinate("a", mass=1.0)
    assembly.add_coordinate("b", mass=2.0)
    assembly.add_spring({"a": 1.0}, stiffness=3.0, damping=0.05)
    assembly.add_spring({"b": 1.0}, stiffness=5.0, damping=0.05)
    mesh = {"a": 1.0, "b": -1.0}
    assembly.add_spring(mesh, stiffness=4.0, damping=0.2)
    force = InterfaceForce("mesh", SWITCHED, (values["deviation"],), (mesh,), (mesh,), (mesh,))
    assembly.forces.append(force)
    assembly.forces.append(harmonic_force("weight", ({"a": 1.0},), order=0.0, cos=(1.0,), sin=(0.0,)))
    add_probes(assembly, "a", "b")


def switching():
    """Two masses with a spring between them that switches three times in two turns, like a gear mesh."""
    return define(_build_switching, step_s=0.02, settle_s=0.0, deviation=1.5)


def _build_rotor(assembly, values, switches):
    names = ["x", "y", "angle_x", "angle_y"]
    for name in names:
        assembly.add_coordinate(name, mass=2.0 if name in "xy" else 0.02, vertical=name == "y")
    for name, stiffness in zip(names, (2e4, 3e4, 60.0, 60.0), strict=True):
        assembly.add_spring({name: 1.0}, stiffness=stiffness, damping=values["damping"] * stiffness)
    for pair in ({"x": 1.0, "angle_y": 0.05}, {"y": 1.0, "angle_x": -0.05}):
        assembly.add_spring(pair, stiffness=8e3, damping=values["damping"] * 8e3)
    assembly.add_matrix("gyroscopic", ["angle_x", "angle_y"], np.array([[0.0, 0.03], [-0.03, 0.0]]))
    directions = {"x": {"x": 1.0}, "y": {"y": 1.0}}
    assembly.add_place(Place("disc", frozenset({"rotor", "disc"}), directions))
    if values["parametric"]:
        x = ({"x": 1.0, "angle_y": 0.02},)
        assembly.forces.append(InterfaceForce("parametric", PARAMETRIC, (values["parametric"],), x, x))
    add_probes(assembly, "x", "y")


def rotor(**values):
    """Four-degree-of-freedom gyroscopic rotor with one stiffness that turns with the shaft."""
    return define(_build_rotor, step_s=2e-4, settle_s=1.0, **{"damping": 1e-3, "parametric": 0.0, **values})


@compiled_force
def _stop(signals, parameters, x, inputs, outputs, u):
    for lane in range(x.shape[1]):
        depth = x[inputs[0], lane] - parameters[1, lane]
        if depth > 0:
            u[outputs[0], lane] -= parameters[0, lane] * depth


STOP = Law("one-sided stop", no_signals, _stop, stiffest=lambda parameters: float(parameters[0]))


def _build_stop(assembly, values, switches):
    assembly.add_coordinate("a", mass=1.0)
    assembly.add_spring({"a": 1.0}, stiffness=100.0, damping=0.5)
    x = ({"a": 1.0},)
    assembly.forces.append(InterfaceForce("stop", STOP, (values["stiffness"], values["gap"]), x, x))
    assembly.forces.append(harmonic_force("drive", x, order=1.0, cos=(values["drive"],), sin=(0.0,)))
    add_probes(assembly, "a")


def stop(**values):
    """A mass on a spring that strikes a stop."""
    return define(_build_stop, step_s=5e-3, settle_s=0.0, **{"stiffness": 1e6, "gap": 0.02, "drive": 10.0, **values})
