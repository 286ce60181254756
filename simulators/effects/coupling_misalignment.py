"""Misalignment of a coupling: parallel, angular, or both."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ._misalignment import ALIGNMENT, direction, offset, tilt

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class CouplingMisalignment(Effect):
    """The two halves of a coupling are offset or tilted against each other; the machine's coupling says what follows.

    A flexible coupling answers with 1X (and n - 1, n + 1 where its stiffness varies n times a revolution), others with
    2X: see the coupling's `misalignment_lines`. A spring pulls with the same force at every speed; a housing that
    circles between offset hubs with one that grows as speed^2. The force is in proportion to offset and angle and here
    does not depend on the load. Left out: friction of toothed couplings, which goes with the torque.
    """

    NAME = "coupling_misalignment"
    STAGE = "structure"
    ROLE = "coupling"
    MEANING = "The two halves of a coupling are offset (parallel) or tilted (angular) against each other."
    CHECK = ALIGNMENT
    RIVALS = {
        "axis_misalignment": "turn one hub against the other: what a hub off centre makes turns with it",
        "unbalance": "three or more speeds (the force of misalignment does not grow as speed^2); a trial mass",
        "shaft_bow": "slow-roll vector with the coupling opened; run uncoupled",
        "rotating_coupling_force": "1X at the coupling without 2X and 3X; a different coupling; run uncoupled",
        "coupling_stiffness_harmonics": "alignment corrected: lines that stay come from the coupling itself",
        "support_anisotropy": "ratio of horizontal and vertical lines; alignment corrected",
    }
    REFERENCES = (
        "D. L. Dewell and L. D. Mitchell, Detection of a misaligned disk coupling using spectrum analysis, "
        "J. Vib. Acoust. 106 (1984) 9-16",
        "M. Xu and R. D. Marangoni, Vibration analysis of a motor-flexible coupling-rotor system subject to "
        "misalignment and unbalance, J. Sound Vib. 176 (1994) 663-679, 681-691",
    )

    offset_m: float = offset("parallel misalignment of the two axes at the coupling")
    angle_rad: float = tilt()
    offset_phase_rad: float = direction("direction of the offset from x at shaft angle 0, in the sense of rotation")
    angle_phase_rad: float = direction(
        "direction of the axis about which the halves are tilted, from x at shaft angle 0"
    )

    def contribute(self, assembly: Assembly) -> None:
        """Misalign the chosen coupling, on top of any misalignment it has."""
        assembly.component(self.ROLE, self.at).misalign(
            offset_m=self.offset_m,
            angle_rad=self.angle_rad,
            offset_phase_rad=self.offset_phase_rad,
            angle_phase_rad=self.angle_phase_rad,
        )

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the lines that the coupling, with harmonics that other effects give it, makes of a misalignment."""
        return self.parts(machine).component(self.ROLE, self.at).misalignment_lines()
