"""Teaching rig with a motor, a flexible coupling and a disc on a shaft in two ball bearings, on a base plate.

This is the kind of bench that the MaFaulDa and the Analog Devices (Limerick) recordings come from, a SpectraQuest
fault simulator. No paper describes it as equations, so there is no preset ``as_printed``. Known are the shaft, the
span, the disc's diameter, the bearings and the total mass; everything else carries a prior and is to be calibrated.

What is in it: a shaft of Timoshenko elements with coupling hub, disc and (as load) a second disc; torsion of motor,
hub, disc and load; the shaft as a whole in the axial direction; the motor's rotor as a rigid body on two bearings; two
bearing housings with two stages and three directions each; a rigid base plate with six degrees of freedom on soft
mounts, which also holds the motor's stator. All positions z are counted from the coupling towards the free end.

The bearings are linear by default: harmonic balance, superposition and calibration then cost milliseconds. Their
stiffness is that of Hertz contacts under the rotor's weight and does not follow ``shaft_load_kg``. The presets with
``hertz`` have balls with play instead, which a study of bearing play, load or damage needs; under so light a rotor
they rattle in their play, which alone raises 1 to 2 kHz.

Why a plate on mounts: 1X acceleration of the Analog Devices bench grows as speed^2 from 600 to 1800 rpm, which a rotor
on rigid ground cannot do (speed^4); the machine is held by its own inertia. MaFaulDa's 1X changes its course near 25 Hz
(radial) and 37 Hz (tangential): its plate's modes lie within the speed range.

Preset ``adi`` beside the healthy Analog Devices records (table in tests/README.md): radial 1X of seeded unbalance comes
out within 3 dB at 1200, 1800 and 2400 rpm. Radial 1X of the healthy bench is met at 1800 rpm, held out of the
calibration, within about 3 dB, but in x it grows nearly with speed where an unbalance gives speed^2: something else
turns with the shaft. Not met at all: axial 1X (16 to 19 dB too low), the lines at 2X to 6X, strongest along the shaft
(a linear rig has none), and every band from 45 Hz on (the rattle of ``adi_hertz`` comes to 7 to 14 dB below the noise
in y from 1 to 4 kHz, further below elsewhere). A line at 4.17 kHz has the same size at every speed:
hardly a resonance, rather the electric supply; ``cap_y_hz``, an estimate from peaks of these records, is in doubt.

Left out: axial force of an angularly misaligned coupling (no source for this kind of coupling; its moment on the
shaft is there, and axial motion comes from the plate's pitching), reaction torque of the motor on the plate, moment
stiffness of the bearings (insert bearings align themselves), elastic modes of the plate and of the shaft along its
axis (above 4 kHz), and every source of broad-band noise. Which of the sensors' radial axes is the vertical one is not
documented for either bench.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from ..assembly import Assembly, Place, Probe, difference
from ..law import Direction
from ..machine import MachineDefinition, Preset
from ..rotor_dynamics.ball_bearing_contact import BallBearingContact
from ..rotor_dynamics.base_plate import BasePlate
from ..rotor_dynamics.bending_shaft import BendingShaft
from ..rotor_dynamics.flexible_coupling import FlexibleCoupling
from ..rotor_dynamics.flexible_shaft import add_bending, add_torsion, bending_at, total_mass_kg
from ..rotor_dynamics.harmonic_force import rotating_mass
from ..rotor_dynamics.hertz import ball_contact_stiffness
from ..rotor_dynamics.housing import HousingStage, add_housing
from ..rotor_dynamics.linear_bearing import LinearBearing
from ..rotor_dynamics.motor_rotor import MotorRotor
from ..rotor_dynamics.rolling_bearing import BearingGeometry, find_bearing
from ..rotor_dynamics.shaft_parts import Disc, Material, ShaftElement
from ..rotor_dynamics.weight import Weight
from ._test_rig_parameters import PARAMETERS

STEEL = Material(youngs_modulus_pa=2.1e11, density_kg_m3=7850.0, poisson_ratio=0.3)
#: Elements from hub to bearing A, to the disc, to the load, to bearing B, to the free end.
ELEMENTS = (1, 2, 1, 1, 1)
#: Nodes at the ends of these pieces.
HUB, BEARING_A, DISC, LOAD, BEARING_B, FREE_END = (sum(ELEMENTS[:n]) for n in range(6))
#: SpectraQuest's bearing loader: a steel cylinder, 5 kg at 51 mm width.
LOAD_DIAMETER_M = 0.127
HUB_DIAMETER_M = 0.032
MOTOR_ROTOR_LENGTH_M = 0.10
#: Groove radius over ball diameter, the usual value.
CONFORMITY = 0.52
#: The bearings are `BallBearingContact` with play instead of linear springs.
HERTZ = "balls with Hertz contacts and play"

_ER_12K = find_bearing("ER-12K")
_AXIAL = {"axial": {"shaft.axial": 1.0}}
#: Name, roles, node of bending and name in torsion; the first rotor is where an unbalance is put unless told otherwise.
_SHAFT_PLACES = (
    ("disc", ("rotor", "disc"), DISC, "disc"),
    ("coupling_hub", ("rotor", "coupling"), HUB, "hub"),
    ("shaft_load", ("rotor", "load"), LOAD, "load"),
)
_BASE = (
    "base_mass_kg",
    "base_length_m",
    "base_width_m",
    "base_height_m",
    "mount_stiffness_n_m",
    "mount_shear_ratio",
    "mount_damping_ratio",
    "mount_depth_m",
)


def shaft_lengths_m(values: Mapping[str, float]) -> tuple[float, ...]:
    """Return the length of each of the five pieces of the shaft."""
    to_disc = values["disc_position"] * values["bearing_span_m"]
    beyond = values["bearing_span_m"] - to_disc
    to_load = values["load_position"] * beyond
    return values["coupling_overhang_m"], to_disc, to_load, beyond - to_load, values["free_end_m"]


def _discs(values: Mapping[str, float]) -> tuple[Disc, ...]:
    """Return half of the coupling, the disc and the load as rigid discs on the shaft's nodes."""
    bore = values["shaft_diameter_m"]
    parts = [
        (HUB, values["hub_mass_kg"], HUB_DIAMETER_M, 0.0, HUB_DIAMETER_M),
        (DISC, values["disc_mass_kg"], values["disc_diameter_m"], bore, values["disc_width_m"]),
    ]
    if values["shaft_load_kg"] > 0:
        ring = math.pi / 4 * max(LOAD_DIAMETER_M**2 - bore**2, 1e-3 * LOAD_DIAMETER_M**2)
        width = values["shaft_load_kg"] / (STEEL.density_kg_m3 * ring)
        parts.append((LOAD, values["shaft_load_kg"], LOAD_DIAMETER_M, bore, width))
    discs = []
    for node, mass, outer, inner, width in parts:
        polar = mass * (outer**2 + inner**2) / 8
        discs.append(Disc(node, mass, polar / 2 + mass * width**2 / 12, polar))
    return tuple(discs)


