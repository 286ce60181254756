"""What an analysis gives: lines, findings, severity, speed, and the curves that show them. Frozen data only."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

#: Fault names, the vocabulary of every answer.
FAULTS = (
    "unbalance",
    "misalignment",
    "bent_shaft",
    "looseness",
    "rub",
    "oil_whirl",
    "bearing_outer_race",
    "bearing_inner_race",
    "bearing_ball",
    "bearing_cage",
    "gear_wear",
    "gear_tooth_fault",
    "gear_eccentricity",
    "electrical",
    "resonance",
    "sensor_fault",
)


@dataclass(frozen=True)
class Line:
    """One spectral line used as evidence.

    Attributes
    ----------
    name : str
        ``"1X"``, ``"2 x BPFO"``, ``"mesh - 1 x wheel"``.
    channel : str
    frequency_hz, order : float
        Where it was found; order is frequency over shaft speed.
    amplitude : float
        Peak amplitude in ``unit`` (a spectrum's sine amplitude, or the envelope's).
    noise_floor : float
        Root of the local mean noise power, same unit.
    unit : str or None
        None when the channel's unit is unknown.
    spectrum : str
        ``"spectrum"`` or ``"envelope"``.
    baseline_amplitude : float or None
        The same line in the baseline recording.
    expected_order : float or None
        Where theory puts it.
    """

    name: str
    channel: str
    frequency_hz: float
    order: float
    amplitude: float
    noise_floor: float
    unit: str | None
    spectrum: Literal["spectrum", "envelope"] = "spectrum"
    baseline_amplitude: float | None = None
    expected_order: float | None = None

    @property
    def signal_to_noise(self) -> float:
        """Amplitude over the noise floor."""
        return self.amplitude / self.noise_floor if self.noise_floor > 0 else float("inf")


@dataclass(frozen=True)
class Finding:
    """One fault that the evidence speaks for.

    Attributes
    ----------
    fault : str
        One of ``FAULTS``.
    probability : float
        Stated probability that this fault is present, 0 to 1.
    summary : str
        The reason, in one sentence.
    lines : tuple of Line
        The lines that carry it.
    check : str
        What to look at on the machine.
    rivals : tuple of str
        Faults that these data cannot tell from it.
    """

    fault: str
    probability: float
    summary: str
    lines: tuple[Line, ...] = ()
    check: str = ""
    rivals: tuple[str, ...] = ()


@dataclass(frozen=True)
class Opinion:
    """What a classifier trained on simulated machines says of a recording.

    Attributes
    ----------
    probabilities : dict of str to float
        By fault, "healthy" among them; they add up to 1.
    p_value : float
        Share of simulated recordings that are as unlike the others.
    known : bool
        Whether that is enough to count.
    weights : dict or None
        How rules and model are combined; None where they are not.
    """

    probabilities: dict[str, float]
    p_value: float
    known: bool
    weights: dict[str, float] | None = None


@dataclass(frozen=True)
class Severity:
    """Where one channel stands in one zone table.

    Attributes
    ----------
    standard, table : str
        For example ``"ISO 20816-3"`` and ``"group 2, rigid mounting"``.
    zone : str
        ``"A"`` to ``"D"``.
    value, unit : float, str
        The measured quantity in the table's unit.
    quantity : str
        What was measured, for example ``"velocity, rms, 10-1000 Hz"``.
    boundaries : tuple of float
        A/B, B/C, C/D in ``unit``.
    channel : str
    source, confidence : str
        Where the table's numbers come from; H, M or L.
    verified : bool
        False marks a table whose numbers rest on a weak source.
    alarm, trip : float or None
        Limits from a baseline, in ``unit``.
    """

    standard: str
    table: str
    zone: str
    value: float
    unit: str
    quantity: str
    boundaries: tuple[float, ...]
    channel: str
    source: str
    confidence: str
    verified: bool = True
    alarm: float | None = None
    trip: float | None = None
    note: str = ""


@dataclass(frozen=True)
class SpeedEstimate:
    """Shaft speed of a recording.

    Attributes
    ----------
    speed_hz : float
    low_hz, high_hz : float
        Interval that holds the speed with about 95 % confidence.
    confidence : float
        0 to 1: probability that this is the shaft speed and not another line.
    method : str
        ``"tacho"``, ``"vibration"``, ``"vibration near the hint"``, ``"hint only"``.
    variation : float
        Relative peak-to-peak change of the speed within the recording, where measured; 0 if not.
    """

    speed_hz: float
    low_hz: float
    high_hz: float
    confidence: float
    method: str
    variation: float = 0.0

    @property
    def speed_rpm(self) -> float:
        """Speed in revolutions a minute."""
        return self.speed_hz * 60.0


@dataclass(frozen=True)
class Curve:
    """A curve to draw: x and y with their meaning."""

    name: str
    x: np.ndarray
    y: np.ndarray
    x_unit: str
    y_unit: str | None
    channel: str
    noise_floor: np.ndarray | None = None
    note: str = ""


@dataclass(frozen=True)
class Cursor:
    """A marker that the report can switch on and off, for example all shaft orders or BPFO with harmonics."""

    group: str
    label: str
    frequency_hz: float


@dataclass(frozen=True, eq=False)
class OrderPart:
    """A part of one channel from which the waveforms of orders are made, when a report asks for them.

    Attributes
    ----------
    signal : numpy.ndarray, shape (samples,)
        In the channel's SI unit.
    rate_hz : float
    turns : numpy.ndarray, shape (samples,)
        Shaft angle; whole where the tacho's mark passes, if ``has_mark``, else from an arbitrary zero.
    orders : tuple of float
        Those that stand out of the noise.
    unit : str or None
    channel : str
    has_mark : bool
    """

    signal: np.ndarray
    rate_hz: float
    turns: np.ndarray
    orders: tuple[float, ...]
    unit: str | None
    channel: str
    has_mark: bool


@dataclass(frozen=True)
class Pictures:
    """The curves of one analysis; each list may be empty.

    Attributes
    ----------
    spectra, envelopes, waveforms : tuple of Curve
    baseline_spectra : tuple of Curve
    cursors : tuple of Cursor
    order_map : dict or None
        ``{"time_s": [t], "order_or_hz": [f], "level_db": [f][t], "axis": "order"|"Hz", "channel": name}``.
    orbit : dict or None
        ``{"x": [...], "y": [...], "unit": "m", "channels": [a, b], "orders": [...]}`` for two probes at right
        angles; each order alone is ``{"name": "1X", "way": "forward", "x": [...], "y": [...]}``.
    order_part : OrderPart or None
        Where the speed is trusted and more than one of 1X to 3X shows.
    """

    spectra: tuple[Curve, ...] = ()
    envelopes: tuple[Curve, ...] = ()
    waveforms: tuple[Curve, ...] = ()
    baseline_spectra: tuple[Curve, ...] = ()
    cursors: tuple[Cursor, ...] = ()
    order_map: dict | None = None
    orbit: dict | None = None
    order_part: OrderPart | None = None


@dataclass(frozen=True)
class Analysis:
    """The answer for one file.

    Attributes
    ----------
    path : str
    verdict : str
        The answer in a sentence or two.
    findings : tuple of Finding
        Ranked by probability; empty means nothing evident.
    severity : tuple of Severity
        One per channel and table; the worst first. Empty when refused; ``severity_refusal`` says why.
    speed : SpeedEstimate or None
        None when no speed is known.
    warnings : tuple of str
    remarks : tuple of str
        Worth knowing, neither a fault nor a defect of the data.
    opinion : Opinion or None
        What the trained model says, on its own; None where it was not asked.
    channels : tuple of str
    rate_hz, duration_s : float
    features : dict
        Named feature vector (see ``features.py``).
    label, reader, baseline_path : str or None
        The known state, if any; the reader that took the file; the baseline used.
    tests : int
        How many lines were tested; false-alarm control covers all of them.
    blocks : tuple of dict
        For long files: one row a block with time, speed, overall levels and top finding (the trend).
    """

    path: str
    verdict: str
    findings: tuple[Finding, ...]
    severity: tuple[Severity, ...]
    severity_refusal: str
    speed: SpeedEstimate | None
    warnings: tuple[str, ...]
    channels: tuple[str, ...]
    rate_hz: float
    duration_s: float
    features: dict[str, float] = field(default_factory=dict)
    label: str | None = None
    reader: str | None = None
    baseline_path: str | None = None
    tests: int = 0
    blocks: tuple[dict, ...] = ()
    pictures: Pictures = field(default_factory=Pictures)
    remarks: tuple[str, ...] = ()
    opinion: Opinion | None = None
