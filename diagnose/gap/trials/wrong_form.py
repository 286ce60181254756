"""A machine whose supports behave otherwise than its model's: stiffness that changes with speed, and across.

At every support, with k its stiffness: F = -s k (v / v_top)^p d in x and y, and F_x = -q k y, F_y = q k x; v_top is the
highest speed of the trials. The share of s is the stated one, with a sign of its own at each support; p lies evenly
between 0.5 and 2.5; the share of q is the stated one, with one sign for the machine. The law is the trials' own: the
engine's terms have whole powers.

Lightly damped supports do not hold so much across: q is at most half of what a mass on its damped spring holds.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from ....simulators.assembly import Assembly
from ....simulators.errors import InvalidValueError
from ....simulators.law import InterfaceForce, Law, Timeline
from ....simulators.machine import Machine
from .ranges import TrialRange

#: Share of the cross-coupled stiffness that a support's damping holds.
HELD = 0.5


def _signals(timeline: Timeline, parameters: np.ndarray) -> np.ndarray:
    along, power, top, across = parameters
    own = -along * (np.abs(timeline.speed_rad_s) / top) ** power
    turning = across * np.ones_like(own)
    none = np.zeros_like(own)
    return np.stack([none, none, own, -turning, turning, own])


_LAW = Law("support that the model has wrong", _signals)


@dataclass(frozen=True)
class SupportFigures:
    """Stiffness (N/m) and damping (N.s/m) of a support, and the mass (kg) that it holds."""

    stiffness_n_m: float
    damping_n_s_m: float
    mass_kg: float

    def across_n_m(self, share: float) -> float:
        """Return the stated share of the stiffness, or less where the damping does not hold so much across.

        A mass on a damped spring is stable up to q = c sqrt(k / m); half of that is allowed.
        """
        held = self.damping_n_s_m * math.sqrt(self.stiffness_n_m / self.mass_kg)
        return math.copysign(min(abs(share) * self.stiffness_n_m, HELD * held), share)


def _magnets(machine: Machine) -> dict[str, SupportFigures]:
    given = machine.values
    gain = given["sensor_gain_v_m"] * given["amplifier_gain_a_v"] * given["current_stiffness_n_a"]
    stiffness = gain * given["proportional"] - given["displacement_stiffness_n_m"]
    # At rest, without the slow integral part. A rotor of 6 kg, half of it on each.
    return dict.fromkeys(("bearing_1", "bearing_2"), SupportFigures(stiffness, gain * given["derivative"], 3.0))


def _rotors(machine: Machine) -> dict[str, SupportFigures]:
    given = machine.values
    return {
        f"bearing_{n}": SupportFigures(
            given[f"support_{n}_n_m"], given[f"support_damping_{n}_n_s_m"], given[f"mass_{n}_kg"]
        )
        for n in (1, 2)
    }


def _pedestals(machine: Machine) -> dict[str, SupportFigures]:
    parts, mass = machine.bare_assembly().components, machine.values["housing_mass_kg"]
    found = {}
    for name in ("housing_a", "housing_b"):
        part = parts[f"{name} pedestal"]
        found[name] = SupportFigures(part.stiffness_y_n_m, part.damping_y_n_s_m, mass)
    return found


_SUPPORTS = {"amb_rotor": _magnets, "rigid_coupling": _rotors, "test_rig": _pedestals}


def supports_of(machine: Machine) -> dict[str, SupportFigures]:
    """Return the figures of each support, by the name of its place, or raise InvalidValueError."""
    if machine.name not in _SUPPORTS:
        raise InvalidValueError(
            f"Trials do not know the supports of {machine.name!r}; allowed with a wrong form: {', '.join(_SUPPORTS)}. "
            "Leave the form right, or choose another machine."
        )
    return _SUPPORTS[machine.name](machine)


def with_wrong_form(machine: Machine, share: float, how: TrialRange, generator: np.random.Generator) -> Machine:
    """Return the machine with supports that are wrong by a share of their stiffness; see the module's docstring.

    Raises
    ------
    InvalidValueError
        Where the trials do not know the machine's supports.
    """
    top = how.speeds_rpm[-1][1] * 2 * math.pi / 60
    turning = float(generator.choice([-1.0, 1.0])) * share
    laws: dict[str, tuple[float, ...]] = {}
    for place, support in supports_of(machine).items():
        along = float(generator.choice([-1.0, 1.0])) * share * support.stiffness_n_m
        laws[place] = (along, float(generator.uniform(0.5, 2.5)), top, support.across_n_m(turning))
    build = machine.definition.build

    def wrong(assembly: Assembly, values: Mapping[str, float], switches: frozenset[str]) -> None:
        build(assembly, values, switches)
        for name, law in laws.items():
            along = tuple(assembly.places[name].directions[axis] for axis in ("x", "y"))
            assembly.forces.append(InterfaceForce(f"wrong support {name}", _LAW, law, along, along))

    return replace(machine, definition=replace(machine.definition, build=wrong))
