"""What one recording shows, measured once and shared by every rule: speed, lines with floors, envelopes, checks."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..datasets.recording import MountedBearing, Recording
from ..simulators.errors import InvalidValueError
from .result import Line, SpeedEstimate
from .signal.checks import UNUSABLE, DataCheck, check_channel, check_tacho, repair
from .signal.envelope import EnvelopeSpectrum, demodulation_bands, envelope_spectra
from .signal.order_tracking import angular_resample, order_amplitudes, phase_from_pulses
from .signal.spectrum import PlainSpectrum, Spectrum, peak_near, plain_spectrum, spectrum_with_floor
from .signal.speed import speed_from_tacho, speed_from_vibration

_FALSE_ALARM = 1e-3  # chance that noise alone makes one significant line in a whole recording
_LOWEST_CARRIER_ORDER = 20.0  # below it, envelopes beat between shaft lines instead of showing impacts
TRUSTED_SPEED = 0.5
_LEAST_SAMPLES = 256
_PIECES = 12
_BINS_A_LINE = 8
_STEADY = 1e-3  # relative change of speed below which lines stay sharp, and tacho edges cannot show more
#: Rms, in SI units, that sensors show on a machine at rest; a running machine moves more.
_SENSOR_NOISE = {"acceleration": 0.1, "velocity": 5e-5, "displacement": 5e-7}


@dataclass(frozen=True, eq=False)
class Observation:
    """Everything that the rules look at.

    Attributes
    ----------
    recording : Recording
        Usable vibration channels only, missing samples repaired, offset removed.
    speed : SpeedEstimate or None
    checks : tuple of DataCheck
    spectrum : Spectrum
        All channels; at constant shaft angle where a tacho allows it, on the axis of the mean speed.
    envelopes : tuple of EnvelopeSpectrum
        Every channel in every band; empty without a speed.
    significant_ratio : float
        Power over mean noise power from which a line counts: with it, noise alone makes a significant line among all
        lines tested in one recording out of 1000.
    lines_tested : int
    order_tracked : bool
    state : str
        ``"turning"``; ``"at rest"``: no line, and no more than sensor noise; ``"varying speed"``: lines that move
        within the record and no tacho to follow them; ``"no rotation seen"``; ``"no sensor"``: no usable channel.
    order_vectors : numpy.ndarray or None
        Complex amplitudes of 1X, 2X and 3X against the tacho, shape (channels, 3); None without a tacho.
    zone : str or None
        Worst severity zone of the recording, where one could be stated.
    """

    recording: Recording
    speed: SpeedEstimate | None
    checks: tuple[DataCheck, ...]
    spectrum: Spectrum
    envelopes: tuple[EnvelopeSpectrum, ...]
    significant_ratio: float
    lines_tested: int
    order_tracked: bool
    state: str
    order_vectors: np.ndarray | None = None
    zone: str | None = None

    @property
    def turning(self) -> bool:
        """Whether the record shows a machine turning steadily enough to name lines."""
        return self.state == "turning"

    @property
    def turns(self) -> float:
        """Length of the record in turns of the shaft; NaN without a speed."""
        return self.recording.samples / self.recording.rate_hz * self.speed_hz

    @property
    def speed_hz(self) -> float:
        """Shaft speed in Hz; NaN when unknown."""
        return float("nan") if self.speed is None else self.speed.speed_hz

    @property
    def channel_count(self) -> int:
        """Number of channels."""
        return len(self.recording.channels)

    def radial_channels(self) -> list[int]:
        """Return the channels that are not declared axial; all of them when every one is."""
        radial = [i for i, channel in enumerate(self.recording.channels) if channel.direction != "axial"]
        return radial or list(range(self.channel_count))

    def axial_channels(self) -> list[int]:
        """Return the channels that are declared axial."""
        return [i for i, channel in enumerate(self.recording.channels) if channel.direction == "axial"]

    def line(self, order: float, *, channel: int, name: str | None = None, tolerance_bins: float = 1.0) -> Line:
        """Return the spectral line at an order of the shaft speed, one channel."""
        tolerance = tolerance_bins * self.spectrum.resolution_hz + self.speed_doubt_hz(order)
        return self.line_at(
            order * self.speed_hz, channel=channel, name=name or order_name(order), tolerance_hz=tolerance
        )

    def speed_doubt_hz(self, order: float) -> float:
        """Return the standard deviation of the place of an order that comes from the speed; 0 at constant angle."""
        speed = self.speed
        assert speed is not None
        return 0.0 if self.order_tracked else order * (speed.high_hz - speed.low_hz) / 4

    def line_at(self, frequency_hz: float, *, channel: int, name: str, tolerance_hz: float) -> Line:
        """Return the highest line within a tolerance of a frequency, one channel; amplitude 0 beyond the spectrum."""
        if frequency_hz - tolerance_hz > self.spectrum.frequency_hz[-2]:
            unit = self.recording.channels[channel].unit
            name_there = self.recording.channels[channel].name
            return Line(name, name_there, frequency_hz, frequency_hz / self.speed_hz, 0.0, 1.0, unit)
        found, amplitude, floor = peak_near(self.spectrum, channel, frequency_hz, tolerance_hz=tolerance_hz)
        about = self.recording.channels[channel]
        return Line(name, about.name, found, found / self.speed_hz, amplitude, floor, about.unit)

    def is_significant(self, line: Line) -> bool:
        """Whether a line stands out of the noise, all lines tested considered."""
        return line.signal_to_noise**2 > self.significant_ratio

    def velocity_factor(self, channel: int, frequency_hz: float | np.ndarray) -> float | np.ndarray:
        """Return what turns an amplitude of this channel at a frequency into velocity (shares only, if unit unknown).

        A channel of unknown quantity is taken as an accelerometer: good for comparing lines, not for levels.
        """
        quantity = self.recording.channels[channel].quantity
        omega = 2 * np.pi * np.maximum(frequency_hz, 1e-3)
        if quantity == "velocity":
            return np.ones_like(omega) if isinstance(omega, np.ndarray) else 1.0
        if quantity == "displacement":
            return omega
        return 1.0 / omega

    def velocity_share(self, order: float, *, channel: int) -> float:
        """Return the share of one order's line in the velocity energy from 0.3X to 1000 Hz."""
        frequency = self.spectrum.frequency_hz
        low = max(0.3 * self.speed_hz, 2.5 * self.spectrum.resolution_hz)
        first, last = (
            np.searchsorted(frequency, low),
            np.searchsorted(frequency, max(1000.0, 10 * self.speed_hz), "right"),
        )
        inside = slice(int(first), int(last))
        weighted = self.spectrum.amplitude[channel, inside] * self.velocity_factor(channel, frequency[inside])
        total = float((weighted**2).sum()) / 1.5  # a Hann line spreads over 1.5 bins of power
        line = self.line(order, channel=channel)
        return min(
            1.0,
            (line.amplitude * float(self.velocity_factor(channel, line.frequency_hz))) ** 2 / max(total, 1e-300),
        )


