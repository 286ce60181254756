"""Soft foot: one foot does not stand on its base, and its bolt pulls it down."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import LogNormal, Uniform, parameter
from ..rotor_dynamics.support import mesh_lines

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class SoftFoot(Effect):
    """One support is softer, k_y -> (1 - loss) k_y, and drawn down: its spring is unloaded a gap lower than before.

    Two things are certain of a soft foot: it carries less, and tightening it distorts the machine. So the mean position
    of the shaft shifts by a part of the gap, at every speed; the natural frequencies fall a little; 1X in y changes, by
    much only near a resonance. Multiples of 1X follow where something turns that feels the shift: a bolted coupling
    with an offset, a coupling of unequal stiffness.

    Not known well enough to be modelled: the lines often quoted for a soft foot (1X and 2X of the shaft, twice the line
    frequency of a motor whose air gap is distorted), and how far the foot closes with load. A foot that lifts off is
    the effect looseness.
    """

    NAME = "soft_foot"
    STAGE = "structure"
    ROLE = "support"
    MEANING = "A foot stands on a gap; its bolt bends the machine down onto it and holds it less firmly."
    CHECK = "Slacken one foot bolt at a time with a dial gauge on the foot: does it rise by more than 0.06 mm?"
    RIVALS = {
        "looseness": "retorque: a soft foot has torque; multiples of 1/2 X belong to looseness",
        "coupling_misalignment": "slacken the foot: does the shaft's position at the coupling change?",
        "support_anisotropy": "bump test before and after shimming; gap at the feet",
        "unbalance": "slacken the foot while running slowly, or shim it: 1X and its phase change at once",
    }
    REFERENCES = ("J. Piotrowski, Shaft Alignment Handbook, 3rd ed., CRC Press 2006",)

    gap_m: float = parameter(
        unit="m",
        bounds=(0.0, 1e-3),
        zero=0.0,
        prior=LogNormal(1e-4, 2.0),
        meaning="gap under the foot that its bolt closes",
        source="alignment practice tolerates 0.06 mm; twice that is common",
    )
    loss: float = parameter(
        unit="",
        bounds=(0.0, 0.95),
        zero=0.0,
        prior=Uniform(0.1, 0.7),
        meaning="share of the support's vertical stiffness that is missing",
        source="estimate: a foot that stands on an edge or on shims has a half of its stiffness",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Soften the chosen support and draw it down."""
        support = assembly.component(self.ROLE, self.at)
        support.scale_stiffness(y=1.0 - self.loss)
        support.draw_down(gap_m=self.gap_m)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the shift of the mean and the change of 1X in y, with gears of the mesh line."""
        assembly = machine.bare_assembly()
        assembly.component(self.ROLE, self.at)
        return (Line(0.0, "y"), Line(1.0, "y"), *mesh_lines(assembly))
