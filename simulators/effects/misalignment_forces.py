"""Misalignment forces: what a misaligned flexible coupling pushes and bends with, several times a revolution."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..assembly import combination
from ..effect import Effect, Line
from ..parameter import LogNormal, Prior, Uniform, parameter
from ..rotor_dynamics.harmonic_force import harmonic_force
from ._misalignment import ALIGNMENT

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..law import Direction
    from ..machine import Machine

#: Times a revolution that it acts, and the words for them.
TIMES = {1: "once", 2: "twice", 3: "three times", 4: "four times"}
#: Ways of force or moment with the unit of each: what acts, in words.
WAYS = {
    "forward": ("n", "force, turning with the shaft,"),
    "backward": ("n", "force, turning against the shaft,"),
    "axial": ("n", "force along the shaft"),
    "forward_bend": ("n_m", "moment, its plane turning with the shaft,"),
    "backward_bend": ("n_m", "moment, its plane turning against the shaft,"),
}
_FORCE = "estimate: a tenth of what bends a coupling of 1e6 N/m by 0.08 mm; stiffness and alignment vary widely"
_MOMENT = "estimate: a tenth of what bends a coupling of 300 N.m/rad by 10 mrad; stiffness and alignment vary widely"
_MASS = "estimate: a sleeve or disc of 0.2 kg between hubs that are offset by 0.1 mm"


def _strength(unit: str, prior: Prior, meaning: str, source: str, *, accompanies: bool = False) -> Any:
    bounds = (0.0, 1e5)
    return parameter(
        unit=unit, bounds=bounds, zero=0.0, prior=prior, meaning=meaning, source=source, accompanies=accompanies
    )


def _amplitude(way: str, times: int) -> Any:
    """Declare an amplitude; what acts once a revolution alone would be a rotating coupling force."""
    unit, what = WAYS[way]
    meaning = f"amplitude of the {what} {TIMES[times]} a revolution"
    if unit == "n":
        return _strength("N", LogNormal(8.0, 5.0), meaning, _FORCE, accompanies=times == 1)
    return _strength("N.m", LogNormal(0.3, 5.0), meaning, _MOMENT, accompanies=times == 1)


def _angle(strength: str, times: int) -> Any:
    where = "the shaft" if strength.startswith("axial") else "x"
    return parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning=f"shaft angle 0 less that at which {strength} acts along {where}",
        source="any angle is equally likely",
        period=2 * math.pi / times,
        only_with=strength,
    )


@dataclass(frozen=True, kw_only=True)
class MisalignmentForces(Effect):
    """F exp(i n (phi + a)) + B exp(-i n (phi + b)) in x + i y on the driven half, the opposite on the driving half.

    n is 1 to 4. Jaws, teeth, bolts, joints or disc packs are bent anew in every revolution by axes that do not meet,
    and none bears all of its turn alike: two that face each other act twice a revolution, three of them three times. As
    they are springs, forces and moments are the same at every speed and load. Offset axes push, along the shaft as
    well; tilted ones bend. Equal parts forwards and backwards pulse in one direction. A sleeve or disc that floats
    between offset hubs circles twice a revolution: its force, half of it on each hub, grows as speed^2. Left out: more
    than four times a revolution, and what goes with the torque. 1X alone is `coupling_misalignment`.
    """

    NAME = "misalignment_forces"
    STAGE = "force"
    ROLE = "flexible_coupling"
    MEANING = "A misaligned flexible coupling, whose elements push and bend the shaft ends several times a revolution."
    CHECK = ALIGNMENT
    RIVALS = {
        "axis_misalignment": "alignment corrected: both go; a coupling known to be uneven makes the former",
        "coupling_stiffness_harmonics": "two or more speeds: lines of an uneven stiffness grow as 1X across it does",
        "asymmetric_shaft": "run uncoupled: 2X of the weight stays",
        "breathing_crack": "run uncoupled: 2X and 3X of a crack stay",
        "looseness": "bolts retightened; half orders; run uncoupled",
    }
    REFERENCES = (
        "C. B. Gibbons, Coupling misalignment forces, Proc. 5th Turbomachinery Symposium, Texas A&M (1976) 111-116",
        "M. Xu and R. D. Marangoni, Vibration analysis of a motor-flexible coupling-rotor system subject to "
        "misalignment and unbalance, J. Sound Vib. 176 (1994) 663-679, 681-691",
    )

    forward_1_n: float = _amplitude("forward", 1)
    backward_1_n: float = _amplitude("backward", 1)
    axial_1_n: float = _amplitude("axial", 1)
    forward_bend_1_n_m: float = _amplitude("forward_bend", 1)
    backward_bend_1_n_m: float = _amplitude("backward_bend", 1)
    forward_2_n: float = _amplitude("forward", 2)
    backward_2_n: float = _amplitude("backward", 2)
    axial_2_n: float = _amplitude("axial", 2)
    forward_bend_2_n_m: float = _amplitude("forward_bend", 2)
    backward_bend_2_n_m: float = _amplitude("backward_bend", 2)
    circling_2_kg_m: float = _strength(
        "kg.m", LogNormal(1e-5, 5.0), "mass that circles twice a revolution times the radius of its circle", _MASS
    )
    forward_3_n: float = _amplitude("forward", 3)
    backward_3_n: float = _amplitude("backward", 3)
    axial_3_n: float = _amplitude("axial", 3)
    forward_bend_3_n_m: float = _amplitude("forward_bend", 3)
    backward_bend_3_n_m: float = _amplitude("backward_bend", 3)
    forward_4_n: float = _amplitude("forward", 4)
    backward_4_n: float = _amplitude("backward", 4)
    axial_4_n: float = _amplitude("axial", 4)
    forward_bend_4_n_m: float = _amplitude("forward_bend", 4)
    backward_bend_4_n_m: float = _amplitude("backward_bend", 4)
    forward_1_rad: float = _angle("forward_1_n", 1)
    backward_1_rad: float = _angle("backward_1_n", 1)
    axial_1_rad: float = _angle("axial_1_n", 1)
    forward_bend_1_rad: float = _angle("forward_bend_1_n_m", 1)
    backward_bend_1_rad: float = _angle("backward_bend_1_n_m", 1)
    forward_2_rad: float = _angle("forward_2_n", 2)
    backward_2_rad: float = _angle("backward_2_n", 2)
    axial_2_rad: float = _angle("axial_2_n", 2)
    forward_bend_2_rad: float = _angle("forward_bend_2_n_m", 2)
    backward_bend_2_rad: float = _angle("backward_bend_2_n_m", 2)
    circling_2_rad: float = _angle("circling_2_kg_m", 2)
    forward_3_rad: float = _angle("forward_3_n", 3)
    backward_3_rad: float = _angle("backward_3_n", 3)
    axial_3_rad: float = _angle("axial_3_n", 3)
    forward_bend_3_rad: float = _angle("forward_bend_3_n_m", 3)
    backward_bend_3_rad: float = _angle("backward_bend_3_n_m", 3)
    forward_4_rad: float = _angle("forward_4_n", 4)
    backward_4_rad: float = _angle("backward_4_n", 4)
    axial_4_rad: float = _angle("axial_4_n", 4)
    forward_bend_4_rad: float = _angle("forward_bend_4_n_m", 4)
    backward_bend_4_rad: float = _angle("backward_bend_4_n_m", 4)

    def contribute(self, assembly: Assembly) -> None:
        """Add forces and moments between the coupling's halves, where they can move, and on both of them."""
        part = assembly.component(self.ROLE, self.at)
        for times in TIMES:
            acts = [act for act in self._acts(part, times) if act[0]]
            if acts:
                self._add(assembly, f"reaction {times} of {part.name}", acts, times)
        circling = self._complex("circling", 2, "kg_m")
        if circling:
            x, y = (combination((0.5, part.driven.get(d, {})), (0.5, part.driving.get(d, {}))) for d in "xy")
            # The mass circles at twice the shaft's speed.
            acts = [(x, 4 * circling.real, -4 * circling.imag), (y, 4 * circling.imag, 4 * circling.real)]
            self._add(assembly, f"mass that circles in {part.name}", acts, 2, speed_power=2.0)

    @staticmethod
    def _add(
        assembly: Assembly,
        name: str,
        acts: Sequence[tuple[Direction, float, float]],
        times: int,
        *,
        speed_power: float = 0.0,
    ) -> None:
        outputs, cos, sin = zip(*acts, strict=True)
        force = harmonic_force(name, outputs, order=float(times), cos=cos, sin=sin, speed_power=speed_power)
        assembly.forces.append(force)

    def _acts(self, part: Any, times: int) -> Iterator[tuple[Direction, float, float]]:
        """Yield where it acts so many times a revolution, and the cosine and sine part there."""
        of = {way: self._complex(way, times, unit) for way, (unit, _) in WAYS.items()}
        # Real parts, turned about by n phi: y lags x by a quarter turn forwards, leads it backwards.
        x, y = of["forward"] + of["backward"], 1j * (of["backward"] - of["forward"])
        # A moment in the plane of x and z turns about y, one in that of y and z about -x.
        bends = of["forward_bend"] + of["backward_bend"], 1j * (of["backward_bend"] - of["forward_bend"])
        acts = {"x": x, "y": y, "axial": of["axial"], "angle_y": bends[0], "angle_x": -bends[1]}
        for direction, amplitude in acts.items():
            if amplitude:
                yield part.between(direction), amplitude.real, -amplitude.imag

    def _complex(self, way: str, times: int, unit: str) -> complex:
        """Return an amplitude with its phase, along x (or the shaft)."""
        size, angle = getattr(self, f"{way}_{times}_{unit}"), getattr(self, f"{way}_{times}_rad")
        # Against the shaft x + i y is the conjugate, whose real part is the same.
        return size * complex(math.cos(times * angle), math.sin(times * angle))

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return 1X to 4X of the coupling, those that it has; 2X of a mass that circles grows with the speed."""
        made = [n for n in TIMES if any(getattr(self, f"{way}_{n}_{unit}") for way, (unit, _) in WAYS.items())]
        circles = self.circling_2_kg_m > 0
        orders = sorted({*made, 2} if circles else set(made), key=lambda n: (n == 1, n))
        laws = {n: 0.0 for n in made} | ({2: 2.0 if 2 not in made else None} if circles else {})
        return tuple(Line(float(n), speed_exponent=laws[n], load_exponent=0.0) for n in orders)
