"""A bench as its simulation has it: as given, calibrated on healthy recordings, and extended by the model-gap engine.

The Analog Devices recordings have no tacho, and without one the engine adds no force: its phase would be unknown. A
pulse is therefore set where the vibration at 1X of channel X has its maximum. Phases are then relative to that line:
right within one recording and, where an unbalance makes 1X, over recordings; where two recordings have their unbalance
at other angles, what changed between them is wrong by the smaller of the two 1X.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from cases import DATA, HERE, adi
from rig_calibration import bench
from rotorwise.datasets.metadata import Metadata
from rotorwise.datasets.reading import read
from rotorwise.datasets.recording import Campaign, Channel, Recording
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.diagnose.gap.result import GapResult
from rotorwise.simulators.machine import Machine
from scipy.ndimage import gaussian_filter1d

#: What the engine is given; everything else is for the judgement.
SEEN_SPEEDS, SEEN_CLASS = ("1200", "2400"), "VHIL"
PROBES = ("housing_b_x", "housing_b_y", "housing_b_axial")
#: ADXL356C at its +-40 g range: not documented, taken as in `rig_calibration`.
SENSITIVITY = "20 mV/g"
#: Effects that compete: those of a rotor on this bench whose response is a harmonic balance, not a simulation in time.
COMPETING = frozenset({"unbalance", "coupling_misalignment", "shaft_bow", "rotating_coupling_force"})
#: A pulse made from 1X is neither steady nor a measured one; the sensors' mean is not what is asked here.
NOT_ASKED = frozenset({"speed_wander", "clock_error", "dc_drift"})
#: Standard deviations: of the time over which 1X is averaged, and of the pulse in turns.
_AVERAGED_S, _PULSE = 0.1, 0.02


@dataclass(frozen=True, eq=False)
class Machines:
    """The three machines, and what the engine said.

    Attributes
    ----------
    given, calibrated, extended : Machine
        ``extended`` is ``calibrated`` with the forces that stand for what the campaign shows.
    answer : GapResult
    """

    given: Machine
    calibrated: Machine
    extended: Machine
    answer: GapResult


def machines(tell: Callable[[str], None] = lambda _: None) -> Machines:
    """Return the three machines of the Analog Devices bench; about 15 s of processor."""
    healthy = tuple(prepared(adi(speed)) for speed in SEEN_SPEEDS)
    faulty = tuple(prepared(adi(speed, load=SEEN_CLASS)) for speed in SEEN_SPEEDS)
    given = bench()
    answer = explain_gap(Campaign(faulty, healthy), given, only=COMPETING, without=NOT_ASKED, tell=tell)
    return Machines(given, answer.calibrated, answer.extended, answer)


def prepared(file: str) -> Recording:
    """Return a recording as the machine's probes, in m/s2, with a pulse a turn from its own 1X, without its label."""
    metadata = Metadata(sensitivities=(SENSITIVITY,) * len(PROBES))
    recording = read(DATA / file, metadata=metadata, sidecar=HERE / "adi_limerick.toml")
    channels = [replace(channel, name=name) for channel, name in zip(recording.channels, PROBES, strict=True)]
    pulses = pulses_of_first_order(recording.signals[0], recording.rate_hz, recording.condition.speed_rpm or 0.0)
    return replace(
        recording,
        signals=np.vstack([recording.signals, pulses]),
        channels=(*channels, Channel("tacho", "tacho", stored_unit="V")),
        pulses_per_revolution=1.0,
        label=None,
    )


def pulses_of_first_order(signal: np.ndarray, rate_hz: float, speed_rpm: float) -> np.ndarray:
    """Return a smooth pulse at each maximum of 1X, shape (samples,); 1X lies within 4 % of the nominal speed."""
    spectrum, frequency = np.fft.rfft(signal - signal.mean()), np.fft.rfftfreq(signal.size, 1 / rate_hz)
    near = abs(frequency / (speed_rpm / 60) - 1) < 0.04
    middle = frequency[near][np.argmax(abs(spectrum[near]))]
    carrier = np.exp(-2j * np.pi * middle * np.arange(signal.size) / rate_hz)
    # A mean over neighbours that are there, also at the ends: a filter that takes the record as periodic turns them.
    width = _AVERAGED_S * rate_hz
    slow = gaussian_filter1d((signal - signal.mean()) * carrier, width, mode="constant")
    slow /= gaussian_filter1d(np.ones(signal.size), width, mode="constant")
    turns = np.unwrap(np.angle(slow * carrier.conj())) / (2 * np.pi)
    return np.exp(-0.5 * ((turns - np.round(turns)) / _PULSE) ** 2)
