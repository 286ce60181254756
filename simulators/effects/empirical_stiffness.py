"""Empirical stiffness: a spring or damper that recordings of a healthy machine ask for and its model lacks."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..assembly import MissingPartError
from ..effect import Effect, Line
from ..law import InterfaceForce, Law, Timeline
from ..parameter import LogNormal, Normal, parameter
from ..rotor_dynamics.support import mesh_lines

if TYPE_CHECKING:
    from ..assembly import Assembly, Place
    from ..machine import Machine

_RAD_S = 2 * math.pi / 60


def _signals(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    stiffness, difference, cross, damping, power, reference = parameters
    scale = np.minimum(np.abs(timeline.speed_rad_s) / reference, 1.0) ** power
    none, across, damped = np.zeros_like(scale), cross * scale, -damping * scale
    along_x, along_y = -(stiffness + difference) * scale, -(stiffness - difference) * scale
    return np.stack([none, none, along_x, -across, damped, none, across, along_y, none, damped])


EMPIRICAL_STIFFNESS = Law("spring and damper with a power of speed", _signals)


@dataclass(frozen=True, kw_only=True)
class EmpiricalStiffness(Effect):
    """F_x = -s ((k + d) x + q y + c x'), F_y = -s ((k - d) y - q x + c y'), s = (speed / reference)^p, to the ground.

    A description, not an explanation: what the supports of a model lack or have too much of, as its healthy recordings
    say. A cross-coupled stiffness q above 0 drives the motion that turns from x to y, as the fluid in a seal or a plain
    bearing does; a machine with more of it than its damping holds is unstable. Beyond the reference speed nothing
    grows, as no recording reached there; no change with the load is known.
    """

    NAME = "empirical_stiffness"
    STAGE = "structure"
    ROLE = "bearing"
    EMPIRICAL = True
    MEANING = "A spring or damper at a support that healthy recordings ask for and the model lacks."
    CHECK = (
        "How stiff is the support at these speeds (bump tests at rest and running); does a fluid surround the shaft?"
    )
    RIVALS = {
        "support_anisotropy": "bump test in x and y",
        "oil_whirl": "change the oil's temperature: a spring does not follow it",
    }
    REFERENCES = (
        "M. I. Friswell, J. E. Mottershead, Finite Element Model Updating in Structural Dynamics, Kluwer 1995",
        "M. I. Friswell et al., Dynamics of Rotating Machines, Cambridge 2010, chapter 5 (bearings, seals)",
    )

    stiffness_n_m: float = parameter(
        unit="N/m",
        bounds=(-1e9, 1e9),
        zero=0.0,
        prior=LogNormal(1e5, 4.0),
        meaning="mean stiffness k of x and y at the reference speed, added to what the model has",
        source="fitted to healthy recordings; the prior is a guess, on small machines",
    )
    difference_n_m: float = parameter(
        unit="N/m",
        bounds=(-1e9, 1e9),
        zero=0.0,
        prior=Normal(0.0, 1e4),
        meaning="half of the difference d of the stiffness in x over that in y, at the reference speed",
        source="fitted to healthy recordings; the prior is a guess, on small machines",
    )
    cross_n_m: float = parameter(
        unit="N/m",
        bounds=(-1e9, 1e9),
        zero=0.0,
        prior=Normal(0.0, 1e4),
        meaning="cross-coupled stiffness q at the reference speed; above 0 it drives motion that turns from x to y",
        source="fitted to healthy recordings; the prior is a guess, on small machines",
    )
    damping_n_s_m: float = parameter(
        unit="N.s/m",
        bounds=(-1e7, 1e7),
        zero=0.0,
        prior=Normal(0.0, 100.0),
        meaning="damping c in x and y at the reference speed, added to what the model has",
        source="fitted to healthy recordings; the prior is a guess, on small machines",
    )
    speed_exponent: float = parameter(
        unit="",
        bounds=(0.0, 4.0),
        default=0.0,
        meaning="power p of the shaft's speed with which all of them grow",
        source="fitted to healthy recordings",
    )
    reference_speed_rpm: float = parameter(
        unit="rpm",
        bounds=(10.0, 2e5),
        default=1000.0,
        meaning="speed from which on the values hold; without influence where p is 0",
        source="the highest of the fitted speeds",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add spring and damper between the place and the ground."""
        place = _place(assembly, self.at)
        strengths = (self.stiffness_n_m, self.difference_n_m, self.cross_n_m, self.damping_n_s_m)
        if not any(strengths):
            return
        along = (place.directions["x"], place.directions["y"])
        assembly.forces.append(
            InterfaceForce(
                f"empirical stiffness at {place.name}, power {self.speed_exponent:.6g}",
                EMPIRICAL_STIFFNESS,
                (*strengths, self.speed_exponent, self.reference_speed_rpm * _RAD_S),
                along,
                along,
                along,
            )
        )

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return 1X, with gears the mesh line: no line is new, those that the machine has anyway change."""
        return mesh_lines(machine.bare_assembly()) or (Line(1.0),)


def _place(assembly: Assembly, name: str) -> Place:
    """Return the place of this name, or the first bearing that moves sideways."""
    able = {one.name: one for one in assembly.places.values() if {"x", "y"} <= set(one.directions)}
    bearings = [one for one in able.values() if "bearing" in one.roles]
    if name in able:
        return able[name]
    if name or not bearings:
        raise MissingPartError(
            f"empirical_stiffness{f' at {name!r}' if name else ''}: no such place of this machine moves in x and y; "
            f"allowed: {', '.join(able) or 'none'}. Correct the place."
        )
    return bearings[0]
