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
  Printed, nothing but damping holds these rings. Together with the missing reaction this makes the motion depend on
  its start: no load presses the wheel into its bearings, so that at rest in the middle of their play it stays there
  (accelerometer 3.3 m/s2 rms at 20 Hz), while from the other starts tried it came to a whirl of wheel and ring 3 at
  385 Hz with 8 um (3.6 m/s2). The one-sided springs feed it: with k_px x_p it shrinks to within the play.
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

Under a light load the plausible gearbox is irregular: at 10 N.m rms and lines move by up to a tenth from one stretch of
two seconds to the next. Compare statistics there, not samples.

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
from ..rotor_dynamics.ball_bearing_contact import BallBearingContact
from ..rotor_dynamics.gear_mesh import GearMesh, mesh_damping_n_s_m, misprinted_branches
from ..rotor_dynamics.gear_mesh_stiffness import SpurPair
from ..rotor_dynamics.harmonic_force import harmonic_force
from ..rotor_dynamics.rigid_offset_coupling import RigidOffsetCoupling
from ..rotor_dynamics.rolling_bearing import BearingGeometry, find_bearing
from ..rotor_dynamics.shaft_elements import Material
from ..rotor_dynamics.shaft_flaws import SprungShaft
from ..rotor_dynamics.spur_gear import SpurGear
from ..rotor_dynamics.support import Support
from ._gearbox_parameters import PARAMETERS

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
    for shaft, gear, bearings, ratio, bore in (
        ("input shaft", "pinion", (1, 2), 1.0, _PINION_BORE_RADIUS_M),
        ("output shaft", "wheel", (3, 4), RATIO, _WHEEL_BORE_RADIUS_M),
    ):
        middle, first, second = (_in_plane(part) for part in (gear, *(f"inner_{number}" for number in bearings)))
        assembly.add_component(
            SprungShaft(
                shaft,
                middle=middle,
                first=first,
                second=second,
                spring_n_m=values["support_stiffness_n_m"],
                diameter_m=2 * bore,
                shaft_ratio=ratio,
                material=_STEEL,
            )
        )


def _in_plane(part: str) -> tuple[dict[str, float], dict[str, float]]:
    return {f"{part}.x": 1.0}, {f"{part}.y": 1.0}


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
            # The mesh pushes the pinion up and the wheel down.
            load_angle_rad=math.pi / 2 if shaft == "input" else -math.pi / 2,
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
        pair=pair,
        branch_model=misprinted_branches if "mesh_in_series" in switches else None,
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
    for gear, number, ratio in (("pinion", 1, 1.0), ("wheel", 3, RATIO)):
        x, y = (difference(*pair) for pair in zip(_in_plane(gear), _in_plane(f"outer_{number}"), strict=True))
        assembly.add_place(Place(f"{gear} seal", frozenset({"seal"}), {"x": x, "y": y}, ratio))
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
