"""The sidebands of tooth-mesh lines, shaft by shaft, and how they grew against a baseline."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..datasets.recording import Channel, GearPair
from .observe import Observation
from .signal.sidebands import SidebandFamily, find_sidebands

PAIRS = 6
MESH_HARMONICS = (1, 2, 3)
REPEATABILITY_DB = 4.0
_LEAST_SIDEBAND = 1e-4  # of the mesh line, 80 dB below it: no gear is so round that less means anything (a judgement)
_NOT_OF_THE_SERIES = 2.0  # times the first pair: what a shaft modulates once a turn has its strongest pair first


@dataclass(frozen=True)
class Family:
    """The sidebands of one mesh harmonic at one shaft's spacing, on one channel."""

    mesh: int
    wheel: str
    ratio: float
    channel: int
    found: SidebandFamily


def shafts(gear: GearPair) -> list[tuple[str, float]]:
    """Return name and speed ratio of both shafts; of one only when the other's teeth are unknown."""
    found = [(f"{gear.driver_teeth}-tooth gear", gear.driver_ratio)]
    if gear.driven_ratio is not None and abs(gear.driven_ratio / gear.driver_ratio - 1.0) > 1e-6:
        found.append((f"{gear.driven_teeth}-tooth gear", gear.driven_ratio))
    return found


def families(now: Observation, gear: GearPair) -> list[Family]:
    """Return every sideband family of a gear pair."""
    return [
        Family(
            mesh,
            name,
            ratio,
            channel,
            find_sidebands(
                now.spectrum,
                channel=channel,
                carrier_hz=mesh * gear.mesh_order * now.speed_hz,
                modulator_hz=ratio * now.speed_hz,
                pairs=PAIRS,
                significant_ratio=now.significant_ratio,
            ),
        )
        for mesh in MESH_HARMONICS
        if mesh * gear.mesh_order * now.speed_hz < 0.9 * now.spectrum.frequency_hz[-1]
        for channel in range(now.channel_count)
        for name, ratio in shafts(gear)
    ]


@dataclass(frozen=True)
class Growth:
    """Growth in dB of a family's mesh line, and of its first and wider sidebands beyond that of the mesh line.

    A mesh that got louder takes its sidebands along; only what they grow beyond it is modulation. ``size`` is the
    larger of first and wider sidebands over the mesh line.
    """

    family: Family
    mesh: float
    first: float
    wide: float
    size: float


def growth(now: Observation, family: Family, earlier: Family, mesh_before: float, mesh_now: float) -> Growth:
    """Return the growth of a family, whose mesh line was and is so high in the strongest direction at its place."""
    least = _LEAST_SIDEBAND * mesh_before
    old = {side.number: side for side in (earlier.found.carrier, *earlier.found.sidebands)}

    def rises(numbers: range) -> list[float]:
        found = []
        for side in (family.found.carrier, *family.found.sidebands):
            was = old.get(side.number)
            if abs(side.number) not in numbers or was is None:
                continue
            high, low = max(side.amplitude, side.noise_floor, least), max(was.amplitude, was.noise_floor, least)
            rise = 20 * float(np.log10(max(high, 1e-300) / max(low, 1e-300)))
            # A risen floor (a bearing's impacts, cavitation) is no risen sideband.
            found.append(rise if side.power_ratio > now.significant_ratio else min(rise, 0.0))
        return found

    mesh, pair, wide = rises(range(1)), rises(range(1, 2)), rises(range(2, PAIRS + 1))
    louder = max(mesh[0], 0.0) if mesh else 0.0
    # Modulation makes both sidebands; one alone is a line of something else that happens to lie there.
    first = min(float(np.mean(pair)), min(pair) + REPEATABILITY_DB) if pair else 0.0
    # A local defect lifts some sidebands more than others; the lift that scatter alone gives them is taken off.
    several = float(np.percentile(wide, 75)) - 0.67 * REPEATABILITY_DB if len(wide) >= 3 else 0.0
    one, more = _heights(family)
    # Where the following ones are much higher than the first, another shaft, a bearing or twice a turn made them.
    if more > _NOT_OF_THE_SERIES * one:
        several, more = min(several, first), one
    size = max(one, more) / max(mesh_now, 1e-300)
    return Growth(family, mesh[0] if mesh else 0.0, first - louder, several - louder, size)


