"""Write one hour of four channels at 25.6 kHz and analyse it: time and peak memory of the command.

Run: python tests/benchmarks/one_hour.py [FOLDER] [MINUTES]
"""

from __future__ import annotations

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import soundfile
from rotorwise.simulators.rotor_dynamics.rolling_bearing import find_bearing
from rotorwise.simulators.synthetic_vibration import ImpactTrain, synthetic_vibration

RATE_HZ, CHANNELS, BLOCK_SECONDS, SPEED_HZ = 25_600, 4, 10, 24.7


def write(path: Path, minutes: float) -> None:
    """Write the recording block by block: an outer-race defect that begins half-way."""
    order = find_bearing("6205").defect_orders().outer_race
    blocks = int(minutes * 60 / BLOCK_SECONDS)
    # A whole number of turns a block: the shaft's lines go on without a jump.
    lines = {1: 1.0, 2: 0.4, 3: 0.2}
    shaft = np.array(
        [
            synthetic_vibration(
                duration_s=BLOCK_SECONDS, rate_hz=RATE_HZ, speed_hz=SPEED_HZ, seed=channel, shaft_lines=lines
            ).astype(np.float32)
            for channel in range(CHANNELS)
        ]
    )
    with soundfile.SoundFile(path, "w", RATE_HZ, CHANNELS, subtype="FLOAT", format="RF64") as file:
        for index in range(blocks):
            impacts = (ImpactTrain(order, 5.0, 4_000.0),) if index >= blocks // 2 else ()
            file.write((shaft + np.array([stirred(impacts, 1000 * index + one) for one in range(CHANNELS)])).T)


def stirred(impacts: tuple[ImpactTrain, ...], seed: int) -> np.ndarray:
    """Return impacts and noise of one block."""
    return synthetic_vibration(
        duration_s=BLOCK_SECONDS, rate_hz=RATE_HZ, speed_hz=SPEED_HZ, seed=seed, impacts=impacts, noise_rms=0.5
    ).astype(np.float32)


def main() -> None:
    """Measure the command in a process of its own."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(tempfile.mkdtemp())
    minutes = float(sys.argv[2]) if len(sys.argv) > 2 else 60.0
    path = folder / f"{minutes:g}_minutes.wav"
    if not path.exists():
        write(path, minutes)
    command = [str(Path(sys.executable).with_name("rotorwise")), "analyse", str(path), "--speed", "1480"]
    command += ["--bearing", "6205", "--unit", "m/s2", "--json", "--report", str(folder / "report.html"), "--force"]
    begun = time.perf_counter()
    answer = subprocess.run(command, check=True, capture_output=True, text=True)
    seconds = time.perf_counter() - begun
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    result = json.loads(answer.stdout)[0]
    print(f"file: {path.stat().st_size / 1e9:.2f} GB, {result['duration_s']:.0f} s, {len(result['blocks'])} blocks")
    print(
        f"wall {seconds:.0f} s, CPU {usage.ru_utime + usage.ru_stime:.0f} s, peak memory {usage.ru_maxrss / 1e6:.2f} GB"
    )
    print("findings:", [(one["fault"], one["probability"]) for one in result["findings"]], result["warnings"])


if __name__ == "__main__":
    main()
