"""Single-stage spur gearbox on four ball bearings, driven through a coupling: paper 001 with its misprints corrected.

Source: F. Wang, P. Dai, J. Wang, L. Niu, "Vibration responses of the bearing-rotor-gear system with the misaligned
rotor" (paper 001 of this project), Eqs (1)-(13) and Tables 1-3. The line of action is y; x has no mesh force. Both
shafts count angles in their own sense of rotation, so that theta_wheel = theta_pinion z1/z2 for rigid gears; forces
that turn with the output shaft are drawn in that sense too, a mirror image that no single probe can tell.

The 28 degrees of freedom of Eq (1), j = 1, 2 on the input and 3, 4 on the output shaft: four angles (input rotor,
pinion, wheel, output rotor), x and y of pinion, wheel, inner rings s_j and outer rings p_j, and y of a small mass on
each outer ring, the accelerometer.

Misprints, by the switch or value that restores the print in the preset ``as_printed``:

* ``no_reaction_on_wheel``: the equation of y_ge lacks -F_M. A force needs its reaction; d contains + y_ge.
* ``ring_springs_swapped``: the outer rings 2 and 3 are held in x by k_px x_s; must be k_px x_p as for rings 1 and 4.
  Printed, nothing but damping holds these rings.
* ``mesh_in_series``: Eq (7) adds the compliances of two tooth pairs (they act in parallel) and counts the contact of a
  single pair three times.
* ``teeth_pull``: Eq (6) lets the teeth pull at each other. A real gear has backlash and teeth that separate.
* ``coupling_force_backward``: Eq (13) turns against the balls of Eq (3); see `rigid_offset_coupling`.
* ``seven_ball_6308``: the defect frequencies of bearings 3 and 4 in Table 1 are those of seven balls with the diameter
  ratio of the 6304. A 6308 has 8 balls of 15.08 mm on 65 mm: 26.17 and 41.98 Hz instead of 21.92 and 37.71 Hz.
* Not a switch: f_o1 = 81.13 Hz in Table 1 must be 77.2 Hz (inner + outer must be 7 x 30 Hz, and the text's order
  2.57 is 77.2 Hz); the appendix mixes rpm and Hz in f_r = omega / 60; Eq (5) tests an undefined delta_i; the modulus
  of Eq (12) is negative; the load is in N.m, not N/m.
* ``wheel_inertia_kg_m2`` 8.362e-4: a steel disc of 2.88 kg and 81 mm radius has about 9e-3.
* ``shaft_torsional_damping_n_m_s_rad`` 5e5: 20 000 times critical. ``support_damping_n_s_m`` 1.8e5: 16 times critical
  for the pinion; the 0.05 kg accelerometer on 6.7e7 N/m becomes a low-pass of 59 Hz.

What Table 3 cannot mean: with these two damping values the fastest decay is 1.4e9 1/s. An explicit Runge-Kutta method
as the paper names then needs about 5e8 steps a second, so its figures cannot come from these numbers. The exponential
solver here takes them because they are in its linear core.

Not in the paper, hence invented: masses of rings and accelerometers, bearing stiffness and clearance, mesh damping,
backlash, ball angles, drive torque (here the load's, through the ratio, so that the shaft neither speeds up nor
slows down) and the motor's torque-speed slope, without which the rigid rotation drifts.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache

from ..assembly import Assembly, Place, Probe, difference
from ..machine import MachineDefinition, Preset
from ..parameter import LogNormal, Parameter, Prior, Uniform
from ..rotor_dynamics.ball_bearing_contact import BallBearingContact
from ..rotor_dynamics.gear_mesh import GearMesh, mesh_damping_n_s_m, misprinted_branches
from ..rotor_dynamics.gear_mesh_stiffness import SpurPair
from ..rotor_dynamics.harmonic_force import harmonic_force
from ..rotor_dynamics.rigid_offset_coupling import RigidOffsetCoupling
from ..rotor_dynamics.rolling_bearing import BearingGeometry, find_bearing
from ..rotor_dynamics.shaft_elements import Material
from ..rotor_dynamics.spur_gear import SpurGear
from ..rotor_dynamics.support import Support

_PAPER = "paper 001, Table 3"
_GEARS = "paper 001, Table 2"
_INVENTED = "not in the paper; "

PINION_TEETH, WHEEL_TEETH = 23, 81
RATIO = PINION_TEETH / WHEEL_TEETH
_MODULE_M, _FACE_WIDTH_M, _PRESSURE_ANGLE_RAD = 2e-3, 24e-3, math.radians(20)
#: Gear bodies are held at the bore of the bearings beside them: 20 mm for the 6304, 40 mm for the 6308.
_PINION_BORE_RADIUS_M, _WHEEL_BORE_RADIUS_M = 10e-3, 20e-3
_STEEL = Material(youngs_modulus_pa=216e9, density_kg_m3=7850.0, poisson_ratio=0.3)

#: Reproduces the defect frequencies of Table 1 (132.79 Hz inner, and 77.2 Hz outer, see the module).
BEARING_6304 = BearingGeometry(7, 9.525e-3, 36.0e-3, designation="6304", source="paper 001, Table 1: order 2.57")
_PRINTED_6308 = BearingGeometry(7, 9.525e-3, 36.0e-3, designation="6308 as in Table 1", source="paper 001, Table 1")
# Each bearing's number, the gear it sits beside, its shaft.
_BEARINGS = ((1, "pinion", "input"), (2, "pinion", "input"), (3, "wheel", "output"), (4, "wheel", "output"))


def _parameter(
    name: str,
    unit: str,
    default: float,
    bounds: tuple[float, float],
    meaning: str,
    source: str,
    prior: Prior | None = None,
) -> Parameter:
    return Parameter(name, unit, default, bounds, meaning, source, prior)


def _around(value: float, factor: float) -> LogNormal:
    return LogNormal(value, factor)


_TURN = (-2 * math.pi, 2 * math.pi)
_BALL_ANGLE = _INVENTED + "any angle is equally likely; four different ones so that no symmetry hides a line"

PARAMETERS = (
    _parameter("load_torque_n_m", "N.m", 30.0, (0.0, 500.0), "load torque at the output shaft", _PAPER + ", unit N.m"),
    _parameter("motor_slope_n_m_s_rad", "N.m.s/rad", 0.1, (0.0, 10.0), "drive torque lost per rad/s of higher speed",
               _INVENTED + "a 1.5 kW induction motor has 1 at rest and less for fast changes", _around(0.1, 3.0)),
    _parameter("input_rotor_inertia_kg_m2", "kg.m2", 2.1e-3, (1e-5, 1.0), "input rotor", _PAPER),
    _parameter("pinion_inertia_kg_m2", "kg.m2", 4.365e-4, (1e-5, 1.0), "pinion", _PAPER),
    _parameter("wheel_inertia_kg_m2", "kg.m2", 8.362e-3, (1e-5, 1.0), "wheel", _PAPER + ", exponent corrected"),
    _parameter("output_rotor_inertia_kg_m2", "kg.m2", 1.05e-2, (1e-5, 1.0), "output rotor", _PAPER),
    _parameter("pinion_mass_kg", "kg", 0.96, (0.01, 100.0), "pinion", _PAPER),
    _parameter("wheel_mass_kg", "kg", 2.88, (0.01, 100.0), "wheel", _PAPER),
    _parameter("input_inner_ring_mass_kg", "kg", 0.1, (0.01, 10.0), "inner ring with shaft end, bearings 1 and 2",
               _INVENTED + "ring 0.06 kg", _around(0.1, 1.5)),
    _parameter("output_inner_ring_mass_kg", "kg", 0.3, (0.01, 10.0), "inner ring with shaft end, bearings 3 and 4",
               _INVENTED + "ring 0.25 kg", _around(0.3, 1.5)),
    _parameter("input_outer_ring_mass_kg", "kg", 0.15, (0.01, 10.0), "outer ring and seat, bearings 1 and 2",
               _INVENTED + "ring 0.07 kg", _around(0.15, 1.5)),
    _parameter("output_outer_ring_mass_kg", "kg", 0.4, (0.01, 10.0), "outer ring and seat, bearings 3 and 4",
               _INVENTED + "ring 0.3 kg", _around(0.4, 1.5)),
    _parameter("sensor_mass_kg", "kg", 0.05, (0.001, 1.0), "accelerometer (the paper's resonator)",
               _INVENTED + "an industrial accelerometer with its stud", _around(0.05, 1.5)),
    _parameter("shaft_torsional_stiffness_n_m_rad", "N.m/rad", 4.4e5, (1e2, 1e8), "of each shaft", _PAPER),
    _parameter("shaft_torsional_damping_n_m_s_rad", "N.m.s/rad", 0.5, (0.0, 1e6), "of each shaft",
               _PAPER + " with 5e5, 20 000 times critical; 0.5 is 2 % of critical, as of a steel shaft",
               _around(0.5, 2.0)),
    _parameter("support_stiffness_n_m", "N/m", 6.7e7, (1e5, 1e10), "shaft to inner ring, outer ring to ground, sensor",
               _PAPER),
    _parameter("support_damping_n_s_m", "N.s/m", 1.8e3, (0.0, 1e6), "of the same three",
               _PAPER + " with 1.8e5, 16 times critical; 1.8e3 is 16 % for the pinion", _around(1.8e3, 2.0)),
    _parameter("input_contact_stiffness", "N/m^1.5", 1.01e10, (1e8, 1e12), "one ball of a 6304 on both raceways",
               _INVENTED + "Hertz contact with conformity 0.52", _around(1.01e10, 1.2)),
    _parameter("output_contact_stiffness", "N/m^1.5", 1.27e10, (1e8, 1e12), "one ball of a 6308 on both raceways",
               _INVENTED + "Hertz contact with conformity 0.52", _around(1.27e10, 1.2)),
    _parameter("clearance_m", "m", 5e-6, (-2e-5, 1e-4), "radial clearance of the bearings, half the play",
               _INVENTED + "ISO 5753-1 group N, 20 mm bore: play of 5 to 20 um", Uniform(2.5e-6, 1e-5)),
    _parameter("bearing_1_angle_rad", "rad", 0.0, _TURN, "first ball of bearing 1 at shaft angle 0", _BALL_ANGLE),
    _parameter("bearing_2_angle_rad", "rad", 0.3, _TURN, "first ball of bearing 2 at shaft angle 0", _BALL_ANGLE),
    _parameter("bearing_3_angle_rad", "rad", 0.1, _TURN, "first ball of bearing 3 at shaft angle 0", _BALL_ANGLE),
    _parameter("bearing_4_angle_rad", "rad", 0.5, _TURN, "first ball of bearing 4 at shaft angle 0", _BALL_ANGLE),
    _parameter("mesh_damping_ratio", "", 0.06, (0.0, 1.0), "of the gears turning against the mean mesh stiffness",
               _INVENTED + "Kahraman and Singh 1990 use 0.05", _around(0.06, 1.5)),
    _parameter("backlash_m", "m", 115e-6, (0.0, 1e-3), "along the line of action",
               _INVENTED + "ISO/TR 10064-2, least backlash for module 2 and 104 mm between the shafts",
               _around(1.15e-4, 1.5)),
    _parameter("first_contact_pitches", "", 0.0, (-1.0, 1.0), "mesh phase at shaft angle 0 in pitches",
               _INVENTED + "any is equally likely"),
    _parameter("mean_transmission_error_m", "m", 3e-5, (-1e-3, 1e-3), "e_o of Eq (8)", _PAPER),
    _parameter("transmission_error_m", "m", 2e-6, (0.0, 1e-4), "e_m of Eq (8), at every tooth",
               _PAPER + " with 20 um, which separates the teeth at every pitch; 2 um is a gear of ISO 1328 grade 5",
               _around(2e-6, 1.5)),
    _parameter("transmission_error_angle_rad", "rad", 0.0, _TURN, "phi_o of Eq (8)",
               _INVENTED + "any is equally likely"),
    _parameter("coupling_mass_kg", "kg", 1.0, (0.0, 100.0), "housing of the coupling", _PAPER),
    _parameter("coupling_gap_m", "m", 2e-2, (0.0, 1.0), "Delta epsilon of Eq (9), distance of the coupling's joints",
               "not in the paper but for 0.1 and 0.2 mm in its Section 4; a coupling of 1 kg is longer",
               _around(2e-2, 1.5)),
)  # fmt: skip


@lru_cache
def tooth_pair() -> SpurPair:
    """Return the gears of Table 2."""
    pinion, wheel = (
        SpurGear(
            teeth=teeth,
            module_m=_MODULE_M,
            face_width_m=_FACE_WIDTH_M,
            pressure_angle_rad=_PRESSURE_ANGLE_RAD,
            bore_radius_m=bore,
            material=_STEEL,
        )
        for teeth, bore in ((PINION_TEETH, _PINION_BORE_RADIUS_M), (WHEEL_TEETH, _WHEEL_BORE_RADIUS_M))
    )
    return SpurPair(pinion, wheel)


def build(assembly: Assembly, values: Mapping[str, float], switches: frozenset[str]) -> None:
    """Fill an assembly with the gearbox."""
    _add_coordinates(assembly, values)
    _add_shafts(assembly, values)
    for number, _, shaft in _BEARINGS:
        _add_bearing(assembly, values, switches, number, shaft)
    _add_mesh(assembly, values, switches)
    _add_places(assembly)
    coupling = RigidOffsetCoupling(
        name="input coupling",
        place=assembly.places["coupling"],
        housing_mass_kg=values["coupling_mass_kg"],
        gap_m=values["coupling_gap_m"],
        against_rotation="coupling_force_backward" in switches,
    )
    assembly.add_component(coupling)
    _add_torques(assembly, values)
    _add_probes(assembly)


def _add_coordinates(assembly: Assembly, values: Mapping[str, float]) -> None:
    for part, ratio in (("input_rotor", 1.0), ("pinion", 1.0), ("wheel", RATIO), ("output_rotor", RATIO)):
        assembly.add_coordinate(f"{part}.torsion", mass=values[f"{part}_inertia_kg_m2"], torsion_ratio=ratio)
    for part in ("pinion", "wheel"):
        assembly.add_coordinate(f"{part}.x", mass=values[f"{part}_mass_kg"])
        assembly.add_coordinate(f"{part}.y", mass=values[f"{part}_mass_kg"], vertical=True)
    for number, _, shaft in _BEARINGS:
        for ring in ("inner", "outer"):
            mass = values[f"{shaft}_{ring}_ring_mass_kg"]
            assembly.add_coordinate(f"{ring}_{number}.x", mass=mass)
            assembly.add_coordinate(f"{ring}_{number}.y", mass=mass, vertical=True)
        assembly.add_coordinate(f"sensor_{number}.y", mass=values["sensor_mass_kg"], vertical=True)


def _add_shafts(assembly: Assembly, values: Mapping[str, float]) -> None:
    for first, second in (("input_rotor", "pinion"), ("output_rotor", "wheel")):
        assembly.add_spring(
            {f"{first}.torsion": 1.0, f"{second}.torsion": -1.0},
            stiffness=values["shaft_torsional_stiffness_n_m_rad"],
            damping=values["shaft_torsional_damping_n_m_s_rad"],
        )
    for number, gear, _ in _BEARINGS:
        for axis in "xy":
            _add_support_spring(assembly, values, {f"{gear}.{axis}": 1.0, f"inner_{number}.{axis}": -1.0})
        _add_support_spring(assembly, values, {f"outer_{number}.y": 1.0, f"sensor_{number}.y": -1.0})


def _add_support_spring(assembly: Assembly, values: Mapping[str, float], along: dict[str, float]) -> None:
    stiffness, damping = values["support_stiffness_n_m"], values["support_damping_n_s_m"]
    assembly.add_spring(along, stiffness=stiffness, damping=damping)


def _add_bearing(
    assembly: Assembly, values: Mapping[str, float], switches: frozenset[str], number: int, shaft: str
) -> None:
    stiffness, damping = values["support_stiffness_n_m"], values["support_damping_n_s_m"]
    inner, outer = f"inner_{number}", f"outer_{number}"
    swapped = "ring_springs_swapped" in switches and number in (2, 3)
    support = Support(
        name=f"support {number}",
        along_x={f"{outer}.x": 1.0},
        along_y={f"{outer}.y": 1.0},
        stiffness_x_n_m=0.0 if swapped else stiffness,
        stiffness_y_n_m=stiffness,
        damping_x_n_s_m=damping,
        damping_y_n_s_m=damping,
    )
    if swapped:
        assembly.stiffness[f"{outer}.x", f"{inner}.x"] = stiffness
    assembly.add_component(support)
    output = _PRINTED_6308 if "seven_ball_6308" in switches else find_bearing("6308")
    assembly.add_component(
        BallBearingContact(
            name=f"bearing {number}",
            geometry=BEARING_6304 if shaft == "input" else output,
            contact_stiffness=values[f"{shaft}_contact_stiffness"],
            clearance_m=values["clearance_m"],
            x=difference({f"{inner}.x": 1.0}, {f"{outer}.x": 1.0}),
            y=difference({f"{inner}.y": 1.0}, {f"{outer}.y": 1.0}),
            shaft_ratio=1.0 if shaft == "input" else RATIO,
            first_ball_rad=values[f"bearing_{number}_angle_rad"],
        )
    )


def _add_mesh(assembly: Assembly, values: Mapping[str, float], switches: frozenset[str]) -> None:
    pair = tooth_pair()
    one, two = pair.pinion.base_radius_m, pair.wheel.base_radius_m
    along = {"pinion.torsion": one, "wheel.torsion": -two, "pinion.y": -1.0, "wheel.y": 1.0}
    compliance = one**2 / values["pinion_inertia_kg_m2"] + two**2 / values["wheel_inertia_kg_m2"]
    damping = mesh_damping_n_s_m(
        stiffness_n_m=pair.mean_stiffness_n_m,
        damping_ratio=values["mesh_damping_ratio"],
        effective_mass_kg=1 / compliance,
    )
    mesh = GearMesh(
        name="mesh",
        along=along,
        reaction={**along, "wheel.y": 0.0} if "no_reaction_on_wheel" in switches else None,
        branches=misprinted_branches(pair) if "mesh_in_series" in switches else pair.branches,
        mesh_order=float(PINION_TEETH),
        damping_n_s_m=damping,
        backlash_m=values["backlash_m"],
        separates="teeth_pull" not in switches,
        first_contact_pitches=values["first_contact_pitches"],
        mean_error_m=values["mean_transmission_error_m"],
    )
    mesh.add_error(
        order=float(PINION_TEETH),
        amplitude_m=values["transmission_error_m"],
        angle_rad=values["transmission_error_angle_rad"],
    )
    # Empty entries, so that runs with and without run-out can be computed side by side.
    for order in (1.0, RATIO):
        mesh.add_error(order=order, amplitude_m=0.0, angle_rad=0.0)
    assembly.add_component(mesh)


def _add_places(assembly: Assembly) -> None:
    def lateral(part: str) -> dict[str, dict[str, float]]:
        return {axis: {f"{part}.{axis}": 1.0} for axis in "xy"}

    for part, ratio in (("pinion", 1.0), ("wheel", RATIO)):
        directions = {**lateral(part), "torsion": {f"{part}.torsion": 1.0}}
        assembly.add_place(Place(part, frozenset({"rotor", "disc", "gear"}), directions, ratio))
    input_end = {**lateral("inner_1"), "torsion": {"input_rotor.torsion": 1.0}}
    assembly.add_place(Place("coupling", frozenset({"coupling", "rotor"}), input_end, 1.0))
    assembly.add_place(Place("motor", frozenset({"motor"}), {"torsion": {"input_rotor.torsion": 1.0}}, 1.0))
    assembly.add_place(Place("load", frozenset({"load"}), {"torsion": {"output_rotor.torsion": 1.0}}, RATIO))
    for number, _, _ in _BEARINGS:
        roles = frozenset({"bearing", "housing"})
        assembly.add_place(Place(f"bearing {number}", roles, lateral(f"outer_{number}"), 0.0))


def _add_torques(assembly: Assembly, values: Mapping[str, float]) -> None:
    # A damper against the ideal rotation is the slope of the motor's torque-speed line.
    assembly.add_spring({"input_rotor.torsion": 1.0}, damping=values["motor_slope_n_m_s_rad"])
    outputs = ({"input_rotor.torsion": 1.0}, {"output_rotor.torsion": 1.0})
    load = values["load_torque_n_m"]
    assembly.forces.append(
        harmonic_force("drive and load torque", outputs, order=0.0, cos=(load * RATIO, -load), sin=(0.0, 0.0))
    )


def _add_probes(assembly: Assembly) -> None:
    for name, quantity, unit, location, direction, coordinate in (
        ("accelerometer", "acceleration", "m/s2", "bearing 1", "y", "sensor_1.y"),
        ("bearing 1 x", "acceleration", "m/s2", "bearing 1", "x", "outer_1.x"),
        ("bearing 1 y", "acceleration", "m/s2", "bearing 1", "y", "outer_1.y"),
        ("pinion torsional velocity", "velocity", "rad/s", "pinion", "torsion", "pinion.torsion"),
        ("pinion velocity y", "velocity", "m/s", "pinion", "y", "pinion.y"),
        ("pinion y", "displacement", "m", "pinion", "y", "pinion.y"),
        ("wheel x", "displacement", "m", "wheel", "x", "wheel.x"),
        ("wheel y", "displacement", "m", "wheel", "y", "wheel.y"),
    ):
        assembly.probes.append(Probe(name, quantity, unit, location, direction, {coordinate: 1.0}))
    mesh = assembly.component("mesh")
    assembly.probes.append(Probe("transmission error", "displacement", "m", "mesh", "torsion", dict(mesh.along)))


DEFINITION = MachineDefinition(
    name="gearbox",
    meaning="Single-stage spur gearbox (23:81) on four ball bearings, coupling, 1.6 kW",
    parameters=PARAMETERS,
    presets={
        "plausible": Preset("Misprints corrected, missing values chosen as for a real gearbox"),
        "as_printed": Preset(
            "Paper 001 literally, with its misprints; missing values as in plausible",
            values={
                "wheel_inertia_kg_m2": 8.362e-4,
                "shaft_torsional_damping_n_m_s_rad": 5e5,
                "support_damping_n_s_m": 1.8e5,
                "transmission_error_m": 2e-5,
                "coupling_gap_m": 1e-4,
                "motor_slope_n_m_s_rad": 0.0,
            },
            switches=frozenset(
                {
                    "no_reaction_on_wheel",
                    "ring_springs_swapped",
                    "mesh_in_series",
                    "teeth_pull",
                    "coupling_force_backward",
                    "seven_ball_6308",
                }
            ),
        ),
    },
    build=build,
    step_s=1 / 60000,
    settle_s=0.5,
    load_parameter="load_torque_n_m",
    references=(
        "F. Wang, P. Dai, J. Wang, L. Niu, Vibration responses of the bearing-rotor-gear system with the misaligned "
        "rotor (paper 001)",
        "A. Kahraman and R. Singh, Non-linear dynamics of a spur gear pair, J. Sound Vib. 142 (1990) 49-75",
    ),
)
