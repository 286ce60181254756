"""What the effects on gear teeth share: which tooth, and the lines of a mesh that repeats with a gear's turns."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from ..assembly import MissingPartError
from ..effect import Line
from ..parameter import Uniform, parameter

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine

RANDALL = "R. B. Randall, Vibration-based Condition Monitoring, Wiley 2011, chapter 5"
WU = (
    "S. Wu, M. J. Zuo, A. Parey, Simulation of spur gear dynamics and estimation of fault growth, "
    "J. Sound Vib. 317 (2008) 608-624"
)
MARK = (
    "W. D. Mark, Analysis of the vibratory excitation of gear systems: basic theory, "
    "J. Acoust. Soc. Am. 63 (1978) 1409-1430"
)


def tooth_angle() -> Any:
    """Return the declaration of the angle that says which tooth is meant."""
    return parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="turn of the gear from shaft angle 0 until the tooth comes into mesh; the nearest tooth is meant",
        source="any tooth is equally likely",
        chooses=True,
    )


def mesh_with_teeth(assembly: Assembly) -> Any:
    """Return the machine's gear mesh, which must know its teeth."""
    mesh = assembly.component("mesh")
    if mesh.pair is None:
        raise MissingPartError("The gear mesh of this machine has no teeth that can change. Use the gearbox.")
    return mesh


def tooth_of(assembly: Assembly, role: str, at: str, angle_rad: float) -> tuple[Any, int, int, bool]:
    """Return the mesh, the gear's number of teeth, the number of the tooth meant, and whether the gear is driven."""
    place, mesh = assembly.place(role, at), mesh_with_teeth(assembly)
    teeth, is_wheel = mesh.gear(place.name)
    return mesh, teeth, round(angle_rad / (2 * math.pi) * teeth) % teeth, is_wheel


def run_out_lines(machine: Machine, role: str, at: str) -> tuple[Line, ...]:
    """Return the sidebands of the mesh, and the gear's own speed in the twist, of an error that goes once a turn."""
    assembly = machine.bare_assembly()
    ratio = assembly.place(role, at).shaft_ratio
    mesh = assembly.component("mesh").mesh_order
    # At the sides the error makes one part, and the stiffness, with the load, another.
    sides = [Line(mesh + own, "any", load_exponent=None) for own in (ratio, -ratio)]
    return (*sides, Line(ratio, "torsion", load_exponent=0.0))


def once_a_turn_lines(machine: Machine, role: str, at: str, *, load_exponent: float | None) -> tuple[Line, ...]:
    """Return the gear's own speed and multiples in the twist, then sidebands of the mesh, of a pulse once a turn."""
    assembly = machine.bare_assembly()
    ratio = assembly.place(role, at).shaft_ratio
    mesh = assembly.component("mesh").mesh_order
    own = [Line(k * ratio, "torsion", load_exponent=load_exponent) for k in range(1, 7)]
    sides = [Line(mesh + k * ratio, "any", load_exponent=load_exponent) for k in (1, -1, 2, -2, 3, -3)]
    return (*own, *sides)


def mesh_lines(machine: Machine, count: int, *, load_exponent: float | None) -> tuple[Line, ...]:
    """Return the first harmonics of the mesh."""
    order = machine.bare_assembly().component("mesh").mesh_order
    return tuple(Line(k * order, "any", load_exponent=load_exponent) for k in range(1, count + 1))
