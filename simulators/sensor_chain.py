"""A healthy measuring chain: from a simulated machine to a measured record with its tacho.

Without a `SensorChain` the chain is ideal apart from the effects of stage "sensor". With one, each link first does what
the healthy part does and then what is wrong with it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from .errors import InvalidValueError
from .sensor_record import SensorRecord, filtered, resonance, rounded
from .sensor_run import check_seed, random_stream, record_of, run_chain, sensor_effects

if TYPE_CHECKING:
    from .assembly import Probe
    from .machine import Machine
    from .speed_profile import SpeedProfile


@dataclass(frozen=True, kw_only=True)
class SensorChain:
    """A healthy measuring chain. Every part that is left out is ideal.

    Parameters
    ----------
    mounting_hz : float, optional
        Mounted resonance of the accelerometers, of damping ratio ``mounting_damping_ratio``.
    high_pass_hz : float
        First-order high-pass of the AC coupling, -3 dB there; 0 for a chain that keeps the mean.
    pole_hz : float, optional
        First-order low-pass of sensor and amplifier, -3 dB there.
    anti_alias_hz : float, optional
        Butterworth low-pass of order ``anti_alias_order`` (1 to 32), -3 dB there, in front of the converter; on top
        of the simulation's own filter, which is flat up to 0.4 of the output rate.
    noise : mapping of str to float
        One-sided noise density by unit of the channel, in unit/sqrt(Hz): {"m/s2": 3e-4}.
    noise_corner_hz : float
        Below it the density's square rises as 1/f.
    full_scale : mapping of str to float
        Measuring range by unit of the channel, from 0 to its end on both sides; for units left out, the range that
        the record fills about its mean.
    bits : int, optional
        Of the converter, 1 to 32; 2^bits steps from -full_scale to +full_scale.
    pulses_per_revolution : int
        Of the tacho; 0 for none.
    tacho_ratio : float
        Speed of the tacho's shaft over the reference shaft's.
    pulse_width, pulse_jitter : float
        Length of a pulse, and standard deviation of an edge, as a share of the pulses' spacing.
    """

    mounting_hz: float | None = None
    mounting_damping_ratio: float = 0.05
    high_pass_hz: float = 0.0
    pole_hz: float | None = None
    anti_alias_hz: float | None = None
    anti_alias_order: int = 8
    noise: Mapping[str, float] = field(default_factory=dict)
    noise_corner_hz: float = 0.0
    full_scale: Mapping[str, float] = field(default_factory=dict)
    bits: int | None = None
    pulses_per_revolution: int = 0
    tacho_ratio: float = 1.0
    pulse_width: float = 0.3
    pulse_jitter: float = 0.0

    def __post_init__(self) -> None:
        for name in ("mounting_hz", "pole_hz", "anti_alias_hz", "tacho_ratio"):
            _check(name, getattr(self, name), lowest_excluded=0.0)
        for name in ("bits", "anti_alias_order"):
            _check(name, getattr(self, name), lowest=1, highest=32)
        for name in ("mounting_damping_ratio", "high_pass_hz", "noise_corner_hz", "pulses_per_revolution"):
            _check(name, getattr(self, name), lowest=0.0)
        _check("pulse_width", self.pulse_width, lowest=0.01, highest=0.9)
        _check("pulse_jitter", self.pulse_jitter, lowest=0.0, highest=0.1)
        for unit, value in self.noise.items():
            _check(f"noise[{unit!r}]", value, lowest=0.0)
        for unit, value in self.full_scale.items():
            _check(f"full_scale[{unit!r}]", value, lowest_excluded=0.0)

    @property
    def is_random(self) -> bool:
        """Whether the chain draws random numbers, so that a measurement needs a seed."""
        return any(self.noise.values()) or (self.pulse_jitter > 0 and self.pulses_per_revolution > 0)

    def ranged(self, record: SensorRecord) -> SensorRecord:
        """Return the record with the measuring ranges that the chain states."""
        stated = np.array([self.full_scale.get(channel.unit, np.nan) for channel in record.channels])
        own = np.isnan(stated)
        return replace(
            record, full_scale=np.where(own, record.full_scale, stated), middle=np.where(own, record.middle, 0.0)
        )

    def healthy(self, link: str, record: SensorRecord, generator: np.random.Generator) -> SensorRecord:
        """Return the record behind the healthy part at one link."""
        if link == "mounting" and self.mounting_hz is not None:
            rows = [i for i, channel in enumerate(record.channels) if channel.quantity == "acceleration"]
            signals = record.signals.copy()
            period, ratio = 1 / self.mounting_hz, self.mounting_damping_ratio
            signals[rows] = filtered(
                signals[rows], record.rate_hz, lambda f: resonance(f, period_s=period, damping_ratio=ratio)
            )
            return record.with_signals(signals)
        if link == "transducer":
            return record.with_signals(self._transduced(record) + self._noise(record, generator))
        if link == "filter" and self.anti_alias_hz is not None:
            return record.with_signals(filtered(record.signals, record.rate_hz, self._anti_alias))
        if link == "converter":
            return record.with_signals(self._converted(record))
        return record

    def _transduced(self, record: SensorRecord) -> np.ndarray:
        signals, high_pass, pole = record.signals, self.high_pass_hz, self.pole_hz
        if high_pass > 0:
            signals = filtered(
                signals, record.rate_hz, lambda f: 1j * f / (high_pass + 1j * f), mean_over_s=1.0 / high_pass
            )
        if pole is not None:
            signals = filtered(signals, record.rate_hz, lambda f: 1 / (1 + 1j * f / pole))
        return signals

    def _anti_alias(self, frequency_hz: np.ndarray) -> np.ndarray:
        """Return the Butterworth low-pass: poles evenly spread over the left half of a circle."""
        order, share = self.anti_alias_order, 1j * frequency_hz / (self.anti_alias_hz or math.inf)
        poles = np.exp(1j * math.pi * (2 * np.arange(order) + order + 1) / (2 * order))
        transfer = np.ones(frequency_hz.shape, complex)
        for pole in poles:
            transfer /= 1 - share / pole
        return transfer

    def _noise(self, record: SensorRecord, generator: np.random.Generator) -> np.ndarray:
        """Return noise of one-sided density d sqrt(1 + corner / f), shape (channels, samples)."""
        density = np.array([self.noise.get(channel.unit, 0.0) for channel in record.channels])
        if not density.any():
            return np.zeros((len(density), 1))
        from scipy.fft import irfft, rfft

        count = record.signals.shape[1]
        spectrum = rfft(generator.normal(size=(density.size, count)), axis=1)
        frequency = np.fft.rfftfreq(count, 1 / record.rate_hz)
        frequency[0] = frequency[1] if count > 1 else 1.0
        spectrum *= np.sqrt(1 + self.noise_corner_hz / frequency)
        noise = np.asarray(irfft(spectrum, count, axis=1))
        return density[:, None] * math.sqrt(record.rate_hz / 2) * noise

    def _converted(self, record: SensorRecord) -> np.ndarray:
        end, middle = record.full_scale[:, None], record.middle[:, None]
        step = 0.0 if self.bits is None else 2 * end / 2**self.bits
        # A range that is only the record's own is no limit: noise on top of it is not cut.
        stated = np.array([channel.unit in self.full_scale for channel in record.channels])[:, None]
        cut = np.where(stated, np.clip(record.signals, middle - end, middle + end - step), record.signals)
        return rounded(cut, step)

    def tacho(self, record: SensorRecord, generator: np.random.Generator) -> np.ndarray:
        """Return the tacho's logic level, 0 or 1, at each sample of a record, shape (samples,)."""
        turns = record.phase_rad * self.tacho_ratio * self.pulses_per_revolution / (2 * math.pi)
        pulse = np.floor(turns).astype(int)
        first = int(pulse.min()) - 1
        late = self.pulse_jitter * generator.normal(size=int(pulse.max()) - first + 2)
        late = np.clip(late, -0.05, 0.05)
        level = np.zeros(turns.shape)
        # An early edge of the next pulse falls into this one's interval.
        for neighbour in (0, 1):
            since = turns - (pulse + neighbour) - late[pulse + neighbour - first]
            level[(since >= 0) & (since < self.pulse_width)] = 1.0
        return level

    def measure(
        self,
        machine: Machine,
        *,
        speed_rpm: float | SpeedProfile,
        duration_s: float,
        rate_hz: float,
        seed: int | None = None,
        **options: Any,
    ) -> Measurement:
        """Return what this chain records of a machine with its effects.

        Parameters
        ----------
        machine : Machine
        speed_rpm, duration_s, rate_hz
            As in `simulate_batch`, as are further ``options``.
        seed : int, optional
            Required when the chain or an effect is random.
        """
        from .solvers.simulate import simulate_raw

        effects = sensor_effects(machine)
        check_seed(effects, seed)
        if self.is_random and seed is None:
            raise InvalidValueError("seed = None, but the chain has noise or jitter; allowed: 0 or more. Give a seed.")
        case = (machine, speed_rpm)
        raw = simulate_raw([case], duration_s=duration_s, rate_hz=rate_hz, **options)[0]
        samples = math.floor(duration_s * rate_hz + 1e-9)
        record = record_of(raw, machine, output_rate_hz=rate_hz)
        record = run_chain(record, effects, samples=samples, seed=seed, chain=self)
        tacho = self.tacho(record, random_stream(seed or 0, 0, "tacho", 0)) if self.pulses_per_revolution else None
        return Measurement(
            signals=record.signals,
            rate_hz=rate_hz,
            channels=record.channels,
            phase_rad=record.phase_rad,
            speed_rad_s=record.speed_rad_s,
            tacho=tacho,
            notes=raw.notes,
            step_s=raw.step_s,
            errors=raw.errors,
        )


