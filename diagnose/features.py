"""The feature vector of a recording: named, documented, with units."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .faults.bearing import rhythms, strongest
from .gear_average import gear_averages
from .gear_spacing import gear_spacing
from .observe import Observation
from .signal.sidebands import find_sidebands
from .slow_whirl import slow_whirl


@dataclass(frozen=True)
class Feature:
    """One entry of the vector: its name, unit and meaning."""

    name: str
    unit: str
    meaning: str


_ORDERS = (1 / 3, 0.5, 2 / 3, 1.0, 1.5, 2.0, 2.5, 3.0)
_ORDER_KEYS = ("third_x", "half_x", "two_thirds_x", "1x", "1.5x", "2x", "2.5x", "3x")
_BEARING_KEYS = {"BPFO": "outer_race", "BPFI": "inner_race", "2BSF": "ball", "FTF": "cage"}

FEATURES: tuple[Feature, ...] = (
    Feature("speed", "Hz", "shaft speed"),
    Feature("rms", "SI", "rms of the loudest channel, in its SI unit (as stored where unknown)"),
    Feature("peak", "SI", "largest absolute value of the loudest channel"),
    Feature("crest_factor", "1", "peak over rms, largest of the channels"),
    Feature("kurtosis", "1", "fourth standardised moment (3 for a Gaussian), largest of the channels"),
    Feature("skewness", "1", "third standardised moment of largest magnitude over the channels"),
    *(Feature(f"{key}_amplitude", "SI", f"peak amplitude at {key}, largest of the channels") for key in _ORDER_KEYS),
    *(
        Feature(f"{key}_signal_to_noise", "1", f"amplitude at {key} over the noise floor, largest")
        for key in _ORDER_KEYS
    ),
    Feature("1x_velocity_share", "1", "share of 1X in the radial velocity energy, median of the channels"),
    Feature("2x_3x_velocity_share", "1", "share of 2X and 3X in the radial velocity energy, median"),
    Feature("1x_phase", "deg", "lead of 1X on the first radial channel over the tacho pulse; NaN without a tacho"),
    Feature("1x_phase_difference", "deg", "phase of 1X on the second radial channel minus the first, -180 to 180"),
    Feature("sub_synchronous_share", "1", "share of 0.2X-0.8X in the velocity energy, largest of the channels"),
    Feature("axial_over_radial", "1", "1X-3X level of the axial over the radial channels; NaN without directions"),
    *(
        Feature(
            f"{key}_{what}",
            "1",
            f"envelope: {meaning} at {label}, best band and channel; NaN without geometry",
        )
        for label, key in _BEARING_KEYS.items()
        for what, meaning in (
            ("modulation", "modulation depth of the harmonics and sidebands"),
            ("signal_to_noise", "first harmonic over the noise floor"),
            ("sidebands", "number of significant sidebands"),
        )
    ),
    *(
        Feature(
            f"mesh_{harmonic}_signal_to_noise",
            "1",
            f"tooth-mesh harmonic {harmonic} over the noise floor, largest",
        )
        for harmonic in (1, 2, 3)
    ),
    Feature("mesh_modulation_index", "1", "first sidebands over the mesh line, largest over shafts and channels"),
    Feature("gear_fm4", "1", "kurtosis of the difference signal of a gear's synchronous average, largest; 3 is noise"),
    Feature("gear_na4", "1", "kurtosis of the residual signal of a gear's synchronous average, largest; 3 is noise"),
    Feature(
        "gear_spacing_ratio",
        "1",
        "cepstral peak over noise where the lines are spaced by a gear's speed, largest of the channels; 0 where not",
    ),
    Feature(
        "sub_synchronous_whirl",
        "1",
        "whirl of the strongest line of 0.3X-0.6X: -1 backward circle, 0 straight line, 1 forward; NaN without probes",
    ),
    Feature("band_low_share", "1", "share of 0.5X-10X in the energy, loudest channel"),
    Feature("band_middle_share", "1", "share of 10X-50X in the energy, loudest channel"),
    Feature("band_high_share", "1", "share above 50X in the energy, loudest channel"),
)


def feature_names() -> tuple[str, ...]:
    """Return the names of the vector, in order."""
    return tuple(feature.name for feature in FEATURES)


def features(observation: Observation) -> dict[str, float]:
    """Return the feature vector of an observation; NaN where the record cannot say.

    Parameters
    ----------
    observation : Observation

    Returns
    -------
    dict of str to float
        Every name of ``FEATURES``, in order.
    """
    values: dict[str, float] = dict.fromkeys(feature_names(), float("nan"))
    if not observation.channel_count:
        return values
    values |= _time_statistics(observation.recording.signals)
    if observation.speed is not None and observation.turning:
        for part in (_orders, _shares, _bands, _bearings, _mesh):
            values |= part(observation)
    return values


def _time_statistics(signals: np.ndarray) -> dict[str, float]:
    rms = np.sqrt(np.einsum("ij,ij->i", signals, signals) / signals.shape[1])
    safe = np.maximum(rms, np.finfo(float).tiny)
    standard = signals / safe[:, None]
    square = standard * standard
    peak = np.abs(signals).max(axis=1)
    loudest = int(np.argmax(rms))
    skewness = np.einsum("ij,ij->i", square, standard) / signals.shape[1]
    return {
        "rms": float(rms[loudest]),
        "peak": float(peak[loudest]),
        "crest_factor": float((peak / safe).max()),
        "kurtosis": float((np.einsum("ij,ij->i", square, square) / signals.shape[1]).max()),
        "skewness": float(skewness[int(np.argmax(np.abs(skewness)))]),
    }


def _orders(now: Observation) -> dict[str, float]:
    values = {"speed": now.speed_hz}
    for order, key in zip(_ORDERS, _ORDER_KEYS, strict=True):
        if order * now.speed_hz > now.spectrum.frequency_hz[-2]:
            continue
        lines = [now.line(order, channel=channel) for channel in range(now.channel_count)]
        values[f"{key}_amplitude"] = max(line.amplitude for line in lines)
        values[f"{key}_signal_to_noise"] = max(line.signal_to_noise for line in lines)
    return values


def _shares(now: Observation) -> dict[str, float]:
    from .faults.shaft_lines import shaft_pattern

    one, more, axial = shaft_pattern(now)
    values = {"1x_velocity_share": one, "2x_3x_velocity_share": more}
    if axial is not None:
        values["axial_over_radial"] = axial
    radial = now.radial_channels()
    if now.order_vectors is not None:
        values["1x_phase"] = float(np.degrees(np.angle(now.order_vectors[radial[0], 0])))
    quantities = {now.recording.channels[channel].quantity for channel in radial[:2]}
    if len(radial) > 1 and len(quantities) == 1:
        frequency = now.line(1.0, channel=radial[0]).frequency_hz
        turn = np.exp(-2j * np.pi * frequency * np.arange(now.recording.samples) / now.recording.rate_hz)
        window = np.hanning(now.recording.samples)
        first, second = (now.recording.signals[channel] @ (turn * window) for channel in radial[:2])
        values["1x_phase_difference"] = float(np.degrees(np.angle(second / first))) if first != 0 else float("nan")
    return values


def _bands(now: Observation) -> dict[str, float]:
    frequency = now.spectrum.frequency_hz
    power = now.spectrum.amplitude**2
    loudest = int(np.argmax(power.sum(axis=1)))
    speed = now.speed_hz
    below = np.concatenate([[0.0], np.cumsum(power[loudest])])
    edges = [int(np.searchsorted(frequency, order * speed, "right")) for order in (0.5, 10.0, 50.0)] + [frequency.size]
    shares = np.diff(below[edges]) / max(float(below[-1] - below[edges[0]]), 1e-300)
    values = {f"band_{name}_share": float(one) for name, one in zip(("low", "middle", "high"), shares, strict=True)}
    first, last = (
        int(np.searchsorted(frequency, 0.2 * speed, "right")),
        int(np.searchsorted(frequency, max(1000.0, 10 * speed))),
    )
    inside, slow = frequency[first:last], int(np.searchsorted(frequency, 0.8 * speed)) - first
    shares = []
    for channel in range(now.channel_count):
        velocity = (now.spectrum.amplitude[channel, first:last] * now.velocity_factor(channel, inside)) ** 2
        shares.append(float(velocity[:slow].sum() / max(velocity.sum(), 1e-300)))
    values["sub_synchronous_share"] = max(shares)
    whirl = slow_whirl(now)
    if whirl is not None:
        values["sub_synchronous_whirl"] = whirl
    return values


def _bearings(now: Observation) -> dict[str, float]:
    values: dict[str, float] = {}
    for bearing in now.recording.nameplate.bearings:
        for rhythm in rhythms(bearing):
            key = _BEARING_KEYS[rhythm.label]
            found = strongest(now, rhythm, [])
            depth = 0.0 if found is None else found.depth
            if depth < values.get(f"{key}_modulation", -1.0):
                continue
            combs = [] if found is None else [line for line in found.lines if line.expected_order is not None]
            values[f"{key}_modulation"] = depth
            values[f"{key}_signal_to_noise"] = max((line.signal_to_noise for line in combs), default=0.0)
            values[f"{key}_sidebands"] = 0.0 if found is None else float(len(found.lines) - len(combs))
    return values


def _mesh(now: Observation) -> dict[str, float]:
    values: dict[str, float] = {}
    for gear in now.recording.nameplate.gears:
        for harmonic in (1, 2, 3):
            carrier = harmonic * gear.mesh_order * now.speed_hz
            if carrier > 0.9 * now.spectrum.frequency_hz[-1]:
                continue
            for channel in range(now.channel_count):
                for ratio in (gear.driver_ratio, gear.driven_ratio):
                    if ratio is None:
                        continue
                    family = find_sidebands(
                        now.spectrum,
                        channel=channel,
                        carrier_hz=carrier,
                        modulator_hz=ratio * now.speed_hz,
                        pairs=1,
                    )
                    key = f"mesh_{harmonic}_signal_to_noise"
                    values[key] = max(values.get(key, 0.0), float(np.sqrt(family.carrier.power_ratio)))
                    if family.carrier.power_ratio > now.significant_ratio:
                        best = values.get("mesh_modulation_index", 0.0)
                        values["mesh_modulation_index"] = max(best, family.modulation_index)
    averages = [one.indicators for one in gear_averages(now)]
    if now.recording.nameplate.gears:
        spacing = gear_spacing(now)
        values["gear_spacing_ratio"] = 0.0 if spacing is None else spacing.power_ratio
    if averages:
        values["gear_fm4"] = max(one.fm4 for one in averages)
        values["gear_na4"] = max(one.na4 for one in averages)
    return values