def order_name(order: float) -> str:
    """Return the usual name of an order, such as 1X, 2.5X or 1/3X."""
    for text, value in (("1/3", 1 / 3), ("2/3", 2 / 3), ("4/3", 4 / 3), ("5/3", 5 / 3)):
        if abs(order - value) < 1e-6:
            return f"{text}X"
    return f"{order:g}X"


def observe(recording: Recording) -> Observation:
    """Measure one recording of moderate length (one block).

    Parameters
    ----------
    recording : Recording
        With at least one vibration channel; tacho channels are used for the speed.

    Returns
    -------
    Observation
    """
    usable, checks = _usable(recording)
    if recording.samples < _LEAST_SAMPLES:
        raise InvalidValueError(
            f"Record of {recording.samples} samples; allowed: {_LEAST_SAMPLES} or more. Give a longer record."
        )
    speed, times = _tacho_speed(recording)
    checks += _tacho_check(recording, times)
    bearings = tuple(
        order * one.shaft_ratio
        for one in recording.nameplate.bearings
        for order in (one.geometry.defect_orders().outer_race, one.geometry.defect_orders().inner_race)
    )
    meshes = tuple(gear.mesh_order for gear in recording.nameplate.gears if gear.mesh_order < 60)
    hint = recording.condition.speed_rpm or None  # 0 is how some files say that nobody filled it in
    # Speed, lines and the question whether there are any look at the same spectrum.
    plain = plain_spectrum(usable.signals, rate_hz=usable.rate_hz) if usable.channels else None
    if speed is None and usable.channels:
        speed = speed_from_vibration(
            usable.signals,
            rate_hz=usable.rate_hz,
            hint_hz=None if hint is None else hint / 60.0,
            known_orders=meshes,
            bearing_orders=bearings,
            plain=plain,
        )
    is_doubtful = speed is not None and speed.method != "tacho" and speed.confidence < TRUSTED_SPEED
    if is_doubtful and not _has_lines(usable, plain):
        speed = None  # a chance peak of noise is no comb
    state = "turning" if speed is not None or _has_lines(usable, plain) else _state_without_lines(recording, usable)
    if state == "turning" and hint and (speed is None or speed.confidence < TRUSTED_SPEED):
        speed = SpeedEstimate(hint / 60, hint / 60 * 0.97, hint / 60 * 1.03, 0.3, "hint only")
    phase = None if speed is None or times is None else _shaft_angle(usable, times, recording.pulses_per_revolution)
    tracked, order_tracked = _order_tracked(usable, speed, phase)
    observation = _measure(tracked, speed, tuple(checks), order_tracked, state, None if order_tracked else plain)
    # With several pulses a turn, which of them came first is chance, and so would be the phase.
    if phase is None or not usable.channels or recording.pulses_per_revolution != 1:
        return observation
    vectors, _ = order_amplitudes(usable.signals, phase_turns=phase, orders=[1.0, 2.0, 3.0])
    return replace(observation, order_vectors=vectors)


