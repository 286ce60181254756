"""Parameters of the teaching rig, with bounds, priors and where they come from."""

from __future__ import annotations

import math

from ..parameter import LogNormal, Parameter, Prior, Uniform
from ..rotor_dynamics.rolling_bearing import find_bearing

_MAFAULDA = "MaFaulDa's description of the rig"
_GUESS = "estimate; "
_ADI = "estimate; peaks of the healthy Analog Devices records"
_TURN = (-2 * math.pi, 2 * math.pi)
_BEARING = find_bearing("MaFaulDa")


def _known(name: str, unit: str, default: float, bounds: tuple[float, float], meaning: str, source: str) -> Parameter:
    return Parameter(name, unit, default, bounds, meaning, source)


def _within(
    name: str, unit: str, default: float, factor: float, bounds: tuple[float, float], meaning: str, source: str
) -> Parameter:
    """Return a positive parameter known within a factor."""
    return Parameter(name, unit, default, bounds, meaning, source, LogNormal(default, factor))


def _any(name: str, unit: str, default: float, prior: Prior, bounds: tuple[float, float], meaning: str) -> Parameter:
    return Parameter(name, unit, default, bounds, meaning, _GUESS + "any value is equally likely", prior)


PARAMETERS = (
    # Shaft and what sits on it
    _known("shaft_diameter_m", "m", 0.016, (0.005, 0.1), "diameter of the shaft", _MAFAULDA),
    _known("bearing_span_m", "m", 0.39, (0.1, 2.0), "bearing A to bearing B", _MAFAULDA),
    _within("coupling_overhang_m", "m", 0.08, 1.2, (0.01, 0.5), "coupling to bearing A",
            "estimate; shaft of 0.52 m with a span of 0.39 m leaves 0.13 m for both ends"),
    _within("free_end_m", "m", 0.05, 1.2, (0.005, 0.5), "bearing B to the free end", "as coupling_overhang_m"),
    _any("disc_position", "", 0.5, Uniform(0.3, 0.7), (0.05, 0.95), "bearing A to disc over the bearing span"),
    _any("load_position", "", 0.5, Uniform(0.2, 0.9), (0.05, 0.95), "disc to load over disc to bearing B"),
    _within("disc_mass_kg", "kg", 0.9, 1.3, (0.01, 100.0), "disc with its clamp",
            "estimate; 5/8 inch of aluminium with tapped holes, 0.75 kg, and a steel clamp; steel would be 2.3 kg"),
    _known("disc_diameter_m", "m", 0.1524, (0.02, 1.0), "diameter of the disc", _MAFAULDA + ": 15.24 cm"),
    _known("disc_width_m", "m", 0.016, (0.001, 0.3), "width of the disc", _GUESS + "5/8 inch"),
    _known("shaft_load_kg", "kg", 0.0, (0.0, 20.0), "loader on the shaft", "Analog Devices labels: 00lb and 11lb"),
    _within("shaft_damping_ratio", "", 0.005, 1.5, (0.0, 0.1), "of every elastic mode of the free shaft",
            _GUESS + "steel shaft with clamped parts"),
    _within("residual_unbalance_kg_m", "kg.m", 4e-5, 3.0, (0.0, 0.1), "of the disc of the healthy rig",
            "ISO 21940-11, G6.3: 20 um at 3000 rpm times 2 kg"),
    _any("residual_angle_rad", "rad", 0.0, Uniform(-math.pi, math.pi), _TURN, "its angle from x at shaft angle 0"),
    # Coupling and motor
    _within("hub_mass_kg", "kg", 0.08, 1.3, (0.01, 5.0), "half of the coupling", _GUESS + "aluminium, 32 mm"),
    _within("coupling_radial_stiffness_n_m", "N/m", 1e5, 3.0, (0.0, 1e8), "of the coupling in x and y",
            "estimate; flexible lab couplings have 1e4 to 1e6 (paper 000 of this project: 8.1e4)"),
    _within("coupling_angular_stiffness_n_m_rad", "N.m/rad", 10.0, 3.0, (0.0, 1e5), "of the coupling about x and y",
            _GUESS + "beam couplings of this size, about 1 % of the torsional stiffness"),
    _within("coupling_torsional_stiffness_n_m_rad", "N.m/rad", 300.0, 2.0, (0.1, 1e6), "of the coupling in torsion",
            _GUESS + "beam couplings for 16 mm shafts"),
    _within("coupling_axial_stiffness_n_m", "N/m", 1e5, 3.0, (0.0, 1e8), "of the coupling along the shaft",
            _GUESS + "as the radial stiffness"),
    _within("coupling_loss_s", "s", 5e-5, 2.0, (0.0, 1e-2), "damper over spring of the coupling, in all directions",
            _GUESS + "loss factor 3 % at 100 Hz"),
    _within("motor_rotor_mass_kg", "kg", 1.5, 1.3, (0.05, 50.0), "rotor of the motor", _GUESS + "1/4 hp"),
    _within("motor_rotor_inertia_kg_m2", "kg.m2", 6e-4, 1.5, (1e-6, 1.0), "polar, rotor of the motor",
            _GUESS + "1/4 hp: 56 mm diameter, 100 mm length"),
    _known("motor_hub_overhang_m", "m", 0.05, (0.005, 0.5), "coupling to the motor's front bearing", _GUESS + "frame"),
    _known("motor_bearing_span_m", "m", 0.14, (0.02, 1.0), "between the motor's bearings", _GUESS + "frame"),
    _within("motor_bearing_stiffness_n_m", "N/m", 3e7, 2.0, (1e5, 1e10), "radial, of one motor bearing",
            _GUESS + "ball bearing with spring preload"),
    _within("motor_axial_stiffness_n_m", "N/m", 1e6, 3.0, (1e3, 1e9), "motor rotor against its stator",
            _GUESS + "bearing with spring preload"),
    _within("motor_slope_n_m_s_rad", "N.m.s/rad", 0.05, 3.0, (1e-5, 10.0), "torque lost per rad/s of higher speed",
            _GUESS + "1 N.m rated torque, 10 % slip"),
    # Bearings
    _known("bearing_balls", "", float(_BEARING.balls), (3.0, 60.0), "balls of a bearing, a whole number", _MAFAULDA),
    _known("bearing_ball_diameter_m", "m", _BEARING.ball_diameter_m, (1e-3, 0.06), "of a ball", _MAFAULDA),
    _known("bearing_pitch_diameter_m", "m", _BEARING.pitch_diameter_m, (0.02, 0.2), "of the balls' circle", _MAFAULDA),
    _within("bearing_stiffness_n_m", "N/m", 2e7, 2.0, (100.0, 1e11), "radial, of a bearing; without Hertz contacts",
            "linear_bearing: Hertz contacts under the rotor's weight, 8 N a bearing"),
    _within("bearing_damping_n_s_m", "N.s/m", 200.0, 2.5, (0.0, 1e5), "radial, of a bearing",
            "E. Kraemer 1993: 0.25e-5 to 2.5e-5 s times the stiffness"),
    _within("bearing_axial_stiffness_n_m", "N/m", 3e6, 3.0, (0.0, 1e10), "of bearing A, which locates the shaft",
            _GUESS + "deep-groove ball bearing with little play, a sixth of the radial stiffness"),
    _any("floating_axial_share", "", 0.1, Uniform(0.0, 1.0), (0.0, 1.0), "axial stiffness of bearing B over A"),
    _within("bearing_play_m", "m", 5e-6, 1.5, (-2e-5, 2e-4), "half the radial play; only with Hertz contacts",
            "ISO 5753-1 group N, bores to 18 mm: 3 to 18 um of play"),
    _any("first_ball_a_rad", "rad", 0.0, Uniform(-math.pi, math.pi), _TURN, "first ball of A with Hertz contacts"),
    _any("first_ball_b_rad", "rad", 0.3, Uniform(-math.pi, math.pi), _TURN, "first ball of B with Hertz contacts"),
    # Housings
    _within("housing_mass_kg", "kg", 0.5, 1.5, (0.01, 100.0), "body of a housing", _GUESS + "split aluminium block"),
    _within("cap_mass_kg", "kg", 0.2, 1.5, (0.01, 50.0), "cap of a housing with the sensor", _GUESS + "its upper part"),
    _within("housing_x_hz", "Hz", 1300.0, 1.3, (50.0, 1e5), "housing with cap on a plate at rest, x", _ADI),
    _within("housing_y_hz", "Hz", 1900.0, 1.3, (50.0, 1e5), "housing with cap on a plate at rest, y", _ADI),
    _within("housing_axial_hz", "Hz", 400.0, 1.5, (50.0, 1e5), "housing with cap on a plate at rest, axial", _ADI),
    _within("cap_x_hz", "Hz", 3600.0, 1.3, (100.0, 1e5), "cap on the housing, x", _ADI),
    _within("cap_y_hz", "Hz", 4200.0, 1.3, (100.0, 1e5), "cap on the housing, y", _ADI),
    _within("cap_axial_hz", "Hz", 3600.0, 1.3, (100.0, 1e5), "cap on the housing, axial", _ADI),
    _within("housing_damping_ratio", "", 0.03, 1.5, (0.0, 0.5), "of a housing on the plate", _GUESS + "bolted joint"),
    _within("cap_damping_ratio", "", 0.02, 1.5, (0.0, 0.5), "of a cap on its housing", _GUESS + "bolted joint"),
    _within("housing_b_ratio", "", 1.0, 1.2, (0.1, 10.0), "stiffness of housing B over A", _GUESS + "equal parts"),
    # Base plate
    _within("base_mass_kg", "kg", 17.0, 1.2, (0.5, 1e6), "plate with everything fixed to it but the housings",
            _MAFAULDA + ": 22 kg in all"),
    _within("base_length_m", "m", 0.8, 1.2, (0.1, 5.0), "of the plate, inertia and mounts", _GUESS + "bench top"),
    _within("base_width_m", "m", 0.35, 1.2, (0.05, 5.0), "of the plate, inertia and mounts", _GUESS + "bench top"),
    _within("base_height_m", "m", 0.1, 1.5, (0.01, 1.0), "of the plate, for inertia", _GUESS + "with the stator"),
    Parameter("base_centre_m", "m", 0.13, (-1.0, 2.0), "plate's mass centre from the coupling, to the free end",
              _GUESS + "middle of the plate, drawn to the motor by the stator", Uniform(0.0, 0.26)),
    _within("shaft_height_m", "m", 0.13, 1.2, (0.01, 1.0), "shaft above the plate's mass centre", _GUESS + "bench top"),
    _within("mount_depth_m", "m", 0.05, 1.5, (0.001, 1.0), "mounts below the plate's mass centre", _GUESS + "plate"),
    _within("mount_stiffness_n_m", "N/m", 1.7e4, 3.0, (10.0, 1e13), "vertical, of one of four mounts; 1e10: no motion",
            _GUESS + "rubber feet, plate alone at 10 Hz"),
    _within("mount_shear_ratio", "", 0.5, 1.5, (0.01, 10.0), "horizontal over vertical stiffness", _GUESS + "rubber"),
    _within("mount_damping_ratio", "", 0.08, 1.5, (0.0, 1.0), "of the plate bouncing on its mounts", _GUESS + "rubber"),
    Parameter("gravity_m_s2", "m/s2", 9.80665, (0.0, 20.0), "0 for a rig without weight", "standard gravity"),
)  # fmt: skip