def _heights(family: Family) -> tuple[float, float]:
    """Return the mean of the first pair, and what the stronger ones of the wider sidebands reach."""
    pair = [side.amplitude for side in family.found.sidebands if abs(side.number) == 1]
    wide = [side.amplitude for side in family.found.sidebands if abs(side.number) > 1]
    return float(np.mean(pair)) if pair else 0.0, float(np.percentile(wide, 75)) if wide else 0.0


def mesh_amplitudes(at: Observation, found: list[Family]) -> dict[tuple[int, int], float]:
    """Return, by mesh harmonic and channel, the mesh line in the strongest direction at the place of the channel.

    Sidebands are measured by it, lest a direction across the tooth force, which shows next to no mesh, makes much of
    nothing.
    """
    channels = at.recording.channels
    return {
        (one.mesh, one.channel): max(
            other.found.carrier.amplitude
            for other in found
            if other.mesh == one.mesh
            and (other.channel == one.channel or _same_place(channels[other.channel], channels[one.channel]))
        )
        for one in found
    }


def _same_place(one: Channel, other: Channel) -> bool:
    return one.location is not None and (one.location, one.quantity) == (other.location, other.quantity)


def local_event(now: Observation, baseline: Observation | None, current: list[Family], earlier: list[Family]) -> float:
    """Return how surely one shaft's modulation is a short event, 0 to 1, from the decay of its new sidebands.

    Sidebands are the Fourier series of the modulation over one turn. Run-out is one sine: even a phase modulation of
    2 rad keeps pairs 2 to 6 at least 11 dB below the first (Bessel functions J1 to J6). A pulse over one to three of
    20 teeth has a sinc for a series: -1 to -7 dB. Sidebands that noise hides may have any height up to visible.
    """
    before = {(one.mesh, one.channel): one for one in earlier}
    told = [_decay(now, one, before.get((one.mesh, one.channel))) for one in current]
    weight = sum(one[1] for one in told)
    return sum(one[0] * one[1] for one in told) / weight if weight > 0 else 0.5


def _decay(now: Observation, family: Family, earlier: Family | None) -> tuple[float, float]:
    """Return how surely one family's new sidebands are those of a short event, and how much that weighs."""
    old = {} if earlier is None else {side.number: side.amplitude for side in earlier.found.sidebands}
    visible = {side.number for side in family.found.sidebands if side.power_ratio > now.significant_ratio}
    seen, hidden, lines = np.zeros(2), np.zeros(2), np.zeros(2)
    for side in family.found.sidebands:
        kind = 0 if abs(side.number) == 1 else 1
        lines[kind] += 1
        # A series goes on from line to line; one that stands alone is a line of something else.
        foreign = kind == 1 and not {side.number - 1, side.number + 1} & visible
        if side.number in visible and not foreign:
            seen[kind] += max(side.amplitude**2 - old.get(side.number, side.noise_floor) ** 2, 0.0)
        else:
            hidden[kind] += side.noise_floor**2 * now.significant_ratio
    if not family.found.sidebands or not lines.all() or not seen.any():
        return 0.5, 0.0
    (first, wide), (first_hidden, wide_hidden) = seen / lines, hidden / lines
    pairs = ((first + first_hidden, wide), (first, wide + wide_hidden))
    decay = np.array([10 * np.log10((high + 1e-300) / (low + 1e-300)) for low, high in pairs])
    local = float(np.mean(1.0 / (1.0 + np.exp(-np.clip((decay + 9.0) / 1.5, -40, 40)))))
    floor = float(np.mean([side.noise_floor for side in family.found.sidebands]))
    return local, float(np.sqrt(seen.sum())) / max(floor, 1e-300)
