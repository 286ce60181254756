"""The rhythm of a bearing defect in one envelope: its lines, whose else they may be, and what they say together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .observe import Observation
from .result import Line
from .signal.envelope import EnvelopeSpectrum
from .signal.spectrum import peak_near

_SLIP_SPREAD = 0.01
EVEN_DEPTH = 0.4  # modulation depth at which a defect is as likely as not: a third or so of the energy in impacts
STEEPNESS = 5.0
# Impacts repeat in harmonics; the variable compliance of a healthy bearing is nearly a sine.
_HARMONICS_FACTOR = {0: 0.5, 1: 0.5, 2: 1.0, 3: 1.5}
_SHAFT_ALONE = 3.0  # times the lower multiples of a shaft: higher ones alone are not made once a turn


@dataclass(frozen=True)
class DefectRhythm:
    """The lines that one defect of one bearing makes in the envelope: a comb, with sidebands at a modulator."""

    fault: str
    label: str
    order: float
    modulator: float | None


@dataclass(frozen=True)
class RhythmEvidence:
    """The best band's answer for one rhythm."""

    rhythm: DefectRhythm
    envelope: EnvelopeSpectrum
    depth: float
    frequency_hz: float
    expected_hz: float
    lines: tuple[Line, ...]
    harmonics_seen: int
    shared_with_shaft: bool = False

    @property
    def odds(self) -> float:
        """Odds of a defect: depth, harmonics, and nearness to the kinematic order (slip spread 1 % against any)."""
        slip = self.frequency_hz / self.expected_hz - 1.0
        nearness = 1.6 * np.exp(-0.5 * (slip / _SLIP_SPREAD) ** 2)
        return defect_odds(self.depth) * _HARMONICS_FACTOR[self.harmonics_seen] * float(nearness)


def defect_odds(depth: float) -> float:
    """Return the odds of a defect for a modulation depth, (depth/0.4)^5."""
    return (max(depth, 1e-6) / EVEN_DEPTH) ** STEEPNESS


def shaft_ratios(now: Observation) -> list[float]:
    """Return the speeds of all known shafts over the reference speed: a broken tooth strikes at its own shaft's."""
    ratios = [1.0]
    for gear in now.recording.nameplate.gears:
        ratios += [ratio for ratio in (gear.driver_ratio, gear.driven_ratio) if ratio is not None]
    return list(dict.fromkeys(ratios))


def envelope_line(
    now: Observation,
    envelope: EnvelopeSpectrum,
    frequency_hz: float,
    name: str,
    rhythm: DefectRhythm,
    harmonic: int | None,
) -> Line | None:
    """Return the line of an envelope at a place, of whatever height; None on the skirt of a stronger one."""
    spectrum = envelope.spectrum
    if not 2 * spectrum.resolution_hz < frequency_hz < spectrum.frequency_hz[-3]:
        return None
    frequency, depth, floor = peak_near(spectrum, 0, frequency_hz, tolerance_hz=1.2 * spectrum.resolution_hz)
    middle = round(frequency / spectrum.resolution_hz)
    if depth < spectrum.amplitude[0, max(middle - 2, 0) : middle + 3].max():
        return None  # the skirt of a stronger line
    expected = None if harmonic is None else harmonic * rhythm.order
    channel = now.recording.channels[envelope.channel].name
    return Line(
        name,
        channel,
        frequency,
        frequency / now.speed_hz,
        depth,
        floor,
        "modulation",
        "envelope",
        None,
        expected,
    )


def on_shaft(now: Observation, envelope: EnvelopeSpectrum, frequency_hz: float) -> bool:
    """Return whether a line cannot be told from a multiple of a shaft's speed."""
    speed = now.speed
    assert speed is not None
    doubt = min(_relative_doubt(now) * frequency_hz, envelope.spectrum.resolution_hz)
    for ratio in shaft_ratios(now):
        shaft = ratio * speed.speed_hz
        multiple = round(frequency_hz / shaft)
        if multiple >= 1 and abs(frequency_hz - multiple * shaft) < 0.7 * envelope.spectrum.resolution_hz + doubt:
            return True
    return False


def alone(now: Observation, envelope: EnvelopeSpectrum, line: Line) -> bool:
    """Return whether a line at 3X or more towers over the lower multiples, which anything once a turn would make."""
    multiple = round(line.frequency_hz / now.speed_hz)
    tolerance = 1.2 * envelope.spectrum.resolution_hz
    lower = [
        peak_near(envelope.spectrum, 0, times * now.speed_hz, tolerance_hz=tolerance)[1] for times in range(1, multiple)
    ]
    single = len(shaft_ratios(now)) == 1
    return single and multiple >= 3 and line.amplitude > _SHAFT_ALONE * max(lower)


def of_another(now: Observation, envelope: EnvelopeSpectrum, frequency_hz: float, taken: list[RhythmEvidence]) -> bool:
    """Return whether a line is part of a deeper rhythm's family."""
    resolution = envelope.spectrum.resolution_hz
    for other in taken:
        for harmonic in range(0, 7):
            remainder = abs(frequency_hz - harmonic * other.frequency_hz)
            shafts = round(remainder / now.speed_hz)
            close = abs(remainder - shafts * now.speed_hz) < resolution * 1.5 + _relative_doubt(now) * remainder
            if close and shafts <= 3 and (harmonic or shafts):
                return True
    return False


def _relative_doubt(now: Observation) -> float:
    speed = now.speed
    assert speed is not None
    return (speed.high_hz - speed.low_hz) / 4 / speed.speed_hz
