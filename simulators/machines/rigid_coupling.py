"""Two rigid rotors, bolted together by a flange coupling whose axes and hole circles are offset.

Source: "Misalignment in rigidly coupled rotors" (paper 002 of this project). Each rotor moves in x, y and turns; linear
supports; the bolts are springs in the plane between the two flanges (`rotor_dynamics.bolted_flange`). ``plausible``
takes the exact potential, Eq (6), and a finite rotor 1 that its driver holds near the ideal rotation;
``paper_reduction`` makes rotor 1 so heavy and so well held that three degrees of freedom remain, as in section 3.

The paper gives rotor 2 (100 kg, radius of gyration 0.3 m), torsion at 20 Hz (1200 rpm), lateral resonance at 40 Hz,
damping 0.1 % and 1 %, offset 0.5 mm. N K_b r^2 = I_2 (2 pi 20 Hz)^2 = 142.1 kN.m/rad follows. It gives neither r nor N:
r >= 0.15 m keeps the support stiffness 2's share of 40 Hz positive; r = 0.30 m, N = 4 are ours, as is all of rotor 1.

Damping 0.1 % means a time constant of 8 s in torsion: amplitudes depend on the length of the record.

The paper takes one offset for two things, and they do different things: the axes are apart (stands still), and the hole
circle is off its flange (turns). `axis_offset_m` alone preloads the shafts, `hole_circle_offset_m` alone shakes at 1X;
2X needs the second, and either the first or another static displacement, such as a sag.

Misprints and slips. With delta the offset:

* Eqs (2), (5): R_j and phi_j hold the hole circle's offset already; what is added must be the offset of the axes, which
  stands still: -delta in y, as in Eq (6). Printed is (sin, cos), turning, and against the shaft. X_j is a coordinate
  twice; rotor 2 turns by phi here, by theta later.
* Eq (3): R_j = r sqrt(1 + delta^2 + 2 delta cos alpha_j) adds metres to 1, and cos is sin:
  R_j = sqrt(r^2 + delta^2 + 2 r delta sin alpha_j), from R_j exp(i phi_j) = r exp(i alpha_j) + i delta. phi_j is right.
* Eq (8): both cross terms have the wrong sign: -2 X delta sin theta, +2 (Y - delta) delta cos theta.
* Eq (9): of theta and phi the nomenclature gives rotor 1 phi, the vector z gives rotor 1 theta.
* Eq (10): sum R_j sin phi_j is N delta, not N delta / 2, so (15) and (16) are halved. The error is "on rotor 1" here,
  on rotor 2 in the rest.
* Eq (11): K_c z' is K_c z.
* Eq (15): correct for rotor 2, linear in its angle: force N K_b delta (cos, sin) times its own twist, not times
  the difference of the twists. The printed (sin, cos) is that of Eq (5), turning against the shaft.
* Eq (16): exact is N K_b delta (sin, 1 - cos, -delta sin) on rotor 2. Printed is half of it, a quarter turn away, lacks
  the static part, and has a constant torque instead of a fluctuating one. It turns with the shaft, Eq (15) against
  it; this contradiction makes the printed 3X.
* Eq (17) therefore has no torque at 1X that is forced; its torque comes from Eq (15) times the motion only.
* Eq (18): a lost bolt takes -R_1 cos phi_1 from the cosine sum, -R_1 sin phi_1 from the sine sum, and the same from the
  sums over flange 1, which cancel most of it. Printed is -R_1 in the sine sum alone: the offset sum becomes -299 mm
  instead of 1.5 mm. K_c would lose a bolt too; it does not.
* Section 3: offset 0.5 mm in the text, 0.1 mm at Fig 4, 0.5 mm at Fig 7. The speed of Fig 7 is "10 % over critical".

``as_printed`` takes Eqs (3), (14) to (18) literally. ``as_printed_f_y`` turns the sign of F_y in Eq (16), so that (15)
and (16) have one sense of rotation. ``paper_reduction_linearised`` is what (14) to (17) should be.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from ..assembly import Assembly, Place, Probe, difference
from ..machine import MachineDefinition, Preset
from ..parameter import LogNormal, Normal, Parameter, Uniform
from ..rotor_dynamics.bolted_flange import EXACT, LINEARISED, PRINTED, BoltedFlange
from ..rotor_dynamics.harmonic_force import harmonic_force
from ..rotor_dynamics.support import Support

#: Variants of the equations.
LINEAR_EQUATIONS = "bolt forces linear in the motion"
PRINTED_EQUATIONS = "equations (3), (14) to (18) as printed"
PRINTED_FORCE_TURNED = "sign of F_y in Eq (16) turned"

_PAPER = "section 3 of paper 002"
_OURS = "not in the paper; ours"

LATERAL_HZ, TORSIONAL_HZ = 40.0, 20.0
_MASS, _GYRATION, _RADIUS, _BOLTS = 100.0, 0.3, 0.3, 4
_TORSIONAL = _MASS * _GYRATION**2 * (2 * math.pi * TORSIONAL_HZ) ** 2
_BOLT = _TORSIONAL / (_BOLTS * _RADIUS**2)
_SUPPORT = _MASS * (2 * math.pi * LATERAL_HZ) ** 2 - _BOLTS * _BOLT
#: Mass (and inertia) and stiffness that make rotor 1 the immovable one of section 3: it sags by 1e-8 m.
_HEAVY, _STIFF = 1e6, 1e15


def _difference(number: int) -> Parameter:
    meaning = f"half of the difference of support {number}'s stiffness in x less y, over their mean"
    source = "alike in the paper; estimate: no pedestal is, within some per cent"
    return Parameter(f"support_{number}_difference", "", 0.0, (-0.9, 0.9), meaning, source, Normal(0.0, 0.03))


def _unevenness(axis: str, wave: str) -> Parameter:
    meaning = f"{wave} part, by the bolt's angle, of how much stiffer than the mean a bolt is, as a share"
    source = "alike in the paper; estimate: fits and tightening make bolts unlike by some per cent"
    return Parameter(f"bolt_unevenness_{axis}", "", 0.0, (-0.4, 0.4), meaning, source, Normal(0.0, 0.02))


PARAMETERS = (
    Parameter("mass_1_kg", "kg", 1000.0, (1.0, 1e10), "mass of rotor 1, the driver", _OURS),
    Parameter("gyration_radius_1_m", "m", 0.4, (0.01, 10.0), "radius of gyration of rotor 1", _OURS),
    Parameter("support_1_n_m", "N/m", 1.4e8, (1.0, 1e15), "stiffness of support 1 in x and y", f"{_OURS}: 60 Hz"),
    _difference(1),
    Parameter("support_damping_1_n_s_m", "N.s/m", 7.5e3, (0.0, 1e14), "damping of support 1", f"{_OURS}: 1 %"),
    Parameter("mass_2_kg", "kg", _MASS, (1.0, 1e10), "mass of rotor 2", _PAPER),
    Parameter("gyration_radius_2_m", "m", _GYRATION, (0.01, 10.0), "radius of gyration of rotor 2", _PAPER),
    Parameter(
        "support_2_n_m",
        "N/m",
        _SUPPORT,
        (1.0, 1e15),
        "stiffness of support 2 in x and y",
        f"40 Hz together with the bolts, {_PAPER}",
        LogNormal(_SUPPORT, 1.5),
    ),
    _difference(2),
    Parameter(
        "support_damping_2_n_s_m",
        "N.s/m",
        2 * 0.01 * _MASS * 2 * math.pi * LATERAL_HZ,
        (0.0, 1e8),
        "damping of support 2",
        f"1 % at 40 Hz, {_PAPER}",
    ),
    Parameter("bolts", "", _BOLTS, (3.0, 100.0), "number of bolts, whole", _OURS),
    Parameter("bolt_circle_radius_m", "m", _RADIUS, (0.01, 5.0), "radius of the bolt circle", f"{_OURS}, 0.15 or more"),
    Parameter(
        "bolt_stiffness_n_m",
        "N/m",
        _BOLT,
        (1.0, 1e12),
        "stiffness of one bolt in the plane",
        f"torsion at 20 Hz with rotor 1 held, {_PAPER}",
        LogNormal(_BOLT, 2.0),
    ),
    _unevenness("x", "cosine"),
    _unevenness("y", "sine"),
    Parameter(
        "torsional_damping_n_m_s_rad",
        "N.m.s/rad",
        2 * 0.001 * _MASS * _GYRATION**2 * 2 * math.pi * TORSIONAL_HZ,
        (0.0, 1e8),
        "damping between the flanges",
        f"0.1 % at 20 Hz, {_PAPER}",
    ),
    Parameter(
        "hole_circle_offset_m",
        "m",
        5e-4,
        (-0.01, 0.01),
        "upward offset of the hole circle on flange 2 at shaft angle 0",
        _PAPER,
        Uniform(0.0, 1e-3),
    ),
    Parameter(
        "axis_offset_m", "m", 5e-4, (-0.01, 0.01), "downward offset of axis 2 from axis 1", _PAPER, Uniform(0.0, 1e-3)
    ),
    Parameter("drive_stiffness_n_m_rad", "N.m/rad", 6.7e3, (0.0, 1e15), "speed control, 1 Hz", _OURS),
    Parameter("drive_damping_n_m_s_rad", "N.m.s/rad", 640.0, (0.0, 1e15), "slope of the driver's torque line", _OURS),
    Parameter("load_torque_n_m", "N.m", 500.0, (-1e5, 1e5), "load on rotor 2, supplied by rotor 1", _OURS),
)


def build(assembly: Assembly, values: Mapping[str, float], switches: frozenset[str]) -> None:
    """Put rotors, supports, flange, torques and probes into an empty assembly."""
    for number in (1, 2):
        _add_rotor(assembly, number, values)
    first, second = assembly.places["rotor_1"], assembly.places["rotor_2"]
    assembly.add_place(Place("coupling", frozenset({"coupling"}), second.directions))
    assembly.add_place(Place("driver", frozenset({"motor"}), {"torsion": first.directions["torsion"]}))
    assembly.add_place(Place("load", frozenset({"load"}), {"torsion": second.directions["torsion"]}))
    form = PRINTED if PRINTED_EQUATIONS in switches else LINEARISED if LINEAR_EQUATIONS in switches else EXACT
    assembly.add_component(
        BoltedFlange(
            "flange",
            first,
            second,
            bolts=values["bolts"],  # type: ignore[arg-type]  # refused there when it is not whole
            bolt_stiffness_n_m=values["bolt_stiffness_n_m"],
            bolt_circle_radius_m=values["bolt_circle_radius_m"],
            hole_offset_m=1j * values["hole_circle_offset_m"],
            axis_offset_m=-1j * values["axis_offset_m"],
            torsional_damping_n_m_s_rad=values["torsional_damping_n_m_s_rad"],
            form=form,
            printed_force_y_sign=-1.0 if PRINTED_FORCE_TURNED in switches else 1.0,
            unevenness=complex(values["bolt_unevenness_x"], values["bolt_unevenness_y"]),
        )
    )
    torsion = first.directions["torsion"]
    assembly.add_spring(torsion, stiffness=values["drive_stiffness_n_m_rad"], damping=values["drive_damping_n_m_s_rad"])
    load = values["load_torque_n_m"]
    turns = (torsion, second.directions["torsion"])
    assembly.forces.append(harmonic_force("drive and load torque", turns, order=0.0, cos=(load, -load), sin=(0.0, 0.0)))
    _add_probes(assembly, first, second)


def _add_rotor(assembly: Assembly, number: int, values: Mapping[str, float]) -> None:
    name, mass = f"rotor_{number}", values[f"mass_{number}_kg"]
    assembly.add_coordinate(f"{name}.x", mass=mass)
    assembly.add_coordinate(f"{name}.y", mass=mass, vertical=True)
    assembly.add_coordinate(
        f"{name}.torsion", mass=mass * values[f"gyration_radius_{number}_m"] ** 2, torsion_ratio=1.0
    )
    directions = {axis: {f"{name}.{axis}": 1.0} for axis in ("x", "y", "torsion")}
    lateral = {axis: directions[axis] for axis in "xy"}
    assembly.add_place(Place(name, frozenset({"rotor", "disc"}), directions))
    assembly.add_place(Place(f"bearing_{number}", frozenset({"bearing", "journal"}), lateral))
    assembly.add_place(Place(f"seal_{number}", frozenset({"seal"}), lateral))
    damping, difference = values[f"support_damping_{number}_n_s_m"], values[f"support_{number}_difference"]
    mean = values[f"support_{number}_n_m"]
    x, y = mean * (1 + difference), mean * (1 - difference)
    assembly.add_component(Support(f"support_{number}", lateral["x"], lateral["y"], x, y, damping, damping))


def _add_probes(assembly: Assembly, first: Place, second: Place) -> None:
    for place in (first, second):
        for axis in ("x", "y"):
            row = place.directions[axis]
            assembly.probes.append(Probe(f"{place.name}.{axis}", "displacement", "m", place.name, axis, row))
    twist = difference(second.directions["torsion"], first.directions["torsion"])
    assembly.probes.append(Probe("twist", "displacement", "rad", "coupling", "torsion", twist))
    row = second.directions["torsion"]
    assembly.probes.append(Probe("rotor_2.torsion", "displacement", "rad", "rotor_2", "torsion", row))


_HELD = {
    "mass_1_kg": _HEAVY,
    "gyration_radius_1_m": 1.0,
    "support_1_n_m": _STIFF,
    "support_damping_1_n_s_m": math.sqrt(_HEAVY * _STIFF),
    "drive_stiffness_n_m_rad": _STIFF,
    "drive_damping_n_m_s_rad": math.sqrt(_HEAVY * _STIFF),
    "load_torque_n_m": 0.0,
}

DEFINITION = MachineDefinition(
    name="rigid_coupling",
    meaning="two rotors, of 1000 kg and 100 kg, joined by a bolted flange with an offset",
    parameters=PARAMETERS,
    presets={
        "plausible": Preset("Exact bolt forces, finite rotor 1, load 500 N.m."),
        "linearised": Preset(
            "As plausible, bolt forces linear in motion and twist.", switches=frozenset({LINEAR_EQUATIONS})
        ),
        "paper_reduction": Preset("Rotor 1 immovable, no load: section 3 with exact bolt forces.", values=_HELD),
        "paper_reduction_linearised": Preset(
            "Eqs (14) to (17), corrected.", values=_HELD, switches=frozenset({LINEAR_EQUATIONS})
        ),
        "as_printed": Preset("Eqs (14) to (18) as printed.", values=_HELD, switches=frozenset({PRINTED_EQUATIONS})),
        "as_printed_f_y": Preset(
            "As printed, with the sign of F_y in Eq (16) turned.",
            values=_HELD,
            switches=frozenset({PRINTED_EQUATIONS, PRINTED_FORCE_TURNED}),
        ),
    },
    build=build,
    step_s=1e-3,
    settle_s=60.0,
    load_parameter="load_torque_n_m",
    references=("A. W. Lees, Misalignment in rigidly coupled rotors, J. Sound Vib. 305 (2007) 261-271 (paper 002)",),
)
