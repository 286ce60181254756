"""Empirical mesh: error of the teeth and stiffness of a sound mesh, as recordings of the healthy machine show them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..effect import Effect, Line
from ..parameter import LogNormal, Normal, parameter
from ._gear_damage import MARK, mesh_lines, mesh_with_teeth

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine

_NAMES = ("first", "second", "third")


def _component(number: int, part: str, size_m: float) -> Any:
    # The first one is above zero at its median, so that the effect shows something there.
    prior = LogNormal(size_m, 3.0) if (number, part) == (1, "sine") else Normal(0.0, size_m)
    return parameter(
        unit="m",
        bounds=(-5e-5, 5e-5),
        zero=0.0,
        prior=prior,
        meaning=f"{part} part of the error at {number} times the mesh order, of the shaft angle",
        source="fitted to healthy recordings; the prior is that of common ground gears",
    )


@dataclass(frozen=True, kw_only=True)
class EmpiricalMesh(Effect):
    """e = sum_k a_k sin(k z phi) + b_k cos(k z phi) beside the model's error, and its stiffness times 1 + s.

    A part of the healthy machine, never a cause: what tooth profiles, deflections and the contact's compliance are in
    truth, no model of a mesh knows to much better than a tenth. An error is a displacement: its lines do not grow with
    the load; those of a stiffness do. With speed both grow as the gears' resonances have it.
    """

    NAME = "empirical_mesh"
    STAGE = "structure"
    ROLE = "gear"
    SHARED = True
    EMPIRICAL = True
    MEANING = "Error and stiffness of a sound gear mesh that healthy recordings ask for and the model lacks."
    CHECK = "Measured profile of the gears (ISO 1328); contact pattern under load."
    RIVALS = {
        "mesh_error_harmonics": "a recording from before: only what has changed since is a fault",
        "wear": "a recording from before: wear grows",
    }
    REFERENCES = (MARK, "ISO 6336-1:2019: mesh stiffness of involute gears")

    first_sine_m: float = _component(1, "sine", 2e-6)
    first_cosine_m: float = _component(1, "cosine", 2e-6)
    second_sine_m: float = _component(2, "sine", 1e-6)
    second_cosine_m: float = _component(2, "cosine", 1e-6)
    third_sine_m: float = _component(3, "sine", 5e-7)
    third_cosine_m: float = _component(3, "cosine", 5e-7)
    stiffness_share: float = parameter(
        unit="",
        bounds=(-0.6, 1.5),
        zero=0.0,
        prior=Normal(0.0, 0.1),
        meaning="share of the mesh stiffness that the model lacks",
        source="estimate: computed mesh stiffnesses differ by some tenths between methods",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add the harmonics to the error of the mesh, and scale its stiffness."""
        assembly.place(self.ROLE, self.at)
        mesh = mesh_with_teeth(assembly)
        for number, name in enumerate(_NAMES, start=1):
            sine, cosine = (getattr(self, f"{name}_{part}_m") for part in ("sine", "cosine"))
            if sine or cosine:
                mesh.add_error(
                    order=number * mesh.mesh_order,
                    amplitude_m=math.hypot(sine, cosine),
                    angle_rad=math.atan2(cosine, sine),
                )
        if self.stiffness_share:
            mesh.scale_stiffness(1 + self.stiffness_share)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the mesh order and its multiples."""
        return mesh_lines(machine, len(_NAMES), load_exponent=None)
