"""Empirical force: it acts, a measurement shows its law, and nobody knows its cause."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..assembly import MissingPartError, combination
from ..effect import Effect, Line
from ..law import Direction, InterfaceForce, Law, Timeline
from ..parameter import LogNormal, Normal, Uniform, parameter

if TYPE_CHECKING:
    from ..assembly import Assembly, Place
    from ..machine import Machine

_RAD_S = 2 * math.pi / 60
#: A power law is not followed beyond this multiple of its amplitude: no measurement of it reached so far.
FARTHEST = 100.0


def _signals(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    order, reference, speed_power, load_factor = parameters[:4]
    cos, sin = timeline.cos_sin(order)
    # At standstill a negative power has no value; the limit below has.
    ratio = np.maximum(np.abs(timeline.speed_rad_s) / reference, 1e-9)
    scale = np.minimum(ratio**speed_power * load_factor, FARTHEST)
    return np.stack([scale * (c * cos + s * sin) for c, s in zip(parameters[4::2], parameters[5::2], strict=True)])


EMPIRICAL_LAW = Law("harmonic force with powers of speed and load", _signals)


@dataclass(frozen=True, kw_only=True)
class EmpiricalForce(Effect):
    """F (speed / reference)^p (load / reference)^q cos(n phi + psi) at a place, in a direction that stands still.

    A description, not an explanation: what is left of a measurement when no effect of the catalogue explains it. One
    instance has one order, one direction sideways, one thrust and one torque, all with the same phase; several orders,
    and forces that turn (x and y, a quarter period apart), are several instances. Motions that the place does not have
    take no part. The force grows to a hundred times its amplitude at the reference and no further.
    """

    NAME = "empirical_force"
    STAGE = "force"
    ROLE = "rotor"
    EMPIRICAL = True
    MEANING = "A force of one order of the shaft whose law in speed and load was measured and whose cause is unknown."
    CHECK = "What turns, pulses or strikes at this order near this place, and does it go when that is taken off?"
    RIVALS = {
        "unbalance": "a trial mass at the same place: what it balances is unbalance",
        "run_out": "slow-roll vector: a force has none",
        "load_fluctuation": "load changed or taken off: see whether the order goes with it",
    }
    REFERENCES = (
        "R. Markert, R. Platz and M. Seidler, Model based fault identification in rotor systems by least squares "
        "fitting, Int. J. Rotating Machinery 7 (2001) 311-321: faults as equivalent loads",
    )

    force_n: float = parameter(
        unit="N",
        bounds=(0.0, 1e4),
        zero=0.0,
        prior=LogNormal(10.0, 4.0),
        meaning="amplitude of the force sideways, at the reference speed and load",
        source="no physics says how large: like the other forces of the catalogue, within a factor",
    )
    axial_n: float = parameter(
        unit="N",
        bounds=(-1e4, 1e4),
        zero=0.0,
        prior=Normal(0.0, 10.0),
        meaning="amplitude of the thrust along the shaft; a negative one is half a period later",
        source="as the force sideways",
    )
    torque_n_m: float = parameter(
        unit="N.m",
        bounds=(-1000.0, 1000.0),
        zero=0.0,
        prior=Normal(0.0, 1.0),
        meaning="amplitude of the torque about the shaft; a negative one is half a period later",
        source="as the force sideways, at an arm of 0.1 m",
    )
    direction_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(0.0, math.pi),
        meaning="direction of the force sideways from x (horizontal), standing still; pi/2 is y",
        source="any direction is equally likely; the opposite one is half a period later",
    )
    phase_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="phase psi at shaft angle 0",
        source="any phase is equally likely",
    )
    order: float = parameter(
        unit="",
        bounds=(0.01, 200.0),
        default=1.0,
        meaning="periods in one revolution of the reference shaft",
        source="read from the measured line",
    )
    speed_exponent: float = parameter(
        unit="",
        bounds=(-2.0, 4.0),
        default=0.0,
        meaning="power p of the shaft's speed with which the force grows",
        source="fitted; 2 for masses off their axis, 0 for given displacements of springs",
    )
    reference_speed_rpm: float = parameter(
        unit="rpm",
        bounds=(10.0, 2e5),
        default=1000.0,
        meaning="speed at which the amplitudes hold; without influence where p is 0",
        source="the middle of the fitted speeds",
    )
    load_exponent: float = parameter(
        unit="",
        bounds=(0.0, 4.0),
        default=0.0,
        meaning="power q of the machine's load with which the force grows; taken as 0 where the machine has no load",
        source="fitted to recordings at several loads",
    )
    reference_load: float = parameter(
        unit="",
        bounds=(1e-3, 1e9),
        default=1.0,
        meaning="load, in the unit of the machine's load, at which the amplitudes hold",
        source="the middle of the fitted loads",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add the force where the place can move."""
        place = _place(assembly, self.at)
        acts = self._acts(place)
        if not acts:
            assembly.notes.append(
                f"{self.NAME} at {place.name}: the place moves in {', '.join(place.directions)} only; no force acts."
            )
            return
        cos, sin = math.cos(self.phase_rad), -math.sin(self.phase_rad)
        law = (self.order, self.reference_speed_rpm * _RAD_S, self.speed_exponent, self._load_factor(assembly.load))
        assembly.forces.append(
            InterfaceForce(
                f"empirical force of order {self.order:.6g} at {place.name} along {self.direction_rad:.6g} rad",
                EMPIRICAL_LAW,
                (*law, *(size * part for _, size, _ in acts for part in (cos, sin))),
                tuple(along for along, _, _ in acts),
            )
        )

    def _acts(self, place: Place) -> list[tuple[Direction, float, str]]:
        """Return where, how strongly and in which kind of direction it acts."""
        share = {"x": math.cos(self.direction_rad), "y": math.sin(self.direction_rad)}
        sideways = combination(*((share[axis], place.directions[axis]) for axis in share if axis in place.directions))
        every = ((sideways, self.force_n, "lateral"),) if sideways else ()
        for name, size in (("axial", self.axial_n), ("torsion", self.torque_n_m)):
            every += ((place.directions[name], size, name),) if name in place.directions else ()
        return [(along, size, name) for along, size, name in every if size]

    def _load_factor(self, load: float | None) -> float:
        if load is None or not self.load_exponent:
            return 1.0
        return (abs(load) / self.reference_load) ** self.load_exponent

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the order in every direction in which it acts."""
        acts = self._acts(_place(machine.bare_assembly(), self.at))
        law = {"speed_exponent": self.speed_exponent, "load_exponent": self.load_exponent}
        return tuple(Line(self.order, name, **law) for _, _, name in acts)


def _place(assembly: Assembly, name: str) -> Place:
    """Return the place of this name, or the first rotor that moves sideways, or else the first place."""
    able = {one.name: one for one in assembly.places.values() if {"x", "y", "axial", "torsion"} & set(one.directions)}
    if name in able:
        return able[name]
    if name or not able:
        raise MissingPartError(
            f"empirical_force{f' at {name!r}' if name else ''}: no such place of this machine moves; allowed: "
            f"{', '.join(able) or 'none'}. Correct the place."
        )
    return next(
        (one for one in able.values() if "rotor" in one.roles and "x" in one.directions), next(iter(able.values()))
    )
