"""What the user knows about a recording and its machine, from the command line or from a sidecar file."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, fields, replace

from ..simulators.rotor_dynamics.rolling_bearing import BearingGeometry, find_bearing
from .errors import InvalidValueError
from .recording import GearPair, MountedBearing, Nameplate

#: Two statements about one bearing (BPFO + BPFI and a whole number of balls, FTF, BSF) may differ by this
#: much.
_ORDERS_AGREE = 0.02


@dataclass(frozen=True)
class ChannelMetadata:
    """What is known of one channel.

    Attributes
    ----------
    match : str or None
        File's channel name, ``*`` allowed; None means by ``number``.
    number : int or None
        Position in the file, from 1.
    name, unit, sensitivity, direction, location : str or None
        New name, unit text, text such as ``"100 mV/g"``, and where the sensor sits.
    tacho, skip : bool
        Whether it carries speed pulses; whether to leave it out.
    """

    match: str | None = None
    number: int | None = None
    name: str | None = None
    unit: str | None = None
    sensitivity: str | None = None
    direction: str | None = None
    location: str | None = None
    tacho: bool = False
    skip: bool = False


#: Tuple fields of Metadata with one entry for all channels or one a channel, and the field of
#: ChannelMetadata each overrides.
PER_CHANNEL = {
    "units": "unit",
    "sensitivities": "sensitivity",
    "channel_names": "name",
    "directions": "direction",
    "locations": "location",
}


_ABOVE_ZERO = (
    "rate_hz",
    "pulses_per_revolution",
    "line_frequency_hz",
    "power_kw",
    "shaft_height_mm",
    "magnetic_bearing_clearance_m",
)


@dataclass(frozen=True)
class Metadata:
    """Everything that a file may lack; all optional, and what is given wins over the file.

    Attributes
    ----------
    rate_hz : float or None
        Sampling rate.
    units, sensitivities, channel_names, directions, locations : tuple of str
        One entry for all channels or one for each channel of the file, in its order; ``""`` leaves a channel
        as the file says.
    channels : tuple of ChannelMetadata
        The same by channel name or number; later entries win.
    skip : tuple of str
        Channels to leave out, by name or number from 1.
    tacho : str or None
        Channel with speed pulses, by name or number from 1.
    pulses_per_revolution : float or None
    speed_rpm, load, load_unit, temperature_celsius, label
        Operating condition and the machine's known state.
    name, bearings, gears, line_frequency_hz, severity_table, mounting, power_kw, shaft_height_mm
        See ``Nameplate``.
    magnetic_bearing_clearance_m : float or None
    """

    rate_hz: float | None = None
    units: tuple[str, ...] = ()
    sensitivities: tuple[str, ...] = ()
    channel_names: tuple[str, ...] = ()
    directions: tuple[str, ...] = ()
    locations: tuple[str, ...] = ()
    channels: tuple[ChannelMetadata, ...] = ()
    skip: tuple[str, ...] = ()
    tacho: str | None = None
    pulses_per_revolution: float | None = None
    speed_rpm: float | None = None
    load: float | None = None
    load_unit: str | None = None
    temperature_celsius: float | None = None
    label: str | None = None
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
        for key in _ABOVE_ZERO:
            value = getattr(self, key)
            if value is not None and not (math.isfinite(value) and value > 0):
                raise InvalidValueError(f"{key} = {value}; allowed: a finite number above 0, or leave it out.")

    def merged_over(self, other: Metadata) -> Metadata:
        """Return this metadata with the gaps filled from ``other``.

        Values given here win. An entry here for a channel field (say ``units``) also wins over the channels
        of ``other``.
        """
        changes: dict[str, object] = {}
        overridden = {own: None for many, own in PER_CHANNEL.items() if getattr(self, many)}
        below = tuple(replace(channel, **overridden) for channel in other.channels)
        for one in fields(self):
            mine, theirs = getattr(self, one.name), getattr(other, one.name)
            if mine in (None, ()) and theirs not in (None, ()):
                changes[one.name] = theirs
        changes["channels"] = below + self.channels
        changes["skip"] = other.skip + tuple(item for item in self.skip if item not in other.skip)
        return replace(self, **changes)  # pyright: ignore[reportArgumentType]

    @property
    def nameplate(self) -> Nameplate:
        """The machine's part of it."""
        return Nameplate(**{one.name: getattr(self, one.name) for one in fields(Nameplate)})


def parse_bearing(text: str) -> MountedBearing:
    """Return the bearing that a text gives.

    Forms, each with an optional ``LOCATION=`` in front and ``@RATIO`` behind (its shaft's speed over the
    reference speed):

    - a designation of the catalogue: ``6205``, ``DE=6205``;
    - balls, ball and pitch diameter in mm and, if not 0, contact angle in degrees: ``9,7.94,39.04,0``;
    - defect orders: ``BPFO=3.05,BPFI=4.95`` with ``BSF=`` and ``FTF=`` where known. Their sum is the number
      of balls, a whole number within 2 %.

    Raises
    ------
    InvalidValueError
        On any other text, an unknown designation, or orders that contradict each other.

    Examples
    --------
    >>> bearing = parse_bearing("DE=9,7.94,39.04@0.5")
    >>> bearing.location, bearing.geometry.balls, bearing.shaft_ratio
    ('DE', 9, 0.5)
    """
    body, ratio = _ratio_behind(text.strip())
    location = None
    match = re.fullmatch(r"([^=,]+)=(.+)", body)
    if match and match.group(1).strip().upper() not in ("BPFO", "BPFI", "BSF", "FTF"):
        location, body = match.group(1).strip(), match.group(2).strip()
    if "=" in body:
        geometry = _from_orders(body)
    elif "," in body:
        geometry = _from_dimensions(body)
    else:
        geometry = find_bearing(body)
    return MountedBearing(geometry=geometry, location=location, shaft_ratio=ratio)


