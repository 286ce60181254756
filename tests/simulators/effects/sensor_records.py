"""Records of known content for tests of the measuring chain."""

import numpy as np
from rotorwise.simulators.assembly import Probe
from rotorwise.simulators.sensor_record import SensorRecord

RATE_HZ = 4096.0


def record(*signals, rate_hz=RATE_HZ, output_rate_hz=None, quantity="acceleration", directions="xyz", ratio=1.0,
           speed_rad_s=2 * np.pi * 25):  # fmt: skip
    """Return a record with one channel a signal, all at one place "here"."""
    rows = np.array([np.broadcast_to(s, np.shape(signals[0])) for s in signals], float)
    unit = {"acceleration": "m/s2", "displacement": "m", "velocity": "m/s"}[quantity]
    names = ["axial" if d == "z" else d for d in directions[: len(rows)]]
    middle = rows.mean(axis=1)
    time = np.arange(rows.shape[1]) / rate_hz
    return SensorRecord(
        signals=rows,
        rate_hz=rate_hz,
        output_rate_hz=rate_hz if output_rate_hz is None else output_rate_hz,
        phase_rad=speed_rad_s * time,
        speed_rad_s=np.full(time.size, speed_rad_s),
        channels=tuple(Probe(f"here_{d}", quantity, unit, "here", d, {}) for d in names),
        shaft_ratios=(ratio,) * len(rows),
        full_scale=np.abs(rows - middle[:, None]).max(axis=1),
        middle=middle,
        leak=np.zeros(len(rows)),
    )


def seconds(duration_s=1.0, rate_hz=RATE_HZ):
    return np.arange(round(duration_s * rate_hz)) / rate_hz


def amplitude(signal, frequency_hz, rate_hz=RATE_HZ):
    """Return the complex amplitude of a line that fits the record a whole number of times."""
    return 2 * np.mean(signal * np.exp(-2j * np.pi * frequency_hz * np.arange(signal.size) / rate_hz))


def run(effect, given, seed=0):
    return effect.apply(given, np.random.default_rng(seed))
