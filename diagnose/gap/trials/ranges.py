"""Where trials run each machine: speeds, loads, probes, rate and step, each with its reason."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....datasets.units import parse_unit
from ....simulators.assembly import Probe
from ....simulators.errors import InvalidValueError
from ....simulators.machine import Machine


@dataclass(frozen=True)
class TrialRange:
    """How a machine is run and recorded.

    Attributes
    ----------
    speeds_rpm : tuple of (float, float)
        Ranges from which speeds are drawn.
    conditions : tuple of int
        Fewest and most conditions of a campaign.
    loads : tuple of float, optional
        Lowest and highest load; None for a machine without one.
    load_levels : tuple of float
        The only loads that exist, when they come in steps.
    rate_hz, step_s : float
        Sampling rate, and longest integration step.
    turns : tuple of float
        Fewest and most turns of the shaft in a record.
    duration_s : float, optional
        Length of every record instead.
    probes : tuple of str
        Those recorded; all when empty.
    any_angle : tuple of str
        Parameters that may have any value of an angle although no prior says so.
    """

    speeds_rpm: tuple[tuple[float, float], ...]
    conditions: tuple[int, int]
    rate_hz: float
    step_s: float
    turns: tuple[float, float] = (60.0, 100.0)
    duration_s: float | None = None
    loads: tuple[float, float] | None = None
    load_levels: tuple[float, ...] = ()
    probes: tuple[str, ...] = ()
    any_angle: tuple[str, ...] = ()

    def recorded(self, machine: Machine) -> list[Probe]:
        """Return the probes of a machine that a campaign records."""
        known = [probe for probe in machine.bare_assembly().probes if parse_unit(probe.unit) is not None]
        return [probe for probe in known if not self.probes or probe.name in self.probes]

    def draw_speeds(self, count: int, generator: np.random.Generator) -> list[float]:
        """Return increasing speeds, one from each of ``count`` equally long parts of the ranges."""
        widths = np.array([high - low for low, high in self.speeds_rpm])
        edges = np.concatenate([[0.0], np.cumsum(widths)])
        along = (np.arange(count) + generator.uniform(size=count)) / count * edges[-1]
        piece = np.minimum(np.searchsorted(edges, along, side="right") - 1, widths.size - 1)
        return [float(self.speeds_rpm[p][0] + a - edges[p]) for p, a in zip(piece, along, strict=True)]

    def draw_loads(self, count: int, generator: np.random.Generator) -> list[float] | list[None]:
        """Return a load for each condition; None without a load."""
        if self.load_levels:
            return generator.choice(self.load_levels, size=count).tolist()
        if self.loads is None:
            return [None] * count
        return generator.uniform(*self.loads, size=count).tolist()


RANGES = {
    # Torsion resonates at 1X near 1230 rpm, where 2X also meets the lateral 2400 rpm; with stiffness off by 10 % the
    # peak may lie 5 % off, and it takes 8 s to build up. Above 2000 rpm the lateral resonance begins.
    # Its proximity probes; hardly any machine has the torsional ones.
    "rigid_coupling": TrialRange(
        ((500.0, 1110.0), (1350.0, 2000.0)),
        (4, 6),
        1000.0,
        6e-4,
        loads=(200.0, 800.0),
        probes=("rotor_1.x", "rotor_1.y", "rotor_2.x", "rotor_2.y"),
    ),
    # Stable by Floquet's multipliers from 600 to 5000 rpm (growth -1.8 1/s at most); the critical speed near 2600 rpm
    # is well damped, and crossing it is what tells unbalance from bow.
    "amb_rotor": TrialRange(((900.0, 4200.0),), (4, 6), 1800.0, 3e-4, any_angle=("unbalance_angle_rad",)),
    # Above the plate's modes on its mounts (below 900 rpm), below the bending mode of the shaft. The load comes as
    # discs: 0 or 5 kg, as in the bench's labels. The step is twice the machine's own: the motion of this linear
    # machine then differs by 1e-5 at most from that with a third of it, looseness, rub and cracks included.
    "test_rig": TrialRange(
        ((900.0, 3300.0),),
        (4, 6),
        4000.0,
        5e-5,
        turns=(50.0, 80.0),
        load_levels=(0.0, 5.0),
        any_angle=("residual_angle_rad",),
    ),
    # Below 20 N.m the teeth rattle irregularly. Probes that a gearbox has: three accelerations at the input bearing.
    "gearbox": TrialRange(
        ((1200.0, 2400.0),),
        (4, 4),
        20000.0,
        1e-5,
        duration_s=1.0,
        loads=(20.0, 60.0),
        probes=("accelerometer", "bearing 1 x", "bearing 1 y"),
        any_angle=(
            "transmission_error_angle_rad",
            *(f"bearing_{number}_angle_rad" for number in (1, 2, 3, 4)),
        ),
    ),
}


def find_range(machine: str) -> TrialRange:
    """Return how trials run this machine, or raise InvalidValueError."""
    if machine not in RANGES:
        raise InvalidValueError(f"Trials have no speeds for machine {machine!r}; allowed: {', '.join(RANGES)}.")
    return RANGES[machine]
