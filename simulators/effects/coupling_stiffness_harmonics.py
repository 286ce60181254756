"""A coupling whose stiffness varies within a revolution."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..effect import Effect, Line
from ..parameter import Uniform, parameter
from ..rotor_dynamics.flexible_coupling import LATERAL

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine

#: Harmonics that the effect offers in each direction.
ORDERS = (1, 2, 3)


def _coefficient(direction: str, order: int) -> Any:
    return parameter(
        unit="",
        bounds=(-1.0, 1.0),
        zero=0.0,
        prior=Uniform(0.0, 0.3 / order),
        meaning=f"share of the mean stiffness in {direction} that varies {order} times a revolution",
        source="paper 000 allows 0 to 1 and prints no value; 0.3 / order keeps the stiffness positive (a guess)",
    )


@dataclass(frozen=True, kw_only=True)
class CouplingStiffnessHarmonics(Effect):
    """k(phi) = k0 [1 + sum_n a_n cos(n (phi - angle))] in x, and with b_n, c_n, d_n in y, angle_x, angle_y.

    Motion across the coupling at order m (1X of unbalance or misalignment) then gives lines at m + n and m - n.
    They are a share of that motion and grow with speed and load as it does.
    """

    NAME = "coupling_stiffness_harmonics"
    STAGE = "structure"
    ROLE = "flexible_coupling"
    MEANING = "The coupling is not equally stiff at every shaft angle, so that 1X across it also makes 2X, 3X, 4X."
    CHECK = "Are all elements, discs and bolts of the coupling present, equal and tight? Is an element cracked or worn?"
    RIVALS = {
        "coupling_misalignment": "alignment corrected: these lines then shrink with 1X only; another coupling",
        "looseness": "half orders and a raised noise floor belong to looseness",
        "breathing_crack": "run-down: 2X of a crack peaks at half the critical speed; run uncoupled",
    }
    REFERENCES = (
        "Dynamic behavior of active magnetic bearings-rotor system with coupling misalignment, Eq (3)",
        "M. Xu and R. D. Marangoni, J. Sound Vib. 176 (1994) 663-679",
    )

    x_1: float = _coefficient("x", 1)
    x_2: float = _coefficient("x", 2)
    x_3: float = _coefficient("x", 3)
    y_1: float = _coefficient("y", 1)
    y_2: float = _coefficient("y", 2)
    y_3: float = _coefficient("y", 3)
    angle_x_1: float = _coefficient("angle_x", 1)
    angle_x_2: float = _coefficient("angle_x", 2)
    angle_x_3: float = _coefficient("angle_x", 3)
    angle_y_1: float = _coefficient("angle_y", 1)
    angle_y_2: float = _coefficient("angle_y", 2)
    angle_y_3: float = _coefficient("angle_y", 3)
    angle_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="shaft angle at which all harmonics have their cosine maximum",
        source="how the coupling is mounted on the shaft is arbitrary; paper 000 has 0",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add the harmonics to those that the coupling has."""
        coupling = assembly.component(self.ROLE, self.at)
        turned = np.array(ORDERS) * self.angle_rad
        for direction in LATERAL:
            size = np.array([getattr(self, f"{direction}_{n}") for n in ORDERS])
            coupling.add_stiffness_harmonics(direction, cos=size * np.cos(turned), sin=size * np.sin(turned))

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return n + 1 for each harmonic n present, strongest first: what it makes of 1X across the coupling."""
        strength = {n: max(abs(getattr(self, f"{direction}_{n}")) for direction in LATERAL) for n in ORDERS}
        present = sorted((n for n in ORDERS if strength[n]), key=lambda n: -strength[n])
        return tuple(Line(n + 1.0) for n in present)
