"""Oil whirl and whip: an oil film drives the shaft round at a little less than half its speed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..effect import Effect, Line
from ..parameter import LogNormal, Uniform, parameter

if TYPE_CHECKING:
    from ..assembly import Assembly
    from ..machine import Machine


@dataclass(frozen=True, kw_only=True)
class OilWhirl(Effect):
    """A film with the mean speed lambda W pushes forward with D lambda W |s|: whirl at lambda X above an onset speed.

    The machines here have stiff bearings, in which no film can whirl. The effect therefore adds what whirls: a light
    sleeve (mass m) that floats on the shaft's film beside the bearing, as a floating bush, a floating seal ring or the
    unloaded part of a sleeve bearing does. It replaces nothing. Above the onset speed W_0 it circles forward at
    lambda W with a ((W / W_0)^2 - 1)^(1/4) and shakes the shaft with m (lambda W)^2 times that. The line tracks the
    speed at 0.40-0.48 X, is no exact half, and does not follow the load (`rotor_dynamics.film_sleeve`).

    When lambda W comes to a natural frequency of the shaft, the frequency stays there while the speed rises on: whip.
    It holds as long as the resonance can take up what the film delivers, the longer the heavier the sleeve and the
    weaker the damping (computed: with a tenth of the shaft's mass and a damping ratio of 0.5 % up to lambda W = 1.6
    natural frequencies, with a quarter and 2 % up to 3). Beyond, the line tracks the speed again, which whip in a
    loaded bearing does not.

    Left out: the film's own load dependence (a loaded journal is stable, so the sleeve has no weight), cavitation, oil
    temperature, and hysteresis of onset and end other than by the shaft's resonance.
    """

    NAME = "oil_whirl"
    STAGE = "force"
    ROLE = "journal"
    MEANING = "An oil film round the shaft turns with it and drives it round at 0.40-0.48 of its speed."
    CHECK = "Sleeve bearing, floating bush or seal? Change oil temperature or load: does the line below 1/2 X go?"
    RIVALS = {
        "looseness": "non-integer order; oil temperature; forward circular orbit",
        "rub": "forward circular orbit; no exact 1/2 X; oil temperature",
        "speed_wander": "orbit; steady speed",
    }
    REFERENCES = (
        "A. Muszynska, Whirl and whip - rotor/bearing stability problems, J. Sound Vib. 110 (1986) 443-462",
        "B. L. Newkirk, H. D. Taylor, Shaft whipping due to oil action in journal bearings, General Electric Review "
        "28 (1925) 559-568",
    )
    IDEALISED = True

    damping_n_s_m: float = parameter(
        unit="N.s/m",
        bounds=(0.0, 1e3),
        zero=0.0,
        prior=LogNormal(50.0, 2.0),
        meaning="damping D of the film; 0 for no film",
        source="estimate: mass times whirl frequency, so that the whirl is there after some revolutions",
    )
    speed_share: float = parameter(
        unit="",
        bounds=(0.3, 0.5),
        prior=Uniform(0.40, 0.48),
        meaning="lambda, mean speed of the film over the shaft's",
        source="A. Muszynska 1986 and textbook practice: 0.40-0.48",
    )
    mass_kg: float = parameter(
        unit="kg",
        bounds=(0.05, 50.0),
        prior=LogNormal(0.5, 2.0),
        meaning="mass m that whirls on the film",
        source="estimate: bush or seal ring of a shaft of 20-60 mm",
    )
    onset_rpm: float = parameter(
        unit="rpm",
        bounds=(100.0, 2e4),
        prior=LogNormal(1000.0, 1.5),
        meaning="speed of the shaft above which the sleeve whirls; it sets the film's stiffness",
        source="estimate: whirl is seen on lightly loaded machines from well below 3000 rpm on",
    )
    orbit_m: float = parameter(
        unit="m",
        bounds=(2e-5, 1e-3),
        prior=LogNormal(1e-4, 1.7),
        meaning="radius a of the whirl at 1.4 times the onset speed",
        source="estimate: most of a clearance of 0.15 mm",
    )

    def contribute(self, assembly: Assembly) -> None:
        """Put the sleeve on the shaft; without a film there is none."""
        from ..rotor_dynamics.film_sleeve import add_film_sleeve

        place = assembly.place(self.ROLE, self.at)
        if not self.damping_n_s_m:
            return
        number = sum(name.startswith("film sleeve") and name.endswith(".x") for name in assembly.coordinates) + 1
        onset = self.speed_share * place.shaft_ratio * self.onset_rpm * 2 * math.pi / 60
        add_film_sleeve(
            assembly,
            place,
            f"film sleeve {number}",
            mass_kg=self.mass_kg,
            damping_n_s_m=self.damping_n_s_m,
            stiffness_n_m=self.mass_kg * onset**2,
            speed_share=self.speed_share,
            orbit_m=self.orbit_m,
        )

    def signature(self, machine: Machine) -> tuple[Line, ...]:
        """Return the whirl's line at lambda X, above the onset speed; the force grows as speed^2.5."""
        ratio = machine.bare_assembly().place(self.ROLE, self.at).shaft_ratio
        return (Line(self.speed_share * ratio, speed_exponent=2.5, load_exponent=0.0),)
