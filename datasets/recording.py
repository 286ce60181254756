"""What was measured: signals, channels, operating condition and nameplate, as frozen data."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from ..simulators.rotor_dynamics.rolling_bearing import BearingGeometry
from .errors import InvalidValueError
from .units import SI_UNIT

DIRECTIONS = ("radial", "horizontal", "vertical", "tangential", "axial", "x", "y")


@dataclass(frozen=True)
class Channel:
    """One signal of a recording.

    Parameters
    ----------
    name : str
        Name as the file or the user gives it.
    quantity : str or None
        A key of ``rotorwise.datasets.units.SI_UNIT``; None when the unit is unknown, and then no severity
        is stated. ``"tacho"`` marks a speed-pulse channel.
    location, direction : str or None
        Where the sensor sits; which way it looks (one of ``DIRECTIONS``).
    stored_unit : str or None
        The unit as declared in the file or by the user, before conversion to SI; for messages.
    """

    name: str
    quantity: str | None = None
    location: str | None = None
    direction: str | None = None
    stored_unit: str | None = None

    def __post_init__(self) -> None:
        if self.quantity is not None and self.quantity not in SI_UNIT:
            raise InvalidValueError(
                f"Quantity {self.quantity!r} of channel {self.name!r}; allowed: {', '.join(SI_UNIT)}."
            )
        if self.direction is not None and self.direction not in DIRECTIONS:
            raise InvalidValueError(
                f"Direction {self.direction!r} of channel {self.name!r}; allowed: {', '.join(DIRECTIONS)}."
            )

    @property
    def unit(self) -> str | None:
        """SI unit of the samples; None when the quantity is unknown."""
        return None if self.quantity is None else SI_UNIT[self.quantity]

    @property
    def is_vibration(self) -> bool:
        """Whether the channel carries vibration or sound (or may: unknown units and bare volts count)."""
        return self.quantity in (
            None,
            "acceleration",
            "velocity",
            "displacement",
            "sound_pressure",
            "voltage",
        )


@dataclass(frozen=True)
class OperatingCondition:
    """How the machine ran: nominal speed (a hint, never trusted), load and temperature, where known."""

    speed_rpm: float | None = None
    load: float | None = None
    load_unit: str | None = None
    temperature_celsius: float | None = None

    def __post_init__(self) -> None:
        if self.speed_rpm is not None and not (0 <= self.speed_rpm <= 1e6):
            raise InvalidValueError(f"Speed {self.speed_rpm} rpm; allowed: 0 to 1e6, or leave it out.")


def _check_ratio(ratio: float, what: str) -> None:
    if not (math.isfinite(ratio) and 1e-3 <= ratio <= 1e3):
        raise InvalidValueError(f"Shaft ratio {ratio} of a {what}; allowed: 0.001 to 1000.")


@dataclass(frozen=True)
class MountedBearing:
    """A bearing of the machine and where it sits; ``shaft_ratio`` is its shaft's speed over the reference speed."""

    geometry: BearingGeometry
    location: str | None = None
    shaft_ratio: float = 1.0

    def __post_init__(self) -> None:
        _check_ratio(self.shaft_ratio, "bearing")


@dataclass(frozen=True)
class GearPair:
    """A gear mesh.

    Parameters
    ----------
    driver_teeth : int
        Teeth of the gear on the shaft whose speed is ``driver_ratio`` times the reference speed.
    driven_teeth : int or None
        Teeth of the other gear; None when unknown.
    """

    driver_teeth: int
    driven_teeth: int | None = None
    driver_ratio: float = 1.0

    def __post_init__(self) -> None:
        _check_ratio(self.driver_ratio, "gear")
        for teeth in (self.driver_teeth, self.driven_teeth):
            if teeth is not None and not 4 <= teeth <= 10_000:
                raise InvalidValueError(f"{teeth} teeth on a gear; allowed: 4 to 10000. Check the number of teeth.")

    @property
    def mesh_order(self) -> float:
        """Tooth-mesh frequency over the reference shaft's speed."""
        return self.driver_teeth * self.driver_ratio

    @property
    def driven_ratio(self) -> float | None:
        """Speed of the driven shaft over the reference speed; None when its teeth are unknown."""
        return None if self.driven_teeth is None else self.mesh_order / self.driven_teeth


