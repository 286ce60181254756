"""What sinusoidal forces that do not follow the shaft add to the motion of a linear machine.

The motion of a linear machine with constant coefficients is a sum: each sinusoidal force adds a motion of its own
frequency, through the dynamic stiffness there, whatever else acts.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..law import InterfaceForce, Timeline
from ..machine import Machine
from ..speed_profile import steady
from ..system import System
from .frequency_response import Spinning, responses

#: Instants of a turn at which coefficients are looked at.
INSTANTS = 64


@dataclass(frozen=True, eq=False)
class Wave:
    """A sinusoidal motion at the probes: the real part of amplitude exp(i (order phi + 2 pi f t)).

    Attributes
    ----------
    order : float
        Of the reference shaft.
    frequency_hz : float
        Fixed in Hz, beside the order.
    amplitudes : ndarray (probes,), complex
        In the probes' own quantity.
    """

    order: float
    frequency_hz: float
    amplitudes: np.ndarray

    def waveform(self, phase_rad: np.ndarray, time_s: np.ndarray) -> np.ndarray:
        """Return the probe signals, shape (probes, instants), at these shaft angles and instants (instants,)."""
        angle = self.order * phase_rad + 2 * math.pi * self.frequency_hz * time_s
        return np.real(np.outer(self.amplitudes, np.exp(1j * angle)))


def superposed_waves(machine: Machine, without: Machine, *, speed_rpm: float) -> list[Wave] | None:
    """Return what a machine's sinusoidal forces add, all at constant speed, to the motion of it without them.

    Parameters
    ----------
    machine, without : Machine
        With all effects, and with those only whose forces are not wanted.
    speed_rpm : float

    Returns
    -------
    list of Wave, or None
        None where the sum does not hold: the machine is not linear, its coefficients turn with the shaft, or the two
        machines differ by something else than sinusoidal forces.
    """
    whole, rest = machine.system(speed_rpm=speed_rpm), without.system(speed_rpm=speed_rpm)
    further = [number for number, force in enumerate(whole.forces) if force not in rest.forces]
    (speed,) = steady(speed_rpm=speed_rpm).speeds_rad_s
    alike = len(whole.forces) - len(further) == len(rest.forces) and np.array_equal(whole.core, rest.core)
    if not alike or not _is_constant(rest, speed):
        return None
    waves = []
    for number in further:
        wave = _wave(whole, number, speed)
        if wave is None:
            return None
        waves.append(wave)
    return waves


def _is_constant(system: System, speed_rad_s: float) -> bool:
    """Return whether nothing but the linear core reads the motion."""
    turn = 2 * math.pi * np.arange(INSTANTS)[:, None] / INSTANTS
    timeline = Timeline(turn / speed_rad_s, turn, np.full_like(turn, speed_rad_s), np.zeros_like(turn))
    return all(_reads_nothing(force, timeline) for force in system.forces)


def _reads_nothing(force: InterfaceForce, timeline: Timeline) -> bool:
    if not force.law.is_linear:
        return False
    if not force.displacements and not force.velocities:
        return True
    signals = force.law.signals(timeline, np.array(force.parameters)[:, None])
    return not signals[len(force.outputs) :].any()


def _wave(system: System, number: int, speed_rad_s: float) -> Wave | None:
    force = system.forces[number]
    if force.law.wave is None:
        return None
    order, frequency_hz, pushes = force.law.wave(np.array(force.parameters), speed_rad_s)
    rate = order * speed_rad_s + 2 * math.pi * frequency_hz
    directions = system.force_directions[:, system.outputs[number]]
    lane = Spinning(speed_rad_s, rate, 1)
    moved = responses([system], [lane], system.probe_directions, directions)[0, 1 if rate else 0] @ pushes
    derivatives = [("displacement", "velocity", "acceleration").index(probe.quantity) for probe in system.probes]
    return Wave(order, frequency_hz, moved * (1j * rate) ** np.array(derivatives))
