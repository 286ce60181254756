"""Flexible coupling between two shaft ends: mean stiffness, stiffness that varies with the shaft angle, misalignment.

In each direction (x, y, angle_x, angle_y) the coupling pulls its driven end back with

    F = - k(phi) (d + s(phi)) - c (d' + s'(phi)),     k(phi) = k0 [1 + sum_n a_n cos(n phi) + b_n sin(n phi)],

d being the motion of the driven end relative to the driving end, s the misalignment and phi the shaft angle; the
driving end gets the opposite. Source: paper 000, Eqs (1)-(4), there without damping and with cosines only. Printed
Eqs (4) and (5) put + k (d + s) on the right-hand side, a spring that pushes its ends apart; the generalised force is
-dV/dq, which restores. ``reversed_sign`` keeps the print, to show what it does.

Which frame is the misalignment fixed in? Both occur, with different spectra:

* *Turning with the shaft*, s = delta (cos(phi + p), sin(phi + p)), as in Eq (1): a hub bored or mounted off centre, a
  bent shaft end. Even a coupling of constant stiffness is then bent to and fro: 1X of amplitude k0 delta at every
  speed; harmonic n of the stiffness adds n - 1 and n + 1.
* *Fixed in space*, s = delta (cos p, sin p): the axes of the two machines do not meet. A coupling of constant and equal
  stiffness then only feels a constant force; harmonic n of the stiffness turns it into n X of amplitude k0 a_n delta.

An elastic coupling that is only unequally stiff along two of its own axes has the second harmonic alone (with a_2 of
opposite sign in x and y, and a stiffness that couples x to y); a first harmonic needs something that opens, closes or
stiffens once a revolution. Eq (3) allows any a_n, without the coupling of x to y; it is empirical.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..assembly import Assembly, difference
from ..effect import Line
from ..errors import InvalidValueError
from ..law import Direction, InterfaceForce, Law, Timeline

#: Directions in which the stiffness can vary and the ends can be misaligned.
LATERAL = ("x", "y", "angle_x", "angle_y")
#: Every direction in which the coupling can be stiff.
DIRECTIONS = (*LATERAL, "torsion", "axial")
#: Highest harmonic of the stiffness: fixed, so that runs with other values can be computed side by side.
HARMONICS = 6

# Parameters of the law: sign, stiffness, damping; offset constant, cos, sin; then cos and sin of each harmonic.
_SERIES = 6


def _coupling_signals(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    """Force without motion, then the coefficient of the motion: the mean spring acts in the linear core."""
    sign, stiffness, damping, constant, along, across = parameters[:_SERIES]
    cos, sin = timeline.cos_sin(1.0)
    offset = constant + along * cos + across * sin
    rate = timeline.speed_rad_s * (across * cos - along * sin)
    variation = np.zeros(timeline.phase_rad.shape)
    for n in range(1, HARMONICS + 1):
        a, b = parameters[_SERIES + 2 * n - 2], parameters[_SERIES + 2 * n - 1]
        if a.any() or b.any():
            cos, sin = timeline.cos_sin(float(n))
            variation = variation + a * cos + b * sin
    coefficient = -sign * stiffness * variation
    return np.stack([-sign * stiffness * offset + coefficient * offset - damping * rate, coefficient])


FLEXIBLE_COUPLING = Law("flexible coupling", _coupling_signals)


@dataclass(frozen=True)
class CouplingDirection:
    """What one direction of a coupling consists of.

    Attributes
    ----------
    stiffness : float
        Mean, N/m or N.m/rad; negative with the reversed sign.
    offset : tuple of float
        Misalignment s = offset[0] + offset[1] cos(phi) + offset[2] sin(phi), m or rad.
    """

    stiffness: float
    offset: tuple[float, float, float]


def split_parameters(force: InterfaceForce) -> CouplingDirection:
    """Return stiffness and misalignment of a force made by a flexible coupling."""
    values = force.parameters
    return CouplingDirection(values[0] * values[1], (values[3], values[4], values[5]))


def without_harmonics(force: InterfaceForce) -> InterfaceForce:
    """Return a force made by a flexible coupling with its stiffness constant."""
    return replace(force, parameters=(*force.parameters[:_SERIES], *[0.0] * (2 * HARMONICS)))


@dataclass
class FlexibleCoupling:
    """A flexible coupling; a component of an assembly. See the module.

    Parameters
    ----------
    name : str
    driven, driving : mapping of str to Direction
        The motion of each end by direction (`DIRECTIONS`); an empty mapping is an end that cannot move.
    stiffness, damping : mapping of str to float
        Mean stiffness (N/m, N.m/rad) and damping (N.s/m, N.m.s/rad) by direction; directions left out carry nothing.
    reversed_sign : bool
        Take Eqs (4) and (5) of paper 000 as printed.
    """

    name: str
    driven: Mapping[str, Direction]
    stiffness: Mapping[str, float]
    driving: Mapping[str, Direction] = field(default_factory=dict)
    damping: Mapping[str, float] = field(default_factory=dict)
    reversed_sign: bool = False
    roles: frozenset[str] = frozenset({"coupling", "coupling_halves", "flexible_coupling"})
    #: By direction: the misalignment's constant, cosine and sine part.
    _offsets: dict[str, np.ndarray] = field(default_factory=lambda: {d: np.zeros(3) for d in LATERAL})
    #: By direction: row 0 the cosine, row 1 the sine coefficients of the harmonics 1 .. `HARMONICS`.
    _series: dict[str, np.ndarray] = field(default_factory=lambda: {d: np.zeros((2, HARMONICS)) for d in LATERAL})

    def __post_init__(self) -> None:
        for what, values in (("stiffness", self.stiffness), ("damping", self.damping)):
            for direction, value in values.items():
                if direction not in DIRECTIONS or not (math.isfinite(value) and value >= 0):
                    raise InvalidValueError(
                        f"Coupling {self.name}: {what} {value} in {direction!r}; allowed: numbers of at least 0 in "
                        f"{', '.join(DIRECTIONS)}."
                    )
        for direction in {*self.stiffness, *self.damping} - {*self.driven, *self.driving}:
            raise InvalidValueError(
                f"Coupling {self.name} is stiff or damped in {direction!r}, where neither end moves. Give the ends' "
                "motion in that direction, or leave the stiffness out."
            )

    def misalign(
        self,
        *,
        offset_m: float = 0.0,
        angle_rad: float = 0.0,
        offset_phase_rad: float = 0.0,
        angle_phase_rad: float = 0.0,
        turning: bool = True,
    ) -> None:
        """Add a misalignment to those present; misalignments add as vectors.

        Parameters
        ----------
        offset_m : float
            Parallel misalignment delta.
        angle_rad : float
            Angular misalignment theta: the angle between the two axes.
        offset_phase_rad, angle_phase_rad : float
            Direction of the offset, and of the axis about which the driven end is tilted, from x at shaft angle 0,
            positive in the sense of rotation.
        turning : bool
            Whether it turns with the shaft (Eq 1) or stands still in space.
        """
        for first, second, size, phase in (
            ("x", "y", offset_m, offset_phase_rad),
            ("angle_x", "angle_y", angle_rad, angle_phase_rad),
        ):
            along, across = size * math.cos(phase), size * math.sin(phase)
            self._offsets[first] += [0.0, along, -across] if turning else [along, 0.0, 0.0]
            self._offsets[second] += [0.0, across, along] if turning else [across, 0.0, 0.0]

    def add_stiffness_harmonics(self, direction: str, *, cos: Sequence[float], sin: Sequence[float] = ()) -> None:
        """Add harmonics of the shaft angle to the stiffness in one direction.

        Parameters
        ----------
        direction : str
            "x", "y", "angle_x" or "angle_y".
        cos, sin : sequence of float
            Coefficients of cos(n phi) and sin(n phi), n = 1, 2, ..., as a fraction of the mean stiffness.
        """
        number = max(len(cos), len(sin))
        if direction not in LATERAL or number > HARMONICS:
            raise InvalidValueError(
                f"Coupling {self.name}: {number} stiffness harmonics in {direction!r}; allowed: at most {HARMONICS} in "
                f"{', '.join(LATERAL)}."
            )
        self._series[direction][0, : len(cos)] += cos
        self._series[direction][1, : len(sin)] += sin

    def between(self, direction: str) -> Direction:
        """Return the motion of the driven end less that of the driving end; empty where neither moves."""
        return difference(self.driven.get(direction, {}), self.driving.get(direction, {}))

    def stiffness_factor(self, direction: str, phase_rad: np.ndarray) -> np.ndarray:
        """Return k(phi) / k0 in one of the lateral directions, same shape as ``phase_rad``."""
        order = np.arange(1, HARMONICS + 1)
        angle = np.multiply.outer(np.asarray(phase_rad, float), order)
        cos, sin = self._series[direction]
        return 1 + np.cos(angle) @ cos + np.sin(angle) @ sin

    def misalignment_lines(self) -> tuple[Line, ...]:
        """Return the lines that a misalignment turning with the shaft raises: 1X, and n - 1, n + 1 for harmonic n."""
        orders = dict.fromkeys([1, *(m for n in self._strongest_harmonics() for m in (n - 1, n + 1) if m)])
        return tuple(Line(float(order), speed_exponent=0.0) for order in orders)

    def stationary_misalignment_lines(self) -> tuple[Line, ...]:
        """Return the lines of an elongation that stands still in space (alignment, sag): n X for harmonic n."""
        return tuple(Line(float(n), speed_exponent=0.0) for n in self._strongest_harmonics())

    def _strongest_harmonics(self) -> list[int]:
        present = np.abs(list(self._series.values())).max(axis=(0, 1))
        return sorted((n for n in range(1, HARMONICS + 1) if present[n - 1]), key=lambda n: -present[n - 1])

    def finish(self, assembly: Assembly) -> None:
        """Add the mean spring and damper to the linear core, and misalignment and stiffness variation as forces."""
        sign = -1.0 if self.reversed_sign else 1.0
        for direction in DIRECTIONS:
            stiffness, damping = self.stiffness.get(direction, 0.0), self.damping.get(direction, 0.0)
            if not (stiffness or damping):
                continue
            along = self.between(direction)
            assembly.add_spring(along, stiffness=sign * stiffness, damping=damping)
            if direction not in LATERAL:
                continue
            self._warn_of_negative_stiffness(assembly, direction)
            parameters = (sign, stiffness, damping, *self._offsets[direction], *self._series[direction].T.ravel())
            name = f"coupling {self.name} in {direction}"
            assembly.forces.append(
                InterfaceForce(name, FLEXIBLE_COUPLING, tuple(map(float, parameters)), (along,), (along,))
            )

    def _warn_of_negative_stiffness(self, assembly: Assembly, direction: str) -> None:
        if np.hypot(*self._series[direction]).sum() < 1:
            return
        lowest = self.stiffness_factor(direction, np.linspace(0, 2 * math.pi, 721)).min()
        if lowest < 0:
            assembly.notes.append(
                f"Coupling {self.name}: the stiffness in {direction} falls to {lowest:.2f} of its mean within a "
                "revolution; below 0 it pushes its ends apart, which no coupling does. Use smaller harmonics."
            )
