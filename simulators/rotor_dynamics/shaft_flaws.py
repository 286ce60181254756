"""Flaws that turn with a shaft: bow, unequal bending stiffness, cracks. What machines with a shaft share.

Two quantities in each plane describe a shaft to these flaws, both linear in its motion:

* the *deflection* p.q at a point, relative to the straight line through its two bearings, with the stiffness k that a
  load at that point feels (bearings rigid). A load k d at the point with its reactions at the bearings deflects the
  shaft by d there and does not load the bearings.
* the *bending moment* m.q in a section, of the sound shaft (positive where the shaft curves towards +x or +y), and
  kappa, the moment that a unit kink there would cause if both ends were held.

With them, in the frame that turns with the shaft:

* bow r: force k r p. The same as giving the unloaded shaft the shape that this load would bend it to. A shaft that is
  evenly curved between its bearings by C feels the moments -E I C and E I C there; any bend is a sum of such forces.
* unequal stiffness: k (1 - delta) along one axis, k (1 + delta) along the other, for the shape that a load at the point
  bends; shapes that are orthogonal to it keep their stiffness. Delta K = -/+ delta k p p^T.
* crack with hinge flexibility c: Delta K = -s m m^T with s = c / (1 + c kappa), which is exact for a kink.

Reference: M. I. Friswell et al., "Dynamics of Rotating Machines", Cambridge 2010, chapters 6 and 7.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..assembly import Assembly, combination
from ..law import Direction
from .crack_flexibility import crack_flexibility
from .harmonic_force import harmonic_force
from .shaft_parts import Material
from .static_load import static_motion
from .turning_stiffness import turning_stiffness

if TYPE_CHECKING:
    from ..machine import Machine

#: Below this static moment (N.m) there is nothing that closes a crack once a revolution.
LEAST_MOMENT = 1e-6


@dataclass(frozen=True)
class Deflection:
    """Deflection of a point of a shaft in two planes, and the stiffness that a load there feels (N/m)."""

    stiffness_n_m: float
    x: Direction
    y: Direction


@dataclass(frozen=True)
class BendingMoment:
    """Bending moment in a section in two planes (N.m), and the moment of a unit kink with held ends (N.m/rad)."""

    kink_stiffness_n_m_rad: float
    x: Direction
    y: Direction
    diameter_m: float


@dataclass(frozen=True)
class _Crack:
    moment: BendingMoment
    front: float
    across: float
    angle_rad: float
    abruptness: float


class FlawedShaft:
    """A shaft that can get flaws; a component with the role "shaft". Subclasses say what bends.

    Parameters
    ----------
    name : str
    shaft_ratio : float
        Speed over the reference shaft's.
    material : Material
    """

    def __init__(self, name: str, *, shaft_ratio: float, material: Material) -> None:
        self.name, self.shaft_ratio, self.material = name, shaft_ratio, material
        self.roles = frozenset({"shaft"})
        self._bows: list[tuple[tuple[Direction, Direction], float, float]] = []
        self._unequal: list[tuple[Deflection, float, float]] = []
        self._cracks: list[_Crack] = []

    def deflection(self, position: float) -> Deflection:
        """Return the deflection at ``position``, 0 at the first and 1 at the second bearing."""
        raise NotImplementedError

    def bending_moment(self, position: float) -> BendingMoment:
        """Return the bending moment at ``position``, 0 at the first and 1 at the second bearing."""
        raise NotImplementedError

    def bend(self, position: float, evenness: float) -> tuple[Direction, Direction]:
        """Return the forces in x and in y (N/m) that bend the shaft by 1 m as a load at ``position`` does.

        Of shafts that can bend in more than one shape, the share ``evenness`` of that is even curvature between the
        bearings instead, 1 m in the middle; of an ``evenness`` below 0, its share is a kink at ``position``.
        """
        place = self.deflection(position)
        return combination((place.stiffness_n_m, place.x)), combination((place.stiffness_n_m, place.y))

    def add_bow(self, *, bow_m: float, angle_rad: float, position: float, evenness: float) -> None:
        """Bend the unloaded shaft by ``bow_m`` towards ``angle_rad`` at shaft angle 0, in the shape of `bend`."""
        self._bows.append((self.bend(position, evenness), bow_m, angle_rad))

    def add_unequal_stiffness(self, *, asymmetry: float, angle_rad: float, position: float) -> None:
        """Make the shaft softer by ``asymmetry`` along ``angle_rad`` and stiffer across it."""
        self._unequal.append((self.deflection(position), asymmetry, angle_rad))

    def add_crack(self, *, depth_ratio: float, angle_rad: float, position: float, abruptness: float) -> None:
        """Cut the shaft at ``position`` from the side ``angle_rad``, by ``depth_ratio`` of its diameter."""
        moment = self.bending_moment(position)
        front, across = crack_flexibility(depth_ratio=depth_ratio, diameter_m=moment.diameter_m, material=self.material)
        self._cracks.append(_Crack(moment, front, across, angle_rad, abruptness))

    def tension_side_rad(self, assembly: Assembly, moment: BendingMoment) -> float | None:
        """Return the side of the section that the static load pulls open, from x; None without a static load.

        Parameters
        ----------
        assembly : Assembly
            In which this component and those behind it are not finished yet.
        moment : BendingMoment
        """
        later = list(assembly.components.values())
        later = later[later.index(self) + 1 :]
        unfinished = [part for part in later if "shaft" not in part.roles]
        x, y = static_motion(assembly, unfinished, (moment.x, moment.y))
        # The fibres on the outer side of the curve are stretched.
        return math.atan2(-y, -x) if math.hypot(x, y) > LEAST_MOMENT else None

    def finish(self, assembly: Assembly) -> None:
        """Add the flaws; the sound shaft is in the machine already."""
        # Before the cracks change anything: each closes under the load that the sound shaft carries.
        sides = [self.tension_side_rad(assembly, crack.moment) for crack in self._cracks]
        for number, (forces, bow, angle) in enumerate(self._bows, start=1):
            along, across = (bow * part for part in (math.cos(angle), math.sin(angle)))
            assembly.forces.append(
                harmonic_force(
                    f"bow {number} of {self.name}",
                    forces,
                    order=self.shaft_ratio,
                    cos=(along, across),
                    sin=(-across, along),
                )
            )
        for number, (place, asymmetry, angle) in enumerate(self._unequal, start=1):
            name = f"unequal stiffness {number} of {self.name}"
            uneven = asymmetry * place.stiffness_n_m
            pair = (place.x, place.y)
            assembly.forces.append(
                turning_stiffness(name, pair, shaft_ratio=self.shaft_ratio, angle_rad=angle, uneven=uneven)
            )
        for number, (crack, side) in enumerate(zip(self._cracks, sides, strict=True), start=1):
            self._finish_crack(assembly, f"crack {number} of {self.name}", crack, side)

    def _finish_crack(self, assembly: Assembly, name: str, crack: _Crack, side: float | None) -> None:
        kink = crack.moment.kink_stiffness_n_m_rad
        lost = [c / (1 + c * kink) for c in (crack.front, crack.across)]
        even, uneven = (lost[0] + lost[1]) / 2, (lost[0] - lost[1]) / 2
        if side is None:
            assembly.notes.append(
                f"{name}: no static load bends the shaft there, so the crack stays open instead of breathing. "
                "A horizontal machine needs its weight (effect gravity)."
            )
            mean, terms = even, {"uneven": uneven}
        else:
            # Open share (1 + w) / 2: half of everything is its mean.
            mean, terms = even / 2, {"even": even / 2, "uneven": uneven / 2, "breathing": uneven / 2}
            terms["abruptness"] = crack.abruptness
        for along in (crack.moment.x, crack.moment.y):
            assembly.add_spring(along, stiffness=-mean)
        pair = (crack.moment.x, crack.moment.y)
        opening = 0.0 if side is None else side
        assembly.forces.append(
            turning_stiffness(
                name, pair, shaft_ratio=self.shaft_ratio, angle_rad=crack.angle_rad, opening_rad=opening, **terms
            )
        )


class SprungShaft(FlawedShaft):
    """A shaft that a machine holds as two equal springs from its middle to its two bearings.

    The springs stand for a round shaft between simple supports, 2 k = 48 E I / L^3; L follows from k and diameter.

    Parameters
    ----------
    middle, first, second : tuple of Direction
        Motion in x and in y of the middle and at the two bearings.
    spring_n_m : float
        k of one spring.
    diameter_m : float
    """

    def __init__(
        self,
        name: str,
        *,
        middle: tuple[Direction, Direction],
        first: tuple[Direction, Direction],
        second: tuple[Direction, Direction],
        spring_n_m: float,
        diameter_m: float,
        shaft_ratio: float,
        material: Material,
    ) -> None:
        super().__init__(name, shaft_ratio=shaft_ratio, material=material)
        self._pairs = tuple(
            combination((1.0, m), (-0.5, a), (-0.5, b)) for m, a, b in zip(middle, first, second, strict=True)
        )
        self._stiffness, self._diameter = 2 * spring_n_m, diameter_m

    @property
    def length_m(self) -> float:
        """Length between the bearings of the shaft that the springs stand for."""
        second_moment = math.pi * self._diameter**4 / 64
        return (48 * self.material.youngs_modulus_pa * second_moment / self._stiffness) ** (1 / 3)

    def deflection(self, position: float) -> Deflection:
        """Return the deflection of the middle: there is no other point."""
        return Deflection(self._stiffness, self._pairs[0], self._pairs[1])

    def bending_moment(self, position: float) -> BendingMoment:
        """Return the moment k d L / 4 of the middle's deflection, less towards the bearings."""
        # A deflection towards +y curves the shaft towards -y.
        arm = -self.length_m / 2 * min(position, 1 - position)
        x, y = (combination((self._stiffness * arm, pair)) for pair in self._pairs)
        return BendingMoment(self._stiffness * arm**2, x, y, self._diameter)


def has_static_load(machine: Machine, shaft: str, position: float) -> bool:
    """Return whether a constant force of the machine bends its shaft at ``position``."""
    assembly = machine.bare_assembly()
    for effect in machine.effects:
        effect.contribute(assembly)
    part = assembly.component("shaft", shaft)
    parts = list(assembly.components.values())
    for earlier in parts[: parts.index(part)]:
        earlier.finish(assembly)
    return part.tension_side_rad(assembly, part.bending_moment(position)) is not None
