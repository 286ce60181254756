"""The demonstration of ``rotorwise analyse``: a pump with a healthy record and three faults, made on the spot."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..datasets.recording import Channel, Recording
from ..datasets.write import write_csv
from ..simulators.rotor_dynamics.rolling_bearing import find_bearing
from ..simulators.synthetic_vibration import ImpactTrain, synthetic_vibration
from .demo_files import prepare_folder, unwritable

RATE_HZ = 12_800.0
_SECONDS = 4.0
_SPEED_HZ = 24.63  # 1478 rpm: off the nominal 1480, as real machines are
_SIDECAR_NAME = "recording.toml"
_SIDECAR = """# What the files do not say. Everything here is explained in rotorwise.datasets.sidecar.
[recording]
speed_rpm = 1480

[machine]
name = "demonstration pump"
line_frequency_hz = 50
power_kw = 30
shaft_height_mm = 180
mounting = "rigid"

[[machine.bearing]]
designation = "6205"
location = "drive end"
"""


def write_pump(folder: Path, *, force: bool) -> list[Path]:
    """Write the demonstration files and return the recordings, the healthy one first.

    Parameters
    ----------
    folder : Path
        Made when missing.
    force : bool
        Whether files of an earlier demonstration may be replaced.
    """
    names = [_SIDECAR_NAME, "report.html", *_files()]
    prepare_folder(folder, names, mark=_SIDECAR_NAME, head=_SIDECAR, force=force)
    try:
        (folder / _SIDECAR_NAME).write_text(_SIDECAR, encoding="utf-8")
    except OSError as problem:
        raise unwritable(folder, problem) from problem
    return [
        write_csv(_recording(name, number), folder / f"{name}.csv", force=force)
        for number, name in enumerate(_MACHINES)
    ]


def _files() -> list[str]:
    return [f"{name}.csv" for name in _MACHINES]


def _lines(**amplitudes: float) -> dict[float, float]:
    return {float(name.removeprefix("x").replace("_", ".")): value for name, value in amplitudes.items()}


def _machines() -> dict[str, tuple[dict[float, float], tuple[ImpactTrain, ...]]]:
    orders = find_bearing("6205").defect_orders()
    healthy = _lines(x1=0.25, x2=0.12, x3=0.05)
    outer = ImpactTrain(orders.outer_race, 6.0, 3_100.0)
    inner = ImpactTrain(orders.inner_race, 7.0, 3_100.0, modulation_order=1.0, modulation_depth=0.8)
    return {
        "healthy": (healthy, ()),
        "unbalance": (_lines(x1=1.6, x2=0.16, x3=0.06), ()),
        "outer_race": (healthy, (outer,)),
        "inner_race": (healthy, (inner,)),
    }


_MACHINES = ("healthy", "unbalance", "outer_race", "inner_race")


def _recording(name: str, number: int) -> Recording:
    lines, impacts = _machines()[name]
    directions = ("horizontal", "vertical", "axial")
    # Each direction sees the same machine through its own path.
    gains = ((1.0, 1.0), (0.8, 0.7), (0.25, 0.4))
    signals = []
    for channel, (line_gain, impact_gain) in enumerate(gains):
        heard = tuple(
            ImpactTrain(
                one.order,
                one.amplitude * impact_gain,
                one.resonance_hz * (1 + 0.05 * channel),
                one.damping_ratio,
                one.slip,
                one.modulation_order,
                one.modulation_depth,
            )
            for one in impacts
        )
        signals.append(
            synthetic_vibration(
                duration_s=_SECONDS,
                rate_hz=RATE_HZ,
                speed_hz=_SPEED_HZ,
                seed=100 * number + channel,
                shaft_lines={order: value * line_gain for order, value in lines.items()},
                impacts=heard,
                noise_rms=0.6,
            )
        )
    channels = tuple(Channel(f"drive end {name}", "acceleration", "drive end", name) for name in directions)
    return Recording(np.array(signals, dtype=np.float32), RATE_HZ, channels)
