"""Clearance growth: a rolling bearing has worn, or sits on a shaft or in a housing that has."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import LogNormal, parameter

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class ClearanceGrowth(Effect):
    """Radial clearance c -> c + growth: fewer balls carry the load, the support softens and pulses more at BPFO.

    For a machine whose bearings have contacts with clearance; linear springs have none. The lines of the ball pass
    grow with the clearance, and so do their sidebands of a gear mesh; with load they grow less than in proportion,
    because the load zone widens. They are a displacement of the shaft, so that acceleration grows as speed^2. Under
    light load the shaft leaves the balls and rattles.
    """

    NAME = "clearance_growth"
    STAGE = "structure"
    ROLE = "bearing_with_clearance"
    MEANING = "The radial clearance of a rolling bearing has grown by wear, or a seat is worn."
    CHECK = "Lift check with an indicator; does the shaft drop or rattle at light load, is the seat polished?"
    RIVALS = {
        "outer_race_defect": "few harmonics and no raised resonance; the envelope stays flat",
        "looseness": "lift check: play between the rings, none between housing and base; bolts retightened",
        "support_anisotropy": "bump test: a soft support stays soft under load, clearance is taken up by it",
    }
    REFERENCES = (
        "T. A. Harris, Rolling Bearing Analysis, 4th ed., Wiley 2001",
        "ISO 5753-1:2009",
    )
    IDEALISED = True

    growth_m: float = parameter(
        unit="m",
        bounds=(0.0, 2e-4),
        zero=0.0,
        prior=LogNormal(2e-5, 2.0),
        meaning="growth of the radial clearance, half the growth of the play",
        source="estimate: a play of 40 um more, beyond group C4 of ISO 5753-1 for a bore of 20 mm",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Widen the chosen bearing."""
        assembly.component(self.ROLE, self.at).grow_clearance(self.growth_m)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the mesh line of a gearbox with its sidebands of the ball pass, then harmonics of the ball pass.

        The mesh line stands there anyway; a softer support changes it more than anything else.
        """
        assembly = machine.bare_assembly()
        order = assembly.component(self.ROLE, self.at).ball_pass_order
        meshes = [part.mesh_order for part in assembly.components.values() if "mesh" in part.roles]
        lines = [Line(mesh + side) for mesh in meshes for side in (0.0, order, -order)]
        return (*lines, *(Line(k * order, load_exponent=2 / 3) for k in (1, 2, 3)))
