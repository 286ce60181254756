"""Looseness: a foot or bearing pedestal lifts off, as its bolts hold it no more."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import LogNormal, Uniform, parameter
from ..rotor_dynamics.support import mesh_lines

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class Looseness(Effect):
    """Vertical stiffness k when the support is pushed, (1 - loss) k when it is pulled beyond the point where it opens.

    Among more than three feet of a stiff frame one that is slack may carry nothing: it just touches (``hold`` 0), and
    opens in every revolution. A foot that stands by the machine's static load, its weight first of all (``hold`` 1),
    opens where the vibration's pull exceeds that load: above a speed, as the force of unbalance grows as speed^2. Below
    it nothing at all happens. Above it the support hammers: multiples of 1X in the loose direction (y), a mean lift,
    and, where the mean stiffness puts a resonance near 1/2 X, half orders as well. The static load is computed from the
    machine; one without weight and other constant forces has none, and ``hold`` means nothing there.

    A mass that bounces without static load has the natural frequency 2 w sqrt(1 - loss) / (1 + sqrt(1 - loss)),
    whatever its amplitude.

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
    IDEALISED = True

    loss: float = parameter(
        unit="",
        bounds=(0.0, 1.0),
        zero=0.0,
        prior=Uniform(0.2, 1.0),
        meaning="share of the vertical stiffness that is missing in pull; 1 for a foot that nothing holds down",
        source="estimate: an open joint hangs on its bolts, on other feet, or on nothing: a fifth lost, or all of it",
    )
    hold: float = parameter(
        unit="",
        bounds=(-1.0, 10.0),
        prior=Uniform(-0.5, 0.5),
        meaning="share of the static load to overcome before the joint opens: 0 just touches, 1 stands by its load",
        source="estimate: a foot that carries its share of the weight is not noticed, one that touches is",
    )
    rounding: float = parameter(
        unit="",
        bounds=(0.05, 1.0),
        prior=LogNormal(0.2, 1.5),
        meaning="share of the static load over which the rough faces of the joint bed down (at least 1 N)",
        source="estimate: the stiffness of rough faces grows with their load; it also keeps the force smooth",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Loosen the chosen support."""
        support = assembly.component(self.ROLE, self.at)
        support.loosen(loss=self.loss, hold=self.hold, rounding=self.rounding)

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return 1X, 2X, 3X in y, with gears the mesh line; half orders come with a resonance and are no promise."""
        assembly = machine.bare_assembly()
        assembly.component(self.ROLE, self.at)
        return (*(Line(order, "y") for order in (1.0, 2.0, 3.0)), *mesh_lines(assembly))