def _shaft_angle(recording: Recording, times: np.ndarray, pulses_per_revolution: float) -> np.ndarray | None:
    """Return the shaft angle in turns at every sample; None where false pulses make it fall."""
    phase = phase_from_pulses(
        times, samples=recording.samples, rate_hz=recording.rate_hz, pulses_per_revolution=pulses_per_revolution
    )
    return None if np.any(np.diff(phase) <= 0) else phase


def _tacho_check(recording: Recording, times: np.ndarray | None) -> list[DataCheck]:
    """Say so when a declared tacho gives no speed, or only after pulses were put right."""
    names = [channel.name for channel in recording.channels if channel.quantity == "tacho"]
    if not names:
        return []
    if times is not None:
        signal = recording.signals[[channel.name for channel in recording.channels].index(names[0])]
        return check_tacho(repair(signal), rate_hz=recording.rate_hz, name=names[0])
    message = f"{names[0]}: no pulse train in the tacho channel; the speed comes from elsewhere. Check --tacho."
    return [DataCheck("tacho", names[0], message, 0.3)]


def _state_without_lines(recording: Recording, usable: Recording) -> str:
    """Return why no line stands out of the whole record."""
    silent_tacho = any(channel.quantity == "tacho" for channel in recording.channels)
    if not usable.channels:
        return "at rest" if silent_tacho else "no sensor"
    rms = np.sqrt((usable.signals**2).mean(axis=1))
    floors = [_SENSOR_NOISE.get(channel.quantity or "", 0.0) for channel in usable.channels]
    if silent_tacho or bool((rms < floors).all()):
        return "at rest"
    pieces = np.array_split(usable.signals, _PIECES, axis=1)
    if usable.samples >= 512 * _PIECES:
        with_lines = sum(_has_lines(replace(usable, signals=piece)) for piece in pieces)
        if with_lines >= _PIECES // 2:
            return "varying speed"
    return "no rotation seen"


def _usable(recording: Recording) -> tuple[Recording, list[DataCheck]]:
    checks: list[DataCheck] = []
    kept: list[int] = []
    for index, channel in enumerate(recording.channels):
        if not channel.is_vibration:
            continue
        found = check_channel(recording.signals[index], rate_hz=recording.rate_hz, name=channel.name)
        checks += found
        if not any(check.code in UNUSABLE for check in found):
            kept.append(index)
    part = recording.select(kept)
    signals = np.stack([repair(row) for row in part.signals]) if kept else np.zeros((0, recording.samples))
    if kept:
        signals = signals - signals.mean(axis=1, keepdims=True)
    return replace(part, signals=signals), checks


