"""Forces of rolling bearings and gears: trains of short impacts, ball-pass lines and meshing teeth."""

from __future__ import annotations

import numpy as np
from machine import Machine
from rotorwise.datasets.recording import MountedBearing
from structure import Clock, Floats

TURN = 2 * np.pi


def impacts(clock: Clock, samples_at: Floats, sizes: Floats, width_s: float) -> Floats:
    """Half-sine pulses at fractional samples; a pulse shorter than the steps keeps its impulse."""
    width = max(2.0, width_s * clock.fine_rate_hz)
    reach = int(np.ceil(width)) + 1
    out = np.zeros(clock.fine_samples + reach + 2)
    start = np.floor(samples_at).astype(int)
    for step in range(reach + 1):
        place = (start + step - samples_at) / width
        pulse = np.where((place >= 0) & (place <= 1), np.sin(np.pi * np.clip(place, 0, 1)), 0.0)
        np.add.at(out, start + step, sizes * pulse)
    return out[: clock.fine_samples]


def strike_samples(angle: Floats, order: float, rng: np.random.Generator, jitter: float) -> Floats:
    """Fractional samples at which a point passes ``order`` times a turn, with a random slip at each pass."""
    turns = (angle[-1] - angle[0]) / TURN
    count = int(turns * order * 1.05) + 2
    steps = (TURN / order) * (1 + jitter * rng.standard_normal(count))
    at = angle[0] + rng.uniform(0, TURN / order) + np.cumsum(steps)
    return np.interp(at[at < angle[-1]], angle, np.arange(angle.size))


def load_zone(place: Floats, half_width: float) -> Floats:
    """Load on a ball at an angle from the load's direction: (1 - (1 - cos)/(2e))^1.5 inside the zone, else 0."""
    return np.clip(1 - (1 - np.cos(place)) / (1 - np.cos(half_width)), 0.0, None) ** 1.5


def defect(
    machine: Machine, bearing: MountedBearing, part: str, angle: Floats, clock: Clock, rng: np.random.Generator
) -> Floats:
    """Impacts of a local defect on one part, with 1-2 % slip of the cage and a loaded zone."""
    orders, slip = (
        bearing.geometry.defect_orders(),
        1 - machine.details("slip" + str(bearing.location)).uniform(0.01, 0.02),
    )
    cage = orders.cage * slip
    balls = bearing.geometry.balls
    order = {
        "outer_race": balls * cage,
        "inner_race": balls * (1 - cage),
        "ball": 2 * orders.ball_spin * slip,
        "cage": cage,
    }[part]
    at = strike_samples(angle, order, rng, 0.005 if part != "cage" else 0.01)
    turned = np.interp(at, np.arange(angle.size), angle)
    zone = rng.uniform(0.9, 1.6)
    size = np.abs(1 + 0.15 * rng.standard_normal(at.size))
    if part == "inner_race":
        size = size * (0.08 + load_zone(turned, zone))
    elif part == "ball":
        # A ball strikes the two races in turn, not equally hard, and carries load once a turn of the cage.
        size = (
            size * (0.08 + load_zone(cage * turned, zone)) * np.where(np.arange(at.size) % 2, 1.0, rng.uniform(0.5, 1))
        )
    elif part == "cage":
        size = size * np.exp(0.4 * rng.standard_normal(at.size))
    train = impacts(clock, at, size, rng.uniform(0.04e-3, 0.15e-3))
    share = np.array([rng.uniform(0.2, 0.6), 1.0, rng.uniform(0.1, 0.5)])
    force = np.zeros((6, angle.size))
    force[slice(0, 3) if bearing.location == "DE" else slice(3, 6)] = share[:, None] * train
    return force


