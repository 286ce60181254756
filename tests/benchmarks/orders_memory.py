"""Peak memory of ``rotorwise orders`` over the length of the recording: one accelerometer and a tacho at 25.6 kHz.

Run: python tests/benchmarks/orders_memory.py FOLDER MINUTES [MINUTES ...]
"""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import soundfile

RATE_HZ, SPEED_HZ = 25_600, (10.0, 40.0)
GNU_TIME = ["/usr/bin/time", "-v"]


def write(path: Path, minutes: float) -> None:
    """Write a slow run-up in pieces of a second: three orders, noise, a tacho with one pulse a turn."""
    rng = np.random.default_rng(3)
    samples = int(60 * minutes) * RATE_HZ
    slope = (SPEED_HZ[1] - SPEED_HZ[0]) / samples
    with soundfile.SoundFile(path, "w", RATE_HZ, 2, subtype="FLOAT", format="RF64") as file:
        for start in range(0, samples, RATE_HZ):
            n = np.arange(start, start + RATE_HZ, dtype=float)
            turns = (SPEED_HZ[0] * n + 0.5 * slope * n**2) / RATE_HZ
            lines = sum(np.cos(2 * np.pi * order * turns) / order for order in (1, 2, 3))
            pulse = (turns % 1.0 < 0.1).astype(float)
            file.write(np.stack([lines + rng.normal(0, 0.3, n.size), pulse], axis=1).astype(np.float32))


def main() -> None:
    """Print a line for every length, with and without a tacho."""
    folder = Path(sys.argv[1])
    rotorwise = str(Path(sys.executable).with_name("rotorwise"))
    for minutes in map(float, sys.argv[2:]):
        path = folder / f"run_up_{minutes:g}.wav"
        if not path.exists():
            write(path, minutes)
        for words in (["--tacho", "2"], ["--skip", "2", "--speed-range", "500-3000"]):
            command = [*GNU_TIME, rotorwise, "orders", str(path), "--unit", "m/s2", *words]
            command += ["--report", str(folder / "orders.html"), "--force"]
            answer = subprocess.run(command, capture_output=True, text=True)
            peak = int(re.search(r"Maximum resident set size \(kbytes\): (\d+)", answer.stderr)[1])
            seconds = sum(map(float, re.findall(r"(?:User|System) time \(seconds\): ([\d.]+)", answer.stderr)))
            said = answer.stderr.splitlines()[0] if answer.returncode else ""
            print(f"{minutes:g} min, {words[0]}: {peak / 1e6:.2f} GB, CPU {seconds:.0f} s {said}", flush=True)


if __name__ == "__main__":
    main()
