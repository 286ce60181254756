"""Load fluctuation: load torque or side load pulsates at a frequency of the process."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..assembly import MissingPartError
from ..effect import Effect, Line
from ..parameter import LogNormal, Uniform, parameter
from ..rotor_dynamics.fixed_frequency_force import fixed_frequency_force

if TYPE_CHECKING:
    from ..assembly import Assembly, Place
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class LoadFluctuation(Effect):
    """T cos(2 pi f t + psi) on the load's shaft and F cos(2 pi f t + psi) sideways, f being fixed in Hz.

    The frequency belongs to the process (a surging pump, a swinging belt, a controller), so that it stays when speed
    changes; what follows the shaft is `torque_ripple`. Through a gear mesh, a bearing or a coupling that is not linear
    it becomes sidebands f beside every line they make. The force grows with the load, not with speed. Where a machine's
    torsion is not modelled only the side load acts. Left out: the load's mean, which is the machine's own parameter.
    """

    NAME = "load_fluctuation"
    STAGE = "force"
    ROLE = "load"
    MEANING = "The load swings at a frequency of the process: torque and side load pulsate, lines get sidebands."
    CHECK = "Do process pressure, flow or motor current swing at the frequency of the sidebands? Run without load."
    RIVALS = {
        "torque_ripple": "speed sweep: ripple follows the shaft, the process keeps its frequency",
        "speed_wander": "the tacho: wander is in the speed itself; run without load",
        "gear_eccentricity": "speed sweep: sidebands of a gear follow its shaft",
        "twice_line_force": "the frequency: exactly twice the supply; motor current",
    }
    REFERENCES = (
        "C. J. Stander and P. S. Heyns, Instantaneous angular speed monitoring of gearboxes under non-cyclic "
        "stationary load conditions, Mech. Syst. Signal Process. 19 (2005) 817-835",
        "API RP 684, 2nd edition 2005, on train torsionals",
    )

    torque_n_m: float = parameter(
        unit="N.m",
        bounds=(0.0, 1000.0),
        zero=0.0,
        prior=LogNormal(3.0, 4.0),
        meaning="amplitude of the fluctuating torque",
        source="estimate: a tenth of a rated torque of 30 N.m",
    )
    radial_n: float = parameter(
        unit="N",
        bounds=(0.0, 1e4),
        zero=0.0,
        prior=LogNormal(10.0, 4.0),
        meaning="amplitude of the fluctuating side load",
        source="estimate: a tenth of a belt's pull or an impeller's side load of 100 N",
    )
    frequency_hz: float = parameter(
        unit="Hz",
        bounds=(0.1, 200.0),
        prior=LogNormal(5.0, 2.5),
        meaning="frequency f of the process",
        source="estimate: surging pumps and belts 1 to 20 Hz",
    )
    phase_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        prior=Uniform(-math.pi, math.pi),
        meaning="phase psi at the first sample",
        source="any phase is equally likely",
    )
    direction_rad: float = parameter(
        unit="rad",
        bounds=(-2 * math.pi, 2 * math.pi),
        default=math.pi / 2,
        prior=Uniform(0.0, math.pi),
        meaning="direction of the side load from x (horizontal), standing still",
        source="any direction is equally likely",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Add torque and side load where the load is; without a load, on the first rotor."""
        twist, side = _load_places(assembly, self.at)
        cos, sin = math.cos(self.phase_rad), -math.sin(self.phase_rad)
        acts: list[tuple[dict[str, float], float]] = []
        if twist is not None:
            acts.append((dict(twist.directions["torsion"]), self.torque_n_m))
        if side is not None:
            acts.append((dict(side.directions["x"]), self.radial_n * math.cos(self.direction_rad)))
            acts.append((dict(side.directions["y"]), self.radial_n * math.sin(self.direction_rad)))
        assembly.forces.append(
            fixed_frequency_force(
                "load fluctuation" + (f" at {self.at}" if self.at else ""),
                tuple(output for output, _ in acts),
                frequency_hz=self.frequency_hz,
                cos=tuple(size * cos for _, size in acts),
                sin=tuple(size * sin for _, size in acts),
            )
        )

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the frequency itself and, with a gear mesh, its sidebands."""
        assembly = machine.bare_assembly()
        twist, side = _load_places(assembly, self.at)
        lines = []
        if twist is not None and self.torque_n_m > 0:
            lines.append(self._line("torsion"))
            for part in assembly.components.values():
                if "mesh" in part.roles:
                    sides = (self.frequency_hz, -self.frequency_hz)
                    lines += [Line(part.mesh_order, "any", load_exponent=1.0, frequency_hz=f) for f in sides]
        if side is not None and self.radial_n > 0:
            lines.append(self._line("lateral"))
        return tuple(lines)

    def _line(self, direction: str) -> Line:
        return Line(0.0, direction, speed_exponent=0.0, load_exponent=1.0, frequency_hz=self.frequency_hz)


def _load_places(assembly: Assembly, name: str) -> tuple[Place | None, Place | None]:
    """Return where the torque and where the side load act: the load, else a rotor of the load's shaft."""
    places = [place for place in assembly.places.values() if place.roles & {"load", "rotor"}]
    if name:
        places = [place for place in places if place.name == name]
    if not places:
        able = ", ".join(p.name for p in assembly.places.values() if p.roles & {"load", "rotor"})
        raise MissingPartError(f"{name!r} is no load or rotor of this machine; allowed: {able or 'none'}.")
    first = min(places, key=lambda place: "load" not in place.roles)
    shaft = [first, *(place for place in places if place.shaft_ratio == first.shaft_ratio)]
    twist = next((place for place in shaft if "torsion" in place.directions), None)
    side = next((place for place in shaft if {"x", "y"} <= set(place.directions)), None)
    return twist, side