@dataclass(frozen=True)
class Measurement:
    """A measured record.

    Attributes
    ----------
    signals : ndarray (channels, samples)
    rate_hz : float
    channels : tuple of Probe
    phase_rad, speed_rad_s : ndarray (samples,)
        The truth: angle and speed of the reference shaft.
    tacho : ndarray (samples,), optional
        Logic level, 0 or 1.
    notes : tuple of str
    step_s : float
        Integration step.
    errors : ndarray (channels,), optional
        Estimated relative rms error of the motion at each probe, ahead of the chain; None when not asked for.
    """

    signals: np.ndarray
    rate_hz: float
    channels: tuple[Probe, ...]
    phase_rad: np.ndarray
    speed_rad_s: np.ndarray
    tacho: np.ndarray | None
    notes: tuple[str, ...]
    step_s: float
    errors: np.ndarray | None = None


def _check(
    name: str,
    value: float | None,
    *,
    lowest: float = -math.inf,
    highest: float = math.inf,
    lowest_excluded: float = -math.inf,
) -> None:
    if value is None:
        return
    if not (math.isfinite(value) and lowest <= value <= highest and value > lowest_excluded):
        low = f"more than {lowest_excluded:g}" if math.isfinite(lowest_excluded) else f"at least {lowest:g}"
        high = f", at most {highest:g}" if math.isfinite(highest) else ""
        raise InvalidValueError(f"{name} = {value!r}; allowed: {low}{high}. Correct it.")