def build(assembly: Assembly, values: Mapping[str, float], switches: frozenset[str]) -> None:
    """Put the rig into an empty assembly."""
    base = BasePlate(**{name.removeprefix("base_"): values[name] for name in _BASE})
    base.add(assembly)
    _add_shaft(assembly, values)
    for name, roles, node, twist in _SHAFT_PLACES:
        directions = {**bending_at("shaft", node), "torsion": {f"{twist}.torsion": 1.0}, **_AXIAL}
        assembly.add_place(Place(name, frozenset(roles), directions))
    _add_seal(assembly, base, values)
    motor_end = _motor(values).add(assembly, lambda distance: _on_base(base, values, -distance))
    middle = -(values["motor_hub_overhang_m"] + values["motor_bearing_span_m"] / 2)
    assembly.add_place(Place("motor_frame", frozenset({"stator"}), _on_base(base, values, middle), 0.0))
    assembly.add_component(_coupling(values, assembly.places["coupling_hub"].directions, motor_end))
    for name in "ab":
        _add_bearing(assembly, base, values, switches, name)
    unbalance, angle = values["residual_unbalance_kg_m"], values["residual_angle_rad"]
    disc = assembly.places["disc"]
    assembly.forces.append(rotating_mass("residual unbalance", disc, moment_kg_m=unbalance, angle_rad=angle))
    assembly.add_component(Weight("weight", values["gravity_m_s2"]))
    twist = assembly.places["motor"].directions["torsion"]
    assembly.probes.append(Probe("motor_speed", "velocity", "rad/s", "motor", "torsion", twist))


