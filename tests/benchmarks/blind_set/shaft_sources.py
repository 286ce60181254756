"""Forces on the bearings [coordinate, fine sample] from the shaft, the coupling, the motor and the neighbourhood.

Amplitudes are relative: ``blind_cases.py`` scales each source to a vibration level.
"""

from __future__ import annotations

import numpy as np
from machine import Machine
from scipy.signal import butter, sosfilt
from structure import Clock, Floats

TURN = 2 * np.pi


def shaft_angle(rng: np.random.Generator, clock: Clock, speed_hz: float, wander: float) -> Floats:
    """Shaft angle in radians with a slow random change of speed; ``wander`` is its relative peak-to-peak size."""
    time = clock.fine_time_s
    change = sum(
        rng.standard_normal() * np.sin(TURN * rng.uniform(0.05, 0.6) * time + rng.uniform(0, TURN)) for _ in range(4)
    )
    change = change * wander / max(float(np.ptp(change)), 1e-12)
    return TURN * np.cumsum(speed_hz * (1 + change)) / clock.fine_rate_hz + rng.uniform(0, TURN)


def unbalance(machine: Machine, angle: Floats) -> Floats:
    """Turning forces at both ends; how they divide, and their angle, is the rotor's."""
    rng = machine.details("unbalance")
    other, lag = rng.uniform(0.3, 1.0), rng.uniform(0, np.pi)
    force = np.zeros((6, angle.size))
    force[0], force[1] = np.cos(angle), np.sin(angle)
    force[3], force[4] = other * np.cos(angle - lag), other * np.sin(angle - lag)
    force[2] = rng.uniform(0.02, 0.1) * np.cos(angle + 1.0)
    return force


def misalignment(machine: Machine, angle: Floats, rng: np.random.Generator, kind: str) -> Floats:
    """Reaction of a coupling whose stiffness varies over a turn, bent by a fixed offset and a fixed angle.

    A fixed offset d in a stiffness that turns with the shaft, k0 (1 + a1 cos p + a3 cos 3p) plus a two-lobed part
    a2, gives 1X, 2X and 3X in the fixed frame. A fixed angle gives axial motion of the coupling faces and a
    turning moment, opposite at the two bearings.
    """
    uneven, lobed, jaws = rng.uniform(0.1, 0.6), rng.uniform(0.2, 0.9), rng.uniform(0.05, 0.4)
    towards, *phases = rng.uniform(0, TURN, 5)
    force = np.zeros((6, angle.size))
    if kind in ("parallel", "combined"):
        fixed = uneven * np.cos(angle + phases[0]) + jaws * np.cos(3 * angle + phases[1])
        turning = lobed * np.exp(1j * (2 * angle - towards + phases[2]))
        radial = fixed * np.exp(1j * towards) + turning
        lever = rng.uniform(-0.6, 0.1)
        force[0], force[1] = radial.real, radial.imag
        force[3], force[4] = lever * radial.real, lever * radial.imag
        force[2] += 0.15 * radial.real
    if kind in ("angular", "combined"):
        faces = rng.uniform(0.4, 1.0) * np.cos(angle + phases[1])
        faces += lobed * np.cos(2 * angle + phases[2]) + jaws * np.cos(3 * angle + phases[3])
        moment = 0.5 * np.exp(1j * (angle + phases[1])) + 0.5 * lobed * np.exp(1j * (2 * angle + phases[2]))
        force[2] += faces
        force[5] += rng.uniform(0.2, 0.7) * faces
        force[0] += moment.real
        force[1] += moment.imag
        force[3] -= moment.real
        force[4] -= moment.imag
    return force


def bent_shaft(angle: Floats, rng: np.random.Generator) -> Floats:
    """A bow turns with the shaft: 1X at both ends, and bearing faces that wobble axially in opposition."""
    lag, axial, twice = rng.uniform(-0.4, 0.4), rng.uniform(0.7, 2.0), rng.uniform(0.05, 0.35)
    phase = rng.uniform(0, TURN)
    force = np.zeros((6, angle.size))
    force[0], force[1] = np.cos(angle), np.sin(angle)
    force[3], force[4] = np.cos(angle - lag), np.sin(angle - lag)
    wobble = axial * (np.cos(angle + phase) + twice * np.cos(2 * angle + phase))
    force[2], force[5] = wobble, -wobble * rng.uniform(0.7, 1.0)
    return force


