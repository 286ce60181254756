"""Misalignment of two machines: their axes do not meet at the coupling, in a direction that stands still in space."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..assembly import MissingPartError
from ..effect import Effect, Line
from ._misalignment import ALIGNMENT, direction, offset, tilt

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class AxisMisalignment(Effect):
    """F = k(phi) s, s standing still: harmonic n of the coupling's stiffness makes n X of it, at every speed the same.

    `coupling_misalignment` turns with the shaft (a hub bored or mounted off centre). Where two machines stand beside
    each other's axis, the elongation s of the coupling is fixed in space: a coupling of constant stiffness is bent by a
    constant force and shows nothing; one whose stiffness varies with the shaft's angle pulses n times a revolution, in
    the direction of s, forwards and backwards alike. It does not depend on the load. Left out: stiffness that couples x
    to y.
    """

    NAME = "axis_misalignment"
    STAGE = "structure"
    ROLE = "flexible_coupling"
    MEANING = "The axes of the two machines do not meet at the coupling: an offset or an angle that stands still."
    CHECK = ALIGNMENT
    RIVALS = {
        "coupling_misalignment": "turn one hub against the other: what a hub off centre makes turns with it",
        "gravity": "a vertical offset acts like a sag: alignment at rest says which",
        "coupling_stiffness_harmonics": "alignment corrected: lines that stay come from the coupling itself",
        "support_anisotropy": "ratio of horizontal and vertical lines; alignment corrected",
    }
    REFERENCES = (
        "C. B. Gibbons, Coupling misalignment forces, Proc. 5th Turbomachinery Symposium, Texas A&M (1976) 111-116",
        "M. Xu and R. D. Marangoni, Vibration analysis of a motor-flexible coupling-rotor system subject to "
        "misalignment and unbalance, J. Sound Vib. 176 (1994) 663-679, 681-691",
    )

    offset_m: float = offset("parallel misalignment: distance of the two axes at the coupling")
    angle_rad: float = tilt()
    offset_direction_rad: float = direction("direction of the offset from x towards y")
    angle_direction_rad: float = direction(
        "direction of the axis about which the two axes are tilted, from x towards y"
    )

    def contribute(self, assembly: Assembly) -> None:
        """Misalign the chosen coupling, on top of any misalignment it has.

        Raises
        ------
        MissingPartError
            When the coupling is equally stiff at every angle: nothing then moves.
        """
        part = assembly.component(self.ROLE, self.at)
        if not part.stationary_misalignment_lines():
            raise MissingPartError(
                f"Coupling {part.name} is equally stiff at every shaft angle: axes that do not meet bend it by a "
                "constant force and nothing moves. Give it coupling_stiffness_harmonics before this effect."
            )
        part.misalign(
            offset_m=self.offset_m,
            angle_rad=self.angle_rad,
            offset_phase_rad=self.offset_direction_rad,
            angle_phase_rad=self.angle_direction_rad,
            turning=False,
        )

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return n times the shaft's speed for each harmonic n of the coupling's stiffness, strongest first."""
        return self.parts(machine).component(self.ROLE, self.at).stationary_misalignment_lines()
