"""Reaction of a misaligned coupling: its elements push the shaft ends apart twice and three times a revolution."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..effect import Effect, Line
from ..parameter import LogNormal, Normal, Uniform, parameter
from ..rotor_dynamics.harmonic_force import harmonic_force
from ._misalignment import ALIGNMENT

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..law import Direction
    from ..machine import Machine

#: Times a revolution that it pushes, and the words for them.
TIMES = {2: "twice", 3: "three times"}
#: Ways of the force, and the words for them.
WAYS = {"forward": "turns with the shaft", "backward": "turns against the shaft", "axial": "points along the shaft"}


def _force(times: int, way: str) -> Any:
    return parameter(
        unit="N",
        bounds=(0.0, 1e5),
        zero=0.0,
        prior=LogNormal(8.0, 5.0),
        meaning=f"amplitude of the force that acts {TIMES[times]} a revolution and {WAYS[way]}",
        source="estimate: a tenth of what bends a coupling of 1e6 N/m by 0.08 mm; stiffness and alignment vary widely",
    )


def _angle(times: int, way: str) -> Any:
    return parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="shaft angle 0 less that at which this force points along "
        + ("the shaft" if way == "axial" else "x, in the sense of rotation"),
        source="any angle is equally likely",
        period=2 * math.pi / times,
        only_with=f"{way}_{times}_n",
    )


@dataclass(frozen=True, kw_only=True)
class CouplingReaction(Effect):
    """F exp(i n (phi + a)) and F exp(-i n (phi + b)) in x + i y on the driven half, the opposite on the driving half.

    n is 2 and 3. Jaws, teeth, bolts, joints or disc packs are bent anew in every revolution by axes that do not meet,
    and none bears all of its turn alike: two that face each other twice, three of them three times a revolution. As
    they are springs the force is the same at every speed and load. Forces that turn forwards and backwards alike pulse
    in one direction. `lever_m` is the moment between the halves for each newton, which a tilt adds. Left out: what goes
    with the torque, and a floating sleeve's mass. 1X is `coupling_misalignment`.
    """

    NAME = "coupling_reaction"
    STAGE = "force"
    ROLE = "flexible_coupling"
    MEANING = "A misaligned coupling, whose elements push the shaft ends apart twice or three times a revolution."
    CHECK = ALIGNMENT
    RIVALS = {
        "axis_misalignment": "two or more speeds, where the coupling's 1X also varies; else the same to the eye",
        "coupling_stiffness_harmonics": "two or more speeds: lines of an uneven stiffness grow as 1X across it does",
        "asymmetric_shaft": "run uncoupled: 2X of the weight stays",
        "breathing_crack": "run uncoupled; 1X of a crack grows as well, and all pass their resonances by the weight",
        "looseness": "bolts retightened; half orders; run uncoupled",
    }
    REFERENCES = (
        "C. B. Gibbons, Coupling misalignment forces, Proc. 5th Turbomachinery Symposium, Texas A&M (1976) 111-116",
        "M. Xu and R. D. Marangoni, Vibration analysis of a motor-flexible coupling-rotor system subject to "
        "misalignment and unbalance, J. Sound Vib. 176 (1994) 663-679, 681-691",
    )

    forward_2_n: float = _force(2, "forward")
    backward_2_n: float = _force(2, "backward")
    axial_2_n: float = _force(2, "axial")
    forward_3_n: float = _force(3, "forward")
    backward_3_n: float = _force(3, "backward")
    axial_3_n: float = _force(3, "axial")
    forward_2_rad: float = _angle(2, "forward")
    backward_2_rad: float = _angle(2, "backward")
    axial_2_rad: float = _angle(2, "axial")
    forward_3_rad: float = _angle(3, "forward")
    backward_3_rad: float = _angle(3, "backward")
    axial_3_rad: float = _angle(3, "axial")
    lever_m: float = parameter(
        unit="m",
        bounds=(-1.0, 1.0),
        default=0.0,
        prior=Normal(0.0, 0.05),
        meaning="moment between the halves for each newton between them, in the plane of the force",
        source="estimate: elements sit some centimetres from the hubs, and a tilt adds a moment of its own",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add forces and moments between the coupling's halves, where they can move."""
        part = assembly.component(self.ROLE, self.at)
        for times in TIMES:
            acts = [act for act in self._acts(part, times) if act[0]]
            if acts:
                outputs, cos, sin = zip(*acts, strict=True)
                name = f"reaction {times} of {part.name}"
                assembly.forces.append(harmonic_force(name, outputs, order=float(times), cos=cos, sin=sin))

    def _acts(self, part: Any, times: int) -> Iterator[tuple[Direction, float, float]]:
        """Yield where it acts so many times a revolution, and the cosine and sine part there."""
        forward, backward, along = (self._complex(way, times) for way in WAYS)
        # The real part of forward + backward exp(-i n phi) turned about; y lags x by a quarter turn, or leads.
        x, y = forward + backward, 1j * (backward - forward)
        tilted = [("angle_y", self.lever_m * x), ("angle_x", -self.lever_m * y)]
        for way, force in [("x", x), ("y", y), ("axial", along), *tilted]:
            if force:
                yield part.between(way), force.real, -force.imag

    def _complex(self, way: str, times: int) -> complex:
        """Return a force as its complex amplitude along x (or the shaft)."""
        size, angle = getattr(self, f"{way}_{times}_n"), getattr(self, f"{way}_{times}_rad")
        return size * complex(math.cos(times * angle), math.sin(times * angle))

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return 2X and 3X of the coupling, those that it has."""
        made = [n for n in TIMES if any(getattr(self, f"{way}_{n}_n") for way in WAYS)]
        return tuple(Line(float(n), speed_exponent=0.0, load_exponent=0.0) for n in made)
