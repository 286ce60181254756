"""Features that do not depend on gain, sampling rate, length of the record or nominal speed.

Lines are taken against the noise in one order around them, power_line / power_noise(1 order), which a longer record
does not change; depths and shares are ratios already. What is left of a machine are its own resonances and its noise,
and those are what training draws at random.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..faults.bearing import RhythmEvidence, rhythms, shaft_ratios, strongest
from ..features import _BEARING_KEYS, _ORDER_KEYS, _ORDERS, features
from ..observe import Observation
from ..signal.spectrum import Spectrum, peak_near

#: Entries of ``features.FEATURES`` that are ratios already, and how they are scaled: "log" or "as is".
_TAKEN = {
    "crest_factor": "log",
    "kurtosis": "log",
    "skewness": "as is",
    "1x_velocity_share": "as is",
    "2x_3x_velocity_share": "as is",
    "sub_synchronous_share": "as is",
    "axial_over_radial": "log",
    "mesh_modulation_index": "as is",
    "gear_fm4": "log",
    "gear_na4": "log",
}
_HARMONICS = ("half_x", "2x", "3x")
_SMALLEST = 1e-6


def relative_feature_names() -> tuple[str, ...]:
    """Return the names, in order."""
    bearing = [f"{key}_{what}" for key in _BEARING_KEYS.values() for what in ("depth", "harmonics", "slip", "contrast")]
    return (
        *_TAKEN,
        *(f"{key}_contrast" for key in _ORDER_KEYS),
        *(f"{key}_over_1x" for key in _HARMONICS),
        "phase_difference_cos",
        "phase_difference_sin",
        *bearing,
        "deepest_rhythm_share",
        "envelope_shaft_depth",
        "envelope_other_depth",
    )


def relative_features(observation: Observation, *, measured: Mapping[str, float] | None = None) -> dict[str, float]:
    """Return the features of a recording; NaN where it cannot say.

    Parameters
    ----------
    observation : Observation
    measured : mapping of str to float, optional
        `features` of the same observation, where it is at hand.

    Returns
    -------
    dict of str to float
        Every name of `relative_feature_names`, in order: logarithms to base 10 of contrasts and ratios, depths of
        modulation as they are.
    """
    values = dict.fromkeys(relative_feature_names(), float("nan"))
    if not observation.channel_count or observation.speed is None or not observation.turning:
        return values
    given = features(observation) if measured is None else measured
    for name, scale in _TAKEN.items():
        values[name] = _log(given[name]) if scale == "log" else abs(given[name])
    for key in _ORDER_KEYS:
        values[f"{key}_contrast"] = _contrast(given[f"{key}_signal_to_noise"], observation)
    for key in _HARMONICS:
        values[f"{key}_over_1x"] = _log(given[f"{key}_amplitude"] / max(given["1x_amplitude"], 1e-300))
    angle = np.radians(given["1x_phase_difference"])
    values["phase_difference_cos"], values["phase_difference_sin"] = float(np.cos(angle)), float(abs(np.sin(angle)))
    return values | _rhythms(observation) | _other_envelope_lines(observation)


def level_names() -> tuple[str, ...]:
    """Return the names of `levels`, in order."""
    return tuple(f"{key}_level" for key in _ORDER_KEYS)


def levels(observation: Observation) -> dict[str, float]:
    """Return log10 of the loudest channel's amplitude at each order, never below its noise; NaN without a speed.

    Levels depend on gain and machine: only their change against a healthy record of the same machine is a feature.
    """
    values = dict.fromkeys(level_names(), float("nan"))
    if not observation.channel_count or observation.speed is None or not observation.turning:
        return values
    for order, key in zip(_ORDERS, _ORDER_KEYS, strict=True):
        if order * observation.speed_hz > observation.spectrum.frequency_hz[-2]:
            continue
        lines = [observation.line(order, channel=channel) for channel in range(observation.channel_count)]
        values[f"{key}_level"] = float(np.log10(max(max(line.amplitude, line.noise_floor, 1e-300) for line in lines)))
    return values


def _log(value: float) -> float:
    return float(np.log10(max(value, _SMALLEST))) if np.isfinite(value) else float("nan")


def _contrast(signal_to_noise: float, now: Observation) -> float:
    """Return log10 of line power over noise power in one order; what noise alone would make is the lowest value."""
    if not np.isfinite(signal_to_noise):
        return float("nan")
    power = max(signal_to_noise**2, now.significant_ratio) - 1.0
    return float(np.log10(power / now.turns))


def _rhythms(now: Observation) -> dict[str, float]:
    best: dict[str, RhythmEvidence] = {}
    for bearing in now.recording.nameplate.bearings:
        for rhythm in rhythms(bearing):
            found, key = strongest(now, rhythm, []), _BEARING_KEYS[rhythm.label]
            if found is not None and (key not in best or found.depth > best[key].depth):
                best[key] = found
    values: dict[str, float] = {}
    if not now.recording.nameplate.bearings:
        return values
    for key in _BEARING_KEYS.values():
        one = best.get(key)
        values[f"{key}_depth"] = 0.0 if one is None else min(one.depth, 3.0)
        values[f"{key}_harmonics"] = 0.0 if one is None else float(one.harmonics_seen)
        values[f"{key}_slip"] = 0.0 if one is None else abs(one.frequency_hz / one.expected_hz - 1.0)
        ratio = 0.0 if one is None else max(line.signal_to_noise for line in one.lines)
        values[f"{key}_contrast"] = _contrast(ratio, now)
    depths = sorted((values[f"{key}_depth"] for key in _BEARING_KEYS.values()), reverse=True)
    values["deepest_rhythm_share"] = depths[0] / sum(depths) if depths[0] > 0 else 0.0
    return values


def _other_envelope_lines(now: Observation) -> dict[str, float]:
    """Return how deep the shafts' own orders, and the deepest line that nothing explains, modulate any band."""
    own = [ratio * multiple for ratio in shaft_ratios(now) for multiple in (1, 2, 3)]
    shaft, other = 0.0, 0.0
    for envelope in now.envelopes:
        spectrum = envelope.spectrum
        heights = [_depth_at(envelope.spectrum, order * now.speed_hz) for order in own]
        shaft = max(shaft, float(np.sqrt(np.square(heights).sum())))
        other = max(other, _deepest_unexplained(now, spectrum))
    return {"envelope_shaft_depth": min(shaft, 3.0), "envelope_other_depth": min(other, 3.0)}