def parse_gears(text: str) -> tuple[GearPair, ...]:
    """Return the gear pairs of a text: ``23``, ``23/46``, ``23/46@1.0``, several separated by commas.

    Teeth are driver/driven; the number behind ``@`` is the driver shaft's speed over the reference speed.

    Raises
    ------
    InvalidValueError
        When a part is none of these forms.

    Examples
    --------
    >>> parse_gears("23/46")[0].driven_ratio
    0.5
    """
    pairs: list[GearPair] = []
    for part in text.split(","):
        body, ratio = _ratio_behind(part.strip())
        match = re.fullmatch(r"(\d+)\s*(?:/\s*(\d+))?", body)
        if match is None:
            raise InvalidValueError(
                f"Gear {part.strip()!r} is not understood. Give driver teeth, and if known driven teeth "
                "and the driver "
                'shaft\'s speed ratio: "23", "23/46" or "23/46@1.0".'
            )
        driven = int(match.group(2)) if match.group(2) else None
        pairs.append(GearPair(driver_teeth=int(match.group(1)), driven_teeth=driven, driver_ratio=ratio))
    return tuple(pairs)


def _ratio_behind(text: str) -> tuple[str, float]:
    body, at, ratio_text = text.rpartition("@")
    if not at:
        return text, 1.0
    try:
        ratio = float(ratio_text)
    except ValueError:
        ratio = 0.0
    if not (math.isfinite(ratio) and ratio > 0):
        raise InvalidValueError(f"Speed ratio {ratio_text!r} in {text!r}; allowed: a number above 0, for example @0.5.")
    return body.strip(), ratio


def _from_dimensions(text: str) -> BearingGeometry:
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in (3, 4) or numbers[0] != round(numbers[0]):
        raise InvalidValueError(
            f"Bearing {text!r} is not understood. Give balls, ball diameter mm, pitch diameter mm and, if "
            "not 0, "
            "contact angle deg: 9,7.94,39.04,0."
        )
    return BearingGeometry(
        balls=int(numbers[0]),
        ball_diameter_m=numbers[1] * 1e-3,
        pitch_diameter_m=numbers[2] * 1e-3,
        contact_angle_rad=math.radians(numbers[3] if len(numbers) == 4 else 0.0),
        designation=text,
        source="given by the user",
    )


def _from_orders(text: str) -> BearingGeometry:
    """Invert the kinematics: Z = BPFO + BPFI, g = (BPFI - BPFO) / Z, d/D = (1 - g^2) / (2 BSF)."""
    orders = _order_values(text)
    outer, inner = orders.get("BPFO", 0.0), orders.get("BPFI", 0.0)
    total = outer + inner
    balls = round(total)
    if not (0 < outer < inner) or balls < 3 or abs(total - balls) > _ORDERS_AGREE * balls:
        raise InvalidValueError(
            f"Bearing orders {text!r}: BPFO + BPFI = {total:g}. Allowed: BPFO < BPFI, and their sum a "
            "whole number of balls "
            "within 2 %. They are multiples of shaft speed, not Hz."
        )
    ratio = (inner - outer) / total
    _require_agreement(text, "FTF", orders.get("FTF"), (1 - ratio) / 2)
    diameter, angle = ratio, 0.0
    if "BSF" in orders:
        diameter = (1 - ratio**2) / (2 * orders["BSF"])
        if ratio > diameter * (1 + _ORDERS_AGREE):
            _require_agreement(text, "BSF", orders["BSF"], (1 - ratio**2) / (2 * ratio))
        angle = math.acos(min(1.0, ratio / diameter))
    return BearingGeometry(
        balls=balls,
        ball_diameter_m=diameter,
        pitch_diameter_m=1.0,
        contact_angle_rad=angle,
        designation=text,
        source="defect orders given by the user; diameters are relative to the pitch diameter",
    )


def _order_values(text: str) -> dict[str, float]:
    orders: dict[str, float] = {}
    for part in text.split(","):
        key, _, value = part.partition("=")
        try:
            number = float(value)
        except ValueError:
            number = 0.0
        if key.strip().upper() not in ("BPFO", "BPFI", "BSF", "FTF") or not (math.isfinite(number) and number > 0):
            raise InvalidValueError(
                f"Bearing order {part.strip()!r} is not understood. Give BPFO=3.05,BPFI=4.95 and, if "
                "known, BSF= and FTF=, "
                "all as multiples of shaft speed."
            )
        orders[key.strip().upper()] = number
    return orders


def _require_agreement(text: str, name: str, given: float | None, expected: float) -> None:
    if given is not None and abs(given - expected) > _ORDERS_AGREE * expected:
        raise InvalidValueError(
            f"Bearing orders {text!r}: {name} = {given:g}, but BPFO and BPFI make it {expected:.4g}. Check "
            "the numbers "
            "(a ball defect strikes at twice BSF)."
        )