def _add_seal(assembly: Assembly, base: BasePlate, values: Mapping[str, float]) -> None:
    """Add the ring round the shaft beside the disc, fixed to the plate, that the shaft may touch."""
    position = values["coupling_overhang_m"] + values["disc_position"] * values["bearing_span_m"]
    ring, disc = _on_base(base, values, position), assembly.places["disc"].directions
    between = {direction: difference(disc[direction], ring[direction]) for direction in ("x", "y")}
    assembly.add_place(Place("disc_ring", frozenset({"seal"}), between))


def _add_shaft(assembly: Assembly, values: Mapping[str, float]) -> None:
    """Add bending, torsion and rigid axial motion of the shaft with what sits on it."""
    lengths, diameter, discs = shaft_lengths_m(values), values["shaft_diameter_m"], _discs(values)
    pieces = zip(lengths, ELEMENTS, strict=True)
    elements = [ShaftElement(length / count, diameter) for length, count in pieces for _ in range(count)]
    ratio = values["shaft_damping_ratio"]
    add_bending(assembly, "shaft", elements=elements, discs=discs, material=STEEL, damping_ratio=ratio)
    add_torsion(
        assembly,
        ("hub", "disc", "load", "free_end"),
        lengths_m=(lengths[0] + lengths[1], lengths[2], lengths[3] + lengths[4]),
        diameter_m=diameter,
        discs=[replace(disc, node=number) for number, disc in enumerate(discs)],
        material=STEEL,
        damping_ratio=ratio,
    )
    assembly.add_coordinate("shaft.axial", mass=total_mass_kg(elements, discs, STEEL))
    bearings = (BEARING_A, BEARING_B)
    assembly.add_component(
        BendingShaft("shaft", prefix="shaft", elements=elements, material=STEEL, bearing_nodes=bearings)
    )


def _motor(values: Mapping[str, float]) -> MotorRotor:
    return MotorRotor(
        mass_kg=values["motor_rotor_mass_kg"],
        polar_inertia_kg_m2=values["motor_rotor_inertia_kg_m2"],
        length_m=MOTOR_ROTOR_LENGTH_M,
        bearing_span_m=values["motor_bearing_span_m"],
        overhang_m=values["motor_hub_overhang_m"],
        bearing_stiffness_n_m=values["motor_bearing_stiffness_n_m"],
        axial_stiffness_n_m=values["motor_axial_stiffness_n_m"],
        slope_n_m_s_rad=values["motor_slope_n_m_s_rad"],
    )


def _on_base(base: BasePlate, values: Mapping[str, float], position_m: float) -> dict[str, dict[str, float]]:
    """Return the motion of the point of the plate that lies on the shaft's axis at ``position_m``."""
    return base.point(y_m=values["shaft_height_m"], z_m=position_m - values["base_centre_m"])


def _coupling(
    values: Mapping[str, float], hub: Mapping[str, Direction], motor: Mapping[str, Direction]
) -> FlexibleCoupling:
    radial, angular = values["coupling_radial_stiffness_n_m"], values["coupling_angular_stiffness_n_m_rad"]
    torsion, axial = values["coupling_torsional_stiffness_n_m_rad"], values["coupling_axial_stiffness_n_m"]
    stiffness = {
        "x": radial,
        "y": radial,
        "angle_x": angular,
        "angle_y": angular,
        "torsion": torsion,
        "axial": axial,
    }
    return FlexibleCoupling(
        "coupling",
        driven=hub,
        driving=motor,
        stiffness=stiffness,
        damping={direction: values["coupling_loss_s"] * value for direction, value in stiffness.items()},
    )


def _add_bearing(
    assembly: Assembly, base: BasePlate, values: Mapping[str, float], switches: frozenset[str], name: str
) -> None:
    """Add one bearing with its housing, places and probes; ``name`` is "a" or "b"."""
    node, position = BEARING_A, values["coupling_overhang_m"]
    softer, locating = 1.0, 1.0
    if name == "b":
        node, position = BEARING_B, position + values["bearing_span_m"]
        softer, locating = math.sqrt(values["housing_b_ratio"]), values["floating_axial_share"]
    stages = [
        HousingStage(
            values[f"{part}_mass_kg"],
            {direction: softer * values[f"{part}_{direction}_hz"] for direction in ("x", "y", "axial")},
            values[f"{part}_damping_ratio"],
        )
        for part in ("housing", "cap")
    ]
    seat, cap = add_housing(assembly, f"housing_{name}", base=_on_base(base, values, position), stages=stages)
    journal = {**bending_at("shaft", node), **_AXIAL}
    assembly.add_place(Place(f"bearing_{name}", frozenset({"rotor", "bearing", "journal"}), journal))
    assembly.add_place(Place(f"housing_{name}", frozenset({"housing"}), seat, 0.0))
    between = {direction: difference(journal[direction], seat[direction]) for direction in ("x", "y", "axial")}
    axial = locating * values["bearing_axial_stiffness_n_m"]
    _add_rings(assembly, values, switches, f"bearing_{name}", between, axial)
    for direction, row in cap.items():
        probe = Probe(f"housing_{name}_{direction}", "acceleration", "m/s2", f"housing_{name}", direction, row)
        assembly.probes.append(probe)


