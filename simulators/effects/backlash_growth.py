"""Backlash growth: two gears have moved apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import LogNormal, parameter
from ._gear_damage import mesh_lines, mesh_with_teeth

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class BacklashGrowth(Effect):
    """Centre distance a -> a + growth: backlash 2 (r_b1 + r_b2) (inv alpha' - inv alpha) more, contact ratio less.

    Involutes still roll truly, so that a loaded mesh shows only another stiffness: single contact lasts longer, the
    mesh harmonics change, as deflection under load (exponent 1) and, resonances apart, not with speed. The play itself
    is felt where teeth separate: at light load, reversing torque or a strong error they rattle. Left out: the direction
    of the line of action, which turns by alpha' - alpha, and wear of the flanks as another cause of play.
    """

    NAME = "backlash_growth"
    STAGE = "structure"
    ROLE = "gear"
    SHARED = True
    MEANING = "The gears stand further apart, by worn bearings, seats or shims; backlash grows, contact ratio falls."
    CHECK = "Backlash by dial gauge against the record when new; does it rattle at light load or when torque reverses?"
    RIVALS = {
        "wear": "flank measurement; a mesh without worn flanks does not rise at light load without separation",
        "mesh_error_harmonics": "load sweep: lines of an error stay, those of a changed stiffness grow with load",
        "clearance_growth": "lift check of the bearings; lines of the ball pass",
    }
    REFERENCES = (
        "A. Kahraman and R. Singh, Non-linear dynamics of a spur gear pair, J. Sound Vib. 142 (1990) 49-75",
        "ISO/TR 10064-2:1996",
    )
    IDEALISED = True

    growth_m: float = parameter(
        unit="m",
        bounds=(0.0, 5e-4),
        zero=0.0,
        prior=LogNormal(1e-4, 2.0),
        meaning="growth of the centre distance; the backlash grows by about 0.7 of it",
        source="estimate: worn bearings or seats of a module 2 gearbox, play of some tenths of a millimetre",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Move the gears of the mesh apart."""
        assembly.place(self.ROLE, self.at)
        if self.growth_m > 0:
            mesh_with_teeth(assembly).grow_centre_distance(self.growth_m)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return harmonics of the mesh."""
        return mesh_lines(machine, 6, load_exponent=1.0)