def _depth_at(spectrum: Spectrum, frequency_hz: float) -> float:
    if not 2 * spectrum.resolution_hz < frequency_hz < spectrum.frequency_hz[-3]:
        return 0.0
    return peak_near(spectrum, 0, frequency_hz, tolerance_hz=1.2 * spectrum.resolution_hz)[1]


def _deepest_unexplained(now: Observation, spectrum: Spectrum) -> float:
    """Return the depth of the deepest significant line that is no harmonic of a shaft or a bearing's rhythm."""
    frequency, depth, ratio = spectrum.frequency_hz, spectrum.amplitude[0], spectrum.power_ratio[0]
    free = (ratio > now.significant_ratio) & (frequency > 0.2 * now.speed_hz)
    if not free.any():
        return 0.0
    orders = frequency[free] / now.speed_hz
    explained = np.zeros(orders.size, bool)
    for shaft in shaft_ratios(now):
        explained |= abs(orders / shaft - np.round(orders / shaft)) * shaft < 0.06
    for bearing in now.recording.nameplate.bearings:
        for rhythm in rhythms(bearing):
            number = np.maximum(np.round(orders / rhythm.order), 1)
            sides = (0.0,) if rhythm.modulator is None else (-2, -1, 0.0, 1, 2)
            for side in sides:
                wanted = number * rhythm.order + side * (rhythm.modulator or 0.0)
                explained |= abs(orders / np.maximum(wanted, 1e-6) - 1.0) < 0.03
    return float(depth[free][~explained].max()) if (~explained).any() else 0.0
