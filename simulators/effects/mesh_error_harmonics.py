"""Mesh error harmonics: every tooth has the same error of profile."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..effect import Effect, Line
from ..parameter import LogNormal, Uniform, parameter
from ._gear_damage import MARK, mesh_with_teeth

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine

_NAMES = ("first", "second", "third")


def _amplitude(number: int, median_m: float) -> Any:
    return parameter(
        unit="m",
        bounds=(0.0, 5e-5),
        zero=0.0,
        prior=LogNormal(median_m, 2.0),
        meaning=f"amplitude of the error at {number} times the mesh order",
        source="estimate: half of a form deviation of some micrometres, as of common ground gears; less at "
        "higher harmonics",
    )


def _angle(number: int) -> Any:
    return parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning=f"phase of harmonic {number} at shaft angle 0",
        source="any phase is equally likely",
    )


@dataclass(frozen=True, kw_only=True)
class MeshErrorHarmonics(Effect):
    """e = sum_k e_k sin(k z phi + psi_k): lines at the mesh order and its multiples, without sidebands.

    The error is a displacement: its lines do not grow with load; acceleration grows as speed^2 until a resonance is
    met. Large errors at light load separate the teeth. Left out: errors that differ from tooth to tooth.
    """

    NAME = "mesh_error_harmonics"
    STAGE = "structure"
    ROLE = "gear"
    SHARED = True
    MEANING = "All teeth have the same error of profile or pitch line; the mesh whines at its order and multiples."
    CHECK = "Measured profile of the gears; was the whine there when new, does it stay when the load changes?"
    RIVALS = {
        "wear": "history: wear grows over months, an error of manufacture was there from the first day",
        "backlash_growth": "load sweep: lines of an error stay, those of a changed stiffness grow with load",
        "gear_eccentricity": "no sidebands at a gear's speed",
        "housing_resonance": "speed sweep: a resonance stays at its frequency, an error at its order",
    }
    REFERENCES = (
        MARK,
        "S. L. Harris, Dynamic loads on the teeth of spur gears, Proc. IMechE 172 (1958) 87-112",
    )

    first_m: float = _amplitude(1, 2e-6)
    second_m: float = _amplitude(2, 1e-6)
    third_m: float = _amplitude(3, 5e-7)
    first_angle_rad: float = _angle(1)
    second_angle_rad: float = _angle(2)
    third_angle_rad: float = _angle(3)

    def contribute(self, assembly: Assembly) -> None:
        """Add the harmonics to the error of the mesh."""
        assembly.place(self.ROLE, self.at)
        mesh = mesh_with_teeth(assembly)
        for number, name in enumerate(_NAMES, start=1):
            mesh.add_error(
                order=number * mesh.mesh_order,
                amplitude_m=getattr(self, f"{name}_m"),
                angle_rad=getattr(self, f"{name}_angle_rad"),
            )

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the mesh order and its multiples as far as they are excited."""
        order = machine.bare_assembly().component("mesh").mesh_order
        present = [k for k, name in enumerate(_NAMES, start=1) if getattr(self, f"{name}_m") > 0]
        return tuple(Line(k * order, "any", load_exponent=0.0) for k in present)