def air_gap(machine: Machine, clock: Clock, rng: np.random.Generator, side: float = 0.0) -> Floats:
    """Magnetic pull at twice the supply frequency, optionally with sidebands at the pole-pass frequency."""
    time = clock.fine_time_s
    supply = machine.line_hz * (1 + rng.uniform(-1e-3, 1e-3))
    passing = TURN * machine.poles * machine.slip * 2 * machine.line_hz / machine.poles * time
    pull = (1 + side * np.cos(passing)) * np.cos(TURN * 2 * supply * time + rng.uniform(0, TURN))
    share = machine.details("air gap").uniform(0.3, 1.0, 6) * np.array([1, 1, 0.1, 1, 1, 0.1])
    return share[:, None] * pull


def rotor_bars(machine: Machine, clock: Clock, angle: Floats, rng: np.random.Generator) -> Floats:
    """Broken rotor bars: the turning force breathes at the pole-pass frequency (poles times slip frequency)."""
    passing = TURN * machine.slip * 2 * machine.line_hz * clock.fine_time_s + rng.uniform(0, TURN)
    out = unbalance(machine, angle) * np.cos(passing)
    return out + 0.4 * unbalance(machine, 2 * angle) * np.cos(passing)


def broadband(rng: np.random.Generator, clock: Clock, channels: tuple[int, ...] = (0, 1, 2, 3, 4, 5)) -> Floats:
    """Random forces of rolling, flow and floor: white with a rise towards low frequency."""
    force = np.zeros((6, clock.fine_samples))
    low = butter(1, 60.0, fs=clock.fine_rate_hz, output="sos")
    for channel in channels:
        white = rng.standard_normal(clock.fine_samples)
        force[channel] = white + 8.0 * np.asarray(sosfilt(low, white))
    return force


def lines(clock: Clock, angle: Floats, rng: np.random.Generator, harmonics: int) -> Floats:
    """A tone of a given angle with falling harmonics, on all coordinates with random shares."""
    tone = sum(rng.uniform(0.3, 1.0) / k * np.cos(k * angle + rng.uniform(0, TURN)) for k in range(1, harmonics + 1))
    return rng.uniform(0.1, 1.0, 6)[:, None] * tone


def neighbour(machine: Machine, clock: Clock, rng: np.random.Generator) -> Floats:
    """Another machine through the floor, at its own speed."""
    own = machine.details("neighbour")
    speed = machine.speed_hz * own.choice([0.43, 0.61, 0.77, 0.89, 1.17, 1.38, 2.27]) * own.uniform(0.97, 1.03)
    return lines(clock, shaft_angle(rng, clock, speed, 0.001), own, 2)


def belt(machine: Machine, clock: Clock, angle: Floats, rng: np.random.Generator) -> Floats:
    """A damaged belt: its own turning frequency, below the shaft's, with harmonics."""
    return lines(clock, angle * rng.uniform(0.15, 0.45), rng, 6) * np.array([1, 1, 0.3, 0.3, 0.3, 0.1])[:, None]


def blades(clock: Clock, angle: Floats, rng: np.random.Generator) -> Floats:
    """Blade pass with one harmonic and a faint modulation by the shaft."""
    count = int(rng.integers(3, 10))
    return lines(clock, angle * count, rng, 2) * (1 + 0.1 * np.cos(angle))


def cavitation(clock: Clock, rng: np.random.Generator) -> Floats:
    """Bubbles that collapse at random: a dense train of short random pulses in irregular bursts."""
    time = clock.fine_time_s
    knots = np.arange(0.0, time[-1] + 0.1, 0.05)
    burst = np.exp(0.8 * np.interp(time, knots, rng.standard_normal(knots.size)))
    pulses = rng.standard_normal((6, time.size)) * (rng.random(time.size) < 0.02)
    return pulses * burst * np.array([1, 1, 0.7, 0.2, 0.2, 0.2])[:, None]
