"""Residual coupling harmonic: n times a revolution a sound coupling pushes its ends, as healthy recordings show."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..effect import Effect, Line
from ..law import Direction
from ..parameter import LogNormal, Normal, Prior, parameter
from ..rotor_dynamics.harmonic_force import harmonic_force

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine

#: Ways in which the coupling's ends push each other, and the words for them.
FORCES = {"x": "along x", "y": "along y", "axial": "along the shaft"}
MOMENTS = {"angle_x": "about x", "angle_y": "about y"}


def _component(words: str, what: str, unit: str, prior: Prior) -> Any:
    return parameter(
        unit=unit,
        bounds=(-1e4, 1e4),
        zero=0.0,
        prior=prior,
        meaning=f"{what} {words} at shaft angle 0",
        source="fitted to healthy recordings; about what an offset of 10 um, or a tilt of 1 mrad, makes of a small one",
    )


@dataclass(frozen=True, kw_only=True)
class ResidualCouplingHarmonic(Effect):
    """F = f_c cos(n phi) + f_s sin(n phi) on the driven half of a coupling, the opposite on the driving half.

    A part of the healthy machine, never a cause. Elements, teeth, discs or bolts that are not quite equal carry an
    alignment within tolerance unequally, and push n times a revolution, sideways, along the shaft and as a moment, with
    a force that does not grow with the speed. One instance has one n.
    """

    NAME = "residual_coupling_harmonic"
    STAGE = "force"
    ROLE = "coupling_halves"
    EMPIRICAL = True
    MEANING = "The forces, n times a revolution, between the ends of a sound coupling, as healthy recordings show them."
    CHECK = "What run-out do the hubs have, are all elements equal, and what does the alignment report state?"
    RIVALS = {
        "coupling_misalignment": "a recording from before: only what has changed since is a fault",
        "coupling_stiffness_harmonics": "two or more speeds: lines of an uneven stiffness grow as 1X across it does",
    }
    REFERENCES = (
        "C. B. Gibbons, Coupling misalignment forces, Proc. 5th Turbomachinery Symposium, Texas A&M (1976) 111-116",
    )

    x_cosine_n: float = _component("along x", "cosine part of the force", "N", LogNormal(1.0, 3.0))
    x_sine_n: float = _component("along x", "sine part of the force", "N", Normal(0.0, 1.0))
    y_cosine_n: float = _component("along y", "cosine part of the force", "N", Normal(0.0, 1.0))
    y_sine_n: float = _component("along y", "sine part of the force", "N", Normal(0.0, 1.0))
    axial_cosine_n: float = _component("along the shaft", "cosine part of the force", "N", Normal(0.0, 1.0))
    axial_sine_n: float = _component("along the shaft", "sine part of the force", "N", Normal(0.0, 1.0))
    angle_x_cosine_n_m: float = _component("about x", "cosine part of the moment", "N.m", Normal(0.0, 0.3))
    angle_x_sine_n_m: float = _component("about x", "sine part of the moment", "N.m", Normal(0.0, 0.3))
    angle_y_cosine_n_m: float = _component("about y", "cosine part of the moment", "N.m", Normal(0.0, 0.3))
    angle_y_sine_n_m: float = _component("about y", "sine part of the moment", "N.m", Normal(0.0, 0.3))
    order: float = parameter(
        unit="",
        bounds=(1.0, 6.0),
        default=2.0,
        meaning="periods n in one revolution of the coupling's shaft",
        source="1 to 3 are what alignment and unequal elements make",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add the forces and moments between the coupling's ends, where they can move."""
        part = assembly.component(self.ROLE, self.at)
        acts = self._acts(part)
        if not acts:
            return
        outputs, cos, sin = zip(*acts, strict=True)
        name = f"residual harmonic {self.order:g} of {part.name}"
        assembly.forces.append(harmonic_force(name, outputs, order=self.order, cos=cos, sin=sin))

    def _acts(self, part: Any) -> list[tuple[Direction, float, float]]:
        """Return where it acts, and the cosine and sine part there."""
        found = []
        for way, unit in (*((way, "n") for way in FORCES), *((way, "n_m") for way in MOMENTS)):
            cosine, sine = getattr(self, f"{way}_cosine_{unit}"), getattr(self, f"{way}_sine_{unit}")
            between = part.between(way)
            if between and (cosine or sine):
                found.append((between, cosine, sine))
        return found

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return n times the shaft's speed."""
        return (Line(self.order, speed_exponent=0.0, load_exponent=0.0),)