@dataclass(frozen=True)
class Nameplate:
    """What is known of the machine: bearings, gears, supply, and what ISO 20816-3 asks for.

    Parameters
    ----------
    name : str or None
    bearings : tuple of MountedBearing
    gears : tuple of GearPair
    line_frequency_hz : float or None
        Electrical supply, 50 or 60 Hz as a rule.
    severity_table : str or None
        Name of a zone table of ``rotorwise.diagnose.severity`` (for example ``"iso20816-3-group2"``).
    mounting : str or None
        ``"rigid"`` or ``"flexible"``.
    power_kw, shaft_height_mm : float or None
    magnetic_bearing_clearance_m : float or None
        Smallest radial clearance C_min, for magnetic-bearing zones.
    """

    name: str | None = None
    bearings: tuple[MountedBearing, ...] = ()
    gears: tuple[GearPair, ...] = ()
    line_frequency_hz: float | None = None
    severity_table: str | None = None
    mounting: str | None = None
    power_kw: float | None = None
    shaft_height_mm: float | None = None
    magnetic_bearing_clearance_m: float | None = None

    def __post_init__(self) -> None:
        if self.mounting not in (None, "rigid", "flexible"):
            raise InvalidValueError(f"Mounting {self.mounting!r}; allowed: rigid, flexible.")


@dataclass(frozen=True)
class Provenance:
    """Where a recording came from.

    Attributes
    ----------
    path, reader : str or None
        File and the reader that took it.
    start_sample : int
        Index in the file of the recording's first sample.
    total_samples : int or None
        Samples per channel in the whole file; None when the format does not say without reading it all.
    """

    path: str | None = None
    reader: str | None = None
    start_sample: int = 0
    total_samples: int | None = None


@dataclass(frozen=True, eq=False)
class Recording:
    """Signals sampled together at one rate, in SI units where the unit is known.

    Parameters
    ----------
    signals : numpy.ndarray, shape (channels, samples)
        Finite or not: defects are found by ``rotorwise.diagnose.signal.checks``, not hidden here.
    rate_hz : float
        Sampling rate. There is no default.
    channels : tuple of Channel
    condition, nameplate, label, provenance
        See the classes; all optional.
    warnings : tuple of str
        What the reader or the metadata found suspicious.
    pulses_per_revolution : float
        Of the tacho channel, when there is one.

    Raises
    ------
    InvalidValueError
        On a shape, a rate or a number of channels that does not fit.
    """

    signals: np.ndarray
    rate_hz: float
    channels: tuple[Channel, ...]
    condition: OperatingCondition = field(default_factory=OperatingCondition)
    nameplate: Nameplate = field(default_factory=Nameplate)
    label: str | None = None
    provenance: Provenance = field(default_factory=Provenance)
    warnings: tuple[str, ...] = ()
    pulses_per_revolution: float = 1.0

    def __post_init__(self) -> None:
        if self.signals.ndim != 2 or self.signals.shape[0] != len(self.channels):
            raise InvalidValueError(
                f"Signals of shape {self.signals.shape} with {len(self.channels)} channels; "
                "allowed: shape (channels, samples)."
            )
        if not 1e-3 <= self.rate_hz <= 1e9:
            raise InvalidValueError(f"Sampling rate {self.rate_hz} Hz; allowed: 0.001 to 1e9 Hz.")

    @property
    def samples(self) -> int:
        """Number of samples per channel."""
        return self.signals.shape[1]

    @property
    def duration_s(self) -> float:
        """Length in seconds."""
        return self.samples / self.rate_hz

    def select(self, indices: list[int] | tuple[int, ...]) -> Recording:
        """Return the recording with only these channels, in this order."""
        return replace(
            self,
            signals=self.signals[list(indices)],
            channels=tuple(self.channels[index] for index in indices),
        )


@dataclass(frozen=True, eq=False)
class Campaign:
    """One machine's recordings over speeds and loads, with the healthy ones to compare against, if any."""

    recordings: tuple[Recording, ...]
    baseline: tuple[Recording, ...] = ()
    name: str | None = None
