"""Parameters of the gearbox of paper 001, each with the source of its value."""

from __future__ import annotations

import math

from ..parameter import LogNormal, Parameter, Prior, Uniform

_PAPER = "paper 001, Table 3"
_INVENTED = "not in the paper; "


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
