"""Looseness: a foot or bearing pedestal lifts off, as its bolts hold it no more."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import LogNormal, Uniform, parameter

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class Looseness(Effect):
    """Vertical stiffness k when the support is pushed, (1 - loss) k when it is pulled by more than the clamping force.

    What holds the joint together besides ``clamp_n`` is the static load that the machine itself puts on it, its weight
    first of all. Below the speed at which the vibration's pull exceeds both, nothing happens; unbalance reaches it with
    speed^2. Above, the support hammers: multiples of 1X in the loose direction (y), a mean lift, and where the mean
    stiffness puts a resonance at 1/2 X, 3/2 X, ... half orders as well. A mass that bounces without any static load has
    the natural frequency 2 w sqrt(1 - loss) / (1 + sqrt(1 - loss)), whatever its amplitude.

    Left out: sliding in x, friction and impact damping in the joint, and that a joint which works loses more clamping.
    """

    NAME = "looseness"
    STAGE = "force"
    ROLE = "support"
    MEANING = "A foot or pedestal lifts off in every revolution, because its bolts are slack, stretched or cracked."
    CHECK = "Strike or retorque the bolts; compare vibration above and below each joint, foot against base."
    RIVALS = {
        "rub": "bolt torque; speed up and down: a loose joint comes back at the same speed, directional (y)",
        "coupling_misalignment": "half orders; bolt torque; vibration across the joint",
        "coupling_stiffness_harmonics": "run uncoupled: a loose joint stays",
        "oil_whirl": "half orders are exact multiples of 1/2 X; whirl lies below",
        "soft_foot": "lines at multiples of 1X need lifting: raise the speed; retorque",
    }
    REFERENCES = (
        "A. Muszynska, P. Goldman, Chaotic responses of unbalanced rotor/bearing/stator systems with looseness or "
        "rubs, Chaos Solitons Fractals 5 (1995) 1683-1704",
        "S. W. Shaw, P. J. Holmes, A periodically forced piecewise linear oscillator, J. Sound Vib. 90 (1983) 129-155",
    )

    loss: float = parameter(
        unit="",
        bounds=(0.0, 1.0),
        zero=0.0,
        prior=Uniform(0.2, 1.0),
        meaning="share of the vertical stiffness that is missing in pull; 1 for a foot that nothing holds down",
        source="from slack to no bolt, all equally likely",
    )
    clamp_n: float = parameter(
        unit="N",
        bounds=(-1e3, 1e4),
        prior=Uniform(-20.0, 20.0),
        meaning="clamping force that is left, beside the machine's static load; negative where other feet carry it",
        source="estimate: what is left on a slack bolt is of the order of the weight of a laboratory machine's part",
    )
    rounding_n: float = parameter(
        unit="N",
        bounds=(2.0, 1e3),
        prior=LogNormal(10.0, 2.0),
        meaning="force over which the rough surfaces of the joint bed down",
        source="estimate: a machined joint is stiff from a few newtons on; it also keeps the force smooth",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Loosen the chosen support."""
        support = assembly.component(self.ROLE, self.at)
        support.loosen(loss=self.loss, clamp_n=self.clamp_n, rounding_n=self.rounding_n)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return 1X, 2X, 3X in y; half orders come with a resonance there and are no promise."""
        machine.bare_assembly().component(self.ROLE, self.at)
        return tuple(Line(order, "y") for order in (1.0, 2.0, 3.0))