def _add_rings(
    assembly: Assembly,
    values: Mapping[str, float],
    switches: frozenset[str],
    name: str,
    between: Mapping[str, dict[str, float]],
    axial_stiffness: float,
) -> None:
    """Add the path from ring to ring: one component, plus what Hertz contacts do not have."""
    stiffness, damping = values["bearing_stiffness_n_m"], values["bearing_damping_n_s_m"]
    ball, pitch = values["bearing_ball_diameter_m"], values["bearing_pitch_diameter_m"]
    geometry = BearingGeometry(round(values["bearing_balls"]), ball, pitch)
    linear = LinearBearing(
        name,
        geometry,
        between["x"],
        between["y"],
        stiffness,
        stiffness,
        damping,
        between["axial"],
        axial_stiffness,
        damping * min(axial_stiffness / stiffness, 1.0),
    )
    if HERTZ not in switches:
        assembly.add_component(linear)
        return
    contact = ball_contact_stiffness(
        ball_diameter_m=ball,
        pitch_diameter_m=pitch,
        inner_conformity=CONFORMITY,
        outer_conformity=CONFORMITY,
        youngs_modulus_pa=STEEL.youngs_modulus_pa,
        poisson_ratio=STEEL.poisson_ratio,
    )
    # Hertz contacts bring radial stiffness only.
    replace(linear, stiffness_x_n_m=0.0, stiffness_y_n_m=0.0).finish(assembly)
    assembly.add_component(
        BallBearingContact(
            name,
            geometry,
            contact.combined,
            values["bearing_play_m"],
            between["x"],
            between["y"],
            first_ball_rad=values[f"first_ball_{name[-1]}_rad"],
        )
    )


_ADI_VALUES = {
    "shaft_diameter_m": 0.015875,
    "bearing_balls": float(_ER_12K.balls),
    "bearing_ball_diameter_m": _ER_12K.ball_diameter_m,
    "bearing_pitch_diameter_m": _ER_12K.pitch_diameter_m,
    "mount_stiffness_n_m": 2.7e3,
    # Calibrated on radial 1X at 1200 and 2400 rpm, taken as 20 mV/g, sensor on housing B (tests/measured/rig_table.py);
    # intervals of about 95 %: 0.28 to 0.53 m, -0.06 to 0.19 m, 4.0e-5 to 1.1e-4 kg.m. At 80 mV/g the unbalance is a
    # quarter, with the sensor on housing A 1.2e-4.
    "base_width_m": 0.39,
    "base_centre_m": 0.064,
    "residual_unbalance_kg_m": 6.6e-5,
}

DEFINITION = MachineDefinition(
    name="test_rig",
    meaning="Teaching rig: motor, flexible coupling, disc on a shaft in two ball bearings, accelerometers on both",
    parameters=PARAMETERS,
    presets={
        "plausible": Preset("Geometry of MaFaulDa's rig, linear bearings."),
        "adi": Preset("Bench of the Analog Devices recordings: 5/8 inch shaft, ER-12K; 1X calibrated.", _ADI_VALUES),
        "hertz": Preset("As plausible, bearings with Hertz contacts and play.", switches=frozenset({HERTZ})),
        "adi_hertz": Preset("As adi, bearings with Hertz contacts and play.", _ADI_VALUES, frozenset({HERTZ})),
    },
    build=build,
    step_s=2.5e-5,
    settle_s=4.0,
    load_parameter="shaft_load_kg",
    references=(
        "F. M. L. Ribeiro et al., MaFaulDa - Machinery Fault Database, Federal University of Rio de Janeiro",
        "Analog Devices, CbM-Datasets, SampleMotorDataLimerick",
    ),
)
