"""Wear: the flanks of all teeth of a gear pair are worn where they slide most."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import LogNormal, parameter
from ._gear_damage import MARK, RANDALL, mesh_lines, mesh_with_teeth

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class Wear(Effect):
    """Flanks wear in proportion to sliding, not at all at the pitch point: an error at harmonics 1 to 5 of the mesh.

    See `rotor_dynamics.tooth_damage`. All teeth wear alike, so that no sidebands arise. The error is a displacement:
    its lines do not grow with load (they drown in the load's own deflection at high load), and acceleration grows as
    speed^2 until a resonance is met. Left out: the backlash that wear makes too, the mean of the error, which only
    turns the gears against each other, and pressure that moves to unworn parts.
    """

    NAME = "wear"
    STAGE = "structure"
    ROLE = "gear"
    SHARED = True
    MEANING = "The flanks of all teeth are worn towards tip and root; the mesh harmonics rise."
    CHECK = "Second and third mesh harmonic against the record when new; wear particles in the oil; flank measurement."
    RIVALS = {
        "mesh_error_harmonics": "history: an error of manufacture was there from the first day",
        "backlash_growth": "backlash by dial gauge; flank measurement",
        "coupling_misalignment": "sidebands at twice the shaft speed; alignment check",
        "pitting": "no sidebands at a gear's speed; inspection of the flanks",
    }
    REFERENCES = (
        "A. Flodin and S. Andersson, Simulation of mild wear in spur gears, Wear 207 (1997) 16-23",
        MARK,
        RANDALL,
    )

    wear_m: float = parameter(
        unit="m",
        bounds=(0.0, 1e-4),
        zero=0.0,
        prior=LogNormal(1e-5, 2.0),
        meaning="depth of wear at the worst end of the path of contact, both flanks together",
        source="estimate: some micrometres are running-in, 50 um at module 2 a worn-out pair",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Wear the flanks of the mesh; both gears are meant, whichever is named."""
        assembly.place(self.ROLE, self.at)
        mesh_with_teeth(assembly).add_wear(self.wear_m)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the first five harmonics of the mesh."""
        return mesh_lines(machine, 5, load_exponent=0.0)
