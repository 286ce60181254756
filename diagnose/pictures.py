"""The curves that a report draws, taken from an observation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .faults.bearing import rhythms
from .observe import Observation, order_name
from .order_waves import order_part
from .probe_pair import probe_pair
from .result import Cursor, Curve, Finding, Pictures
from .signal.envelope import EnvelopeSpectrum, most_impulsive
from .signal.spectrum import hann

_MAP_ROWS = 240
_MAP_COLUMNS = 120
_WAVEFORM_SAMPLES = 40_000
_CHANNELS_DRAWN = 8
_ORBIT_TURNS, _LEAST_ORBIT_TURNS = 8, 4


def pictures(now: Observation, baseline: Observation | None, findings: tuple[Finding, ...]) -> Pictures:
    """Return the curves of an observation.

    Parameters
    ----------
    now, baseline : Observation
        The baseline's spectra are drawn behind, where there is one.
    findings : tuple of Finding
        Their envelope lines decide which envelope band is drawn first.
    """
    if not now.channel_count:
        return Pictures()
    return Pictures(
        spectra=_spectra(now),
        envelopes=_envelopes(now, findings),
        waveforms=_waveforms(now),
        baseline_spectra=() if baseline is None else _spectra(baseline),
        cursors=tuple(_cursors(now)),
        order_map=_order_map(now),
        orbit=_orbit(now),
        order_part=order_part(now),
    )


def _spectra(now: Observation) -> tuple[Curve, ...]:
    spectrum = now.spectrum
    return tuple(
        Curve(
            "spectrum",
            spectrum.frequency_hz,
            spectrum.amplitude[index],
            "Hz",
            channel.unit,
            channel.name,
            spectrum.floor[index],
        )
        for index, channel in enumerate(now.recording.channels[:_CHANNELS_DRAWN])
    )


def _envelopes(now: Observation, findings: tuple[Finding, ...]) -> tuple[Curve, ...]:
    """Return per channel the band that the findings rest on, else the most impulsive one."""
    if not now.envelopes:
        return ()
    curves = []
    for index, channel in enumerate(now.recording.channels[:_CHANNELS_DRAWN]):
        envelope = _band_of(now, index, findings) or most_impulsive(list(now.envelopes), index)
        spectrum = envelope.spectrum
        note = (
            f"Envelope of {envelope.low_hz:.0f}-{envelope.high_hz:.0f} Hz, spectral kurtosis {envelope.kurtosis:.1f}; "
            "1 means that the line modulates the whole band."
        )
        curves.append(
            Curve(
                "envelope",
                spectrum.frequency_hz,
                spectrum.amplitude[0],
                "Hz",
                "modulation",
                channel.name,
                spectrum.floor[0],
                note,
            )
        )
    return tuple(curves)


def _band_of(now: Observation, channel: int, findings: tuple[Finding, ...]) -> EnvelopeSpectrum | None:
    name = now.recording.channels[channel].name
    for finding in findings:
        for line in finding.lines:
            if line.spectrum != "envelope" or line.channel != name:
                continue
            for envelope in now.envelopes:
                floor = envelope.spectrum.floor[0]
                index = round(line.frequency_hz / envelope.spectrum.resolution_hz)
                near = floor[max(index - 2, 0) : index + 3]
                # The floor under a line is the fingerprint of the band that it was measured in.
                if envelope.channel == channel and np.any(near == line.noise_floor):
                    return envelope
    return None


def _waveforms(now: Observation) -> tuple[Curve, ...]:
    shown = min(now.recording.samples, _WAVEFORM_SAMPLES)
    time = np.arange(shown) / now.recording.rate_hz
    note = "" if shown == now.recording.samples else f"The first {shown / now.recording.rate_hz:.2g} s."
    return tuple(
        Curve(
            "waveform",
            time,
            now.recording.signals[index, :shown],
            "s",
            channel.unit,
            channel.name,
            None,
            note,
        )
        for index, channel in enumerate(now.recording.channels[:_CHANNELS_DRAWN])
    )


def _cursors(now: Observation) -> list[Cursor]:
    if now.speed is None:
        return []
    speed = now.speed_hz
    cursors = [Cursor("shaft orders", f"{order}X", order * speed) for order in range(1, 11)]
    for bearing in now.recording.nameplate.bearings:
        place = bearing.location or bearing.geometry.designation or "bearing"
        for rhythm in rhythms(bearing):
            cursors += [
                Cursor(f"{rhythm.label} {place}", f"{harmonic} x {rhythm.label}", harmonic * rhythm.order * speed)
                for harmonic in range(1, 5)
            ]
    for gear in now.recording.nameplate.gears:
        for harmonic in (1, 2, 3):
            mesh = harmonic * gear.mesh_order * speed
            prefix = "mesh" if harmonic == 1 else f"{harmonic} x mesh"
            cursors.append(Cursor("tooth mesh", prefix, mesh))
            for ratio in (gear.driver_ratio, gear.driven_ratio):
                if ratio is not None:
                    group = f"sidebands {ratio * speed:.2f} Hz"
                    cursors += [
                        Cursor(group, f"{prefix}{k:+d}", mesh + k * ratio * speed) for k in (-3, -2, -1, 1, 2, 3)
                    ]
    line = now.recording.nameplate.line_frequency_hz
    if line is not None:
        cursors += [Cursor("electrical supply", f"{k} x line", k * line) for k in (1, 2)]
    return [cursor for cursor in cursors if cursor.frequency_hz < now.spectrum.frequency_hz[-1]]


def _order_map(now: Observation) -> dict | None:
    """Return the level over time and order (or frequency, without a speed), first channel."""
    signal = now.recording.signals[0]
    rate = now.recording.rate_hz
    top = 0.49 * rate if now.speed is None else min(20 * now.speed_hz, 0.49 * rate)
    length = int(min(signal.size, max(256, rate * _MAP_ROWS / (2 * top) * 2)))
    if signal.size < 4 * length:
        length = max(signal.size // 4, 64)
    starts = np.linspace(0, signal.size - length, min(_MAP_COLUMNS, max(signal.size // (length // 4), 2))).astype(int)
    window = hann(length)
    columns = np.stack(
        [np.abs(np.fft.rfft((signal[s : s + length] - signal[s : s + length].mean()) * window)) for s in starts]
    )
    frequency = np.fft.rfftfreq(length, 1 / rate)
    kept = frequency <= top
    level = 20 * np.log10(np.maximum(columns[:, kept].T * 2 / window.sum(), 1e-15))
    level = np.maximum(level, level.max() - 80)
    by_order = now.speed is not None
    return {
        "time_s": (starts + length / 2) / rate,
        "order_or_hz": frequency[kept] / (now.speed_hz if by_order else 1.0),
        "level_db": level,
        "axis": "order" if by_order else "Hz",
        "channel": now.recording.channels[0].name,
    }


def _orbit(now: Observation) -> dict | None:
    """Return the orbit of two probes at right angles, a few turns long, and that of its first orders alone."""
    pair = probe_pair(now.recording.channels)
    if pair is None or now.speed is None:
        return None
    shown = min(now.recording.samples, int(_ORBIT_TURNS * now.recording.rate_hz / now.speed_hz))
    part = now.recording.signals[list(pair), :shown]
    names = [now.recording.channels[index].name for index in pair]
    return {"x": part[0], "y": part[1], "unit": "m", "channels": names, "orders": _order_orbits(now, pair, part)}


def _order_orbits(now: Observation, pair: tuple[int, int], part: np.ndarray) -> list[dict]:
    """Return the ellipses of the orders up to 3X that stand out of the noise, with the way they are run through."""
    from .signal.orbit import ellipse, filtered_orbit
    from .signal.order_tracking import constant_speed_phase, order_amplitudes

    orders = [n for n in (1.0, 2.0, 3.0) if any(now.is_significant(now.line(n, channel=index)) for index in pair)]
    turns = part.shape[1] * now.speed_hz / now.recording.rate_hz
    if not orders or turns < _LEAST_ORBIT_TURNS:
        return []
    phase = constant_speed_phase(samples=part.shape[1], rate_hz=now.recording.rate_hz, speed_hz=now.speed_hz)
    amplitudes, _ = order_amplitudes(part, phase_turns=phase, orders=orders)
    found = []
    for order, (x, y) in zip(orders, amplitudes.T, strict=True):
        shape = ellipse(complex(x), complex(y))
        points = filtered_orbit(complex(x), complex(y))
        found.append({"name": order_name(order), "way": shape.words, "x": points[0], "y": points[1]})
    return found


def for_folder(shown: Pictures) -> Pictures:
    """Return the pictures without waveforms and maps and in single precision, so that a folder of files fits."""

    def slim(curves: tuple[Curve, ...]) -> tuple[Curve, ...]:
        return tuple(
            replace(
                curve,
                x=curve.x.astype(np.float32),
                y=curve.y.astype(np.float32),
                noise_floor=None if curve.noise_floor is None else curve.noise_floor.astype(np.float32),
            )
            for curve in curves
        )

    return replace(
        shown,
        spectra=slim(shown.spectra),
        envelopes=slim(shown.envelopes),
        baseline_spectra=(),
        waveforms=(),
        order_map=None,
        order_part=None,
    )