def ball_pass(machine: Machine, angle: Floats) -> Floats:
    """Variable compliance of sound bearings under load: a smooth force at the ball-pass order and its double."""
    force = np.zeros((6, angle.size))
    for end, bearing in enumerate(machine.bearings):
        slip = 1 - machine.details("slip" + str(bearing.location)).uniform(0.01, 0.02)
        rng = machine.details("ball pass" + str(bearing.location))
        passing = bearing.geometry.balls * bearing.geometry.defect_orders().cage * slip * angle
        tone = np.cos(passing + rng.uniform(0, TURN)) + rng.uniform(0.1, 0.5) * np.cos(2 * passing)
        force[3 * end + 1] = tone
        force[3 * end] = rng.uniform(0.2, 0.6) * tone
    return force


def mesh(machine: Machine, angle: Floats, state: str, size: float, rng: np.random.Generator) -> Floats:
    """Meshing force of a gear pair, sound or not.

    Harmonics of the mesh, modulated in amplitude and phase by each shaft: a few per cent when sound. Wear raises
    the higher harmonics and both modulations; eccentricity the modulation of one shaft; a weak tooth dips the force
    and lags the phase for one mesh a turn.
    """
    assert machine.gear is not None
    assert machine.gear.driven_ratio is not None
    own = machine.details("mesh")
    shafts = (angle, angle * machine.gear.driven_ratio)
    strength = np.array([1.0, own.uniform(0.2, 0.7), own.uniform(0.1, 0.4), own.uniform(0.03, 0.2)])
    depth, lag = own.uniform(0.02, 0.08, 2), own.uniform(0.01, 0.05, 2)
    phases, start = own.uniform(0, TURN, 4), own.uniform(0, TURN, 2)
    which = int(rng.integers(2))
    if state == "gear_wear":
        strength = strength * (1 + size * np.array([0.5, 1.5, 1.5, 2.0]) * rng.uniform(0.6, 1.0, 4))
        depth, lag = depth + 0.1 * size * rng.uniform(0.5, 1, 2), lag + 0.05 * size
    if state == "gear_eccentricity":
        depth[which] += 0.3 * size
        lag[which] += 0.2 * size
    swell = 1 + sum(depth[i] * np.cos(shafts[i] + start[i]) for i in range(2))
    shift = sum(lag[i] * np.sin(shafts[i] + start[i]) for i in range(2))
    if state == "gear_tooth_fault":
        teeth = (machine.gear.driver_teeth, machine.gear.driven_teeth)[which] or 1
        place = np.mod(shafts[which] + start[which], TURN) * teeth / TURN
        weak = np.where(place < 1.6, np.sin(np.pi * np.clip(place / 1.6, 0, 1)) ** 2, 0.0)
        swell = swell * (1 - min(0.25 * size, 0.8) * weak)
        shift = shift - 0.3 * size * weak
    turning = machine.gear.driver_teeth * angle + shift
    tone = swell * sum(a * np.cos((k + 1) * turning + p) for k, (a, p) in enumerate(zip(strength, phases, strict=True)))
    share = np.array([0.5, 1.0, 0.25, 0.4, 0.8, 0.2])
    return share[:, None] * tone


def tooth_strikes(machine: Machine, angle: Floats, clock: Clock, rng: np.random.Generator) -> Floats:
    """One knock a turn of the shaft that carries the broken tooth."""
    assert machine.gear is not None
    assert machine.gear.driven_ratio is not None
    ratio = float(rng.choice([1.0, machine.gear.driven_ratio]))
    at = strike_samples(angle, ratio, rng, 0.0005)
    train = impacts(clock, at, 1 + 0.1 * rng.standard_normal(at.size), 0.1e-3)
    return np.array([0.5, 1.0, 0.25, 0.4, 0.8, 0.2])[:, None] * train


def rattle(angle: Floats, clock: Clock, rng: np.random.Generator) -> Floats:
    """A loose plate next to the machine: irregular knocks, shaken by the machine but not bound to its angle."""
    at = strike_samples(angle, rng.uniform(0.6, 2.5), rng, 0.35)
    at = np.sort(np.clip(at, 0, angle.size - 100))
    train = impacts(clock, at, np.exp(0.7 * rng.standard_normal(at.size)), 0.1e-3)
    return rng.uniform(0.1, 0.8, 6)[:, None] * train