def _tacho_speed(recording: Recording) -> tuple[SpeedEstimate | None, np.ndarray | None]:
    for index, channel in enumerate(recording.channels):
        if channel.quantity == "tacho":
            found = speed_from_tacho(
                repair(recording.signals[index]),
                rate_hz=recording.rate_hz,
                pulses_per_revolution=recording.pulses_per_revolution,
            )
            if found is not None:
                return found
    return None, None


def _has_lines(recording: Recording, plain: PlainSpectrum | None = None) -> bool:
    """Return whether any channel has a line that noise would make in one recording out of a million."""
    if not recording.channels:
        return False
    spectrum = spectrum_with_floor(recording.signals, rate_hz=recording.rate_hz, floor_width_hz=20.0, plain=plain)
    return bool((spectrum.power_ratio[:, 4:] > np.log(spectrum.power_ratio.size / 1e-6)).any())


def _order_tracked(
    recording: Recording, speed: SpeedEstimate | None, phase: np.ndarray | None
) -> tuple[Recording, bool]:
    """Return the recording resampled to constant shaft angle, where a tacho shows that the speed varies."""
    if speed is None or phase is None or speed.variation < _STEADY or not recording.channels:
        return recording, False
    per_turn = int(recording.rate_hz / speed.speed_hz)
    if per_turn < 8:
        return recording, False
    signals = angular_resample(recording.signals, phase_turns=phase, samples_per_turn=per_turn)
    return replace(recording, signals=signals, rate_hz=per_turn * speed.speed_hz), True


def _measure(
    recording: Recording,
    speed: SpeedEstimate | None,
    checks: tuple[DataCheck, ...],
    order_tracked: bool,
    state: str,
    plain: PlainSpectrum | None,
) -> Observation:
    if not recording.channels:
        empty = Spectrum(
            np.linspace(0, 1, 16),
            np.zeros((len(recording.channels), 16)),
            np.ones((len(recording.channels), 16)),
        )
        return Observation(recording, None, checks, empty, (), 1e9, 0, False, state)
    width = 20.0 if speed is None else max(speed.speed_hz, 8.0)
    spectrum = spectrum_with_floor(recording.signals, rate_hz=recording.rate_hz, floor_width_hz=width, plain=plain)
    envelopes = () if speed is None else tuple(_envelopes(recording, speed.speed_hz))
    tested = _lines_tested(recording, spectrum, envelopes, speed)
    return Observation(
        recording,
        speed,
        checks,
        spectrum,
        envelopes,
        float(np.log(tested / _FALSE_ALARM)),
        tested,
        order_tracked,
        state,
    )


def _lines_tested(
    recording: Recording, spectrum: Spectrum, envelopes: tuple[EnvelopeSpectrum, ...], speed: SpeedEstimate | None
) -> int:
    """Return how many bins the rules look at; several bins a line, since each is looked for around its place."""
    plate = recording.nameplate
    per_channel = 60 * _BINS_A_LINE + 2 * 3 * 13 * _BINS_A_LINE * len(plate.gears)
    tested = per_channel * len(recording.channels)
    if speed is not None:
        # The rhythms of a bearing sum up to about twice its balls, with the second harmonic, within 2 % slip each way.
        orders = sum(4.0 * one.geometry.balls * one.shaft_ratio for one in plate.bearings)
        for envelope in envelopes:
            window = 0.04 * orders * speed.speed_hz / envelope.spectrum.resolution_hz
            tested += int(window) + 12 * _BINS_A_LINE * len(plate.bearings)
    return max(tested, 1)


def _envelopes(recording: Recording, speed_hz: float) -> list[EnvelopeSpectrum]:
    fastest = max((_highest_order(one) for one in recording.nameplate.bearings), default=6.0)
    low = _LOWEST_CARRIER_ORDER * speed_hz
    high = 0.49 * recording.rate_hz
    narrowest = 3.0 * fastest * speed_hz
    if high - low < narrowest:
        low = min(low, 0.25 * high)
    bands = demodulation_bands(lowest_hz=low, highest_hz=high, narrowest_hz=narrowest)
    return envelope_spectra(
        recording.signals,
        rate_hz=recording.rate_hz,
        bands=bands,
        highest_line_hz=4.5 * fastest * speed_hz,
        floor_width_hz=max(speed_hz, 8.0),
    )


def _highest_order(bearing: MountedBearing) -> float:
    return bearing.geometry.defect_orders().inner_race * bearing.shaft_ratio
