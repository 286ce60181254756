"""Rotors with known answers: one mass on a shaft between rigid bearings, and one mass on a support beside others."""

import numpy as np
from rotorwise.simulators.assembly import Place, Probe
from rotorwise.simulators.machine import Machine, MachineDefinition, Preset
from rotorwise.simulators.parameter import Parameter
from rotorwise.simulators.rotor_dynamics.harmonic_force import rotating_mass
from rotorwise.simulators.rotor_dynamics.shaft_flaws import SprungShaft
from rotorwise.simulators.rotor_dynamics.shaft_parts import Material
from rotorwise.simulators.rotor_dynamics.support import Support
from rotorwise.simulators.rotor_dynamics.weight import Weight

STEEL = Material(2.1e11, 7850.0, 0.3)
#: kg, N/m of the whole shaft, rad/s.
MASS, STIFFNESS = 2.0, 8e5
CRITICAL = np.sqrt(STIFFNESS / MASS)
CRITICAL_RPM = CRITICAL * 60 / (2 * np.pi)


def _define(build, *, step_s, **defaults):
    parameters = tuple(Parameter(name, "", value, (-1e9, 1e9), name, "test") for name, value in defaults.items())
    presets = {"plausible": Preset("")}
    return Machine(MachineDefinition("jeffcott", "test machine", parameters, presets, build, step_s, 0.0))


def _add_mass(assembly, values):
    assembly.add_coordinate("x", mass=MASS)
    assembly.add_coordinate("y", mass=MASS, vertical=True)
    directions = {"x": {"x": 1.0}, "y": {"y": 1.0}}
    place = Place("disc", frozenset({"rotor", "disc", "seal", "journal"}), directions)
    assembly.add_place(place)
    moment = MASS * values["eccentricity_m"]
    assembly.forces.append(rotating_mass("unbalance", place, moment_kg_m=moment, angle_rad=values["angle_rad"]))
    assembly.add_component(Weight("weight", values["gravity_m_s2"]))
    for axis in "xy":
        assembly.probes.append(Probe(axis, "displacement", "m", "disc", axis, {axis: 1.0}))


def _build_rotor(assembly, values, switches):
    _add_mass(assembly, values)
    for axis in "xy":
        damping = 2 * values["damping_ratio"] * MASS * CRITICAL
        assembly.add_spring({axis: 1.0}, stiffness=STIFFNESS, damping=damping)
    shaft = SprungShaft(
        "shaft",
        middle=({"x": 1.0}, {"y": 1.0}),
        first=({}, {}),
        second=({}, {}),
        spring_n_m=STIFFNESS / 2,
        diameter_m=0.02,
        shaft_ratio=1.0,
        material=STEEL,
    )
    assembly.add_component(shaft)


def _build_footed(assembly, values, switches):
    _add_mass(assembly, values)
    foot = values["foot_share"] * STIFFNESS
    for axis in "xy":
        assembly.add_spring(
            {axis: 1.0}, stiffness=STIFFNESS - foot, damping=2 * values["damping_ratio"] * MASS * CRITICAL
        )
    assembly.add_component(Support("foot", {"x": 1.0}, {"y": 1.0}, foot, foot))


def jeffcott(**values):
    """Return the rotor on a shaft."""
    defaults = {"eccentricity_m": 0.0, "angle_rad": 0.0, "gravity_m_s2": 0.0, "damping_ratio": 0.0}
    return _define(_build_rotor, step_s=2e-4, **{**defaults, **values})


def footed(**values):
    """Return the mass on a foot that has the share ``foot_share`` of the whole stiffness; the rest cannot change."""
    defaults = {"eccentricity_m": 0.0, "angle_rad": 0.0, "gravity_m_s2": 0.0, "damping_ratio": 0.0, "foot_share": 1.0}
    return _define(_build_footed, step_s=2e-4, **{**defaults, **values})


def rpm(speed_rad_s):
    """Return revolutions a minute."""
    return speed_rad_s * 60 / (2 * np.pi)


def orbit(motion, order):
    """Return forward and backward part of the orbit at one order: z = x + i y = sum z_n exp(i n phi)."""
    x, y = motion.amplitude("x", order), motion.amplitude("y", order)
    return (x + 1j * y) / 2, np.conj(x - 1j * y) / 2
