"""Compare the healthy Analog Devices bench with the simulated rig: python tests/measured/rig_table.py [--write].

Before and after the calibration of `rig_calibration` (fitted at 1200 and 2400 rpm, 1800 held out). A line or band is
right when simulation and measurement differ by at most 3 dB or by twice the measured spread, if that is more. There is
one healthy record a speed: the spread is that of its own parts, not of several runs. With ``--write`` the tables go
into tests/README.md.

The sensor's range, the housing that carries it and which of its radial axes is horizontal are not documented: 20 mV/g
is taken (80 mV/g would make every measured number and the calibrated unbalance a quarter, -12 dB), X is set beside x, Y
beside y, Z beside axial; the first lines of the output show what the other arrangements would fit.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from rotorwise.diagnose.signal.order_tracking import constant_speed_phase, order_amplitudes
from rotorwise.diagnose.signal.spectrum import amplitude_spectrum
from rotorwise.simulators.machine import Machine, find_machine
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

sys.path.insert(0, str(Path(__file__).resolve().parent))
from cases import ADI_SPEEDS, DATA, HERE, IMBALANCE
from rig_calibration import (
    AXES,
    EDGES_HZ,
    ORDERS,
    PLATE,
    RIGHT_DB,
    UNBALANCE,
    Arrangement,
    Calibration,
    band_levels,
    bench,
    calibrate,
    errors_db,
    measured,
    recorded,
    seeded_unbalance_kg_m,
)

ARRANGEMENTS = tuple(
    Arrangement(housing, directions) for housing in "ba" for directions in (("x", "y", "axial"), ("y", "x", "axial"))
)
#: Below this, m/s2, the simulation has nothing.
NOTHING = 1e-4
PICKUP_HZ = (4160.0, 4180.0)
MARKS = ("<!-- rig table -->", "<!-- end of rig table -->")


def linear(machine: Machine, shaft_hz: float, arrangement: Arrangement) -> tuple[np.ndarray, np.ndarray]:
    """Return lines (axes, orders) and bands (axes, bands) of a linear machine's steady motion."""
    motion = harmonic_balance(machine, speed_rpm=60 * shaft_hz, harmonics=max(ORDERS))
    lines = np.array([[abs(motion.amplitude(probe, float(n))) for n in ORDERS] for probe in arrangement.probes])
    frequency = shaft_hz * np.array(ORDERS)
    inside = np.array([(frequency >= low) & (frequency < high) for low, high in pairwise(EDGES_HZ)])
    return lines, np.sqrt(lines**2 / 2 @ inside.T)


def rattling(calibration: Calibration, shaft_hz: float) -> tuple[np.ndarray, np.ndarray]:
    """Return lines and bands of the calibrated rig whose bearings have Hertz contacts and play."""
    rate_hz = 20000.0
    rig = find_machine("test_rig").preset("adi_hertz").with_parameters(**calibration.values)
    run = rig.simulate(speed_rpm=60 * shaft_hz, duration_s=2.0, rate_hz=rate_hz)
    signals = np.stack([run.probe(probe) for probe in calibration.arrangement.probes])
    turns = constant_speed_phase(samples=signals.shape[1], rate_hz=rate_hz, speed_hz=shaft_hz)
    amplitude, _ = order_amplitudes(signals, phase_turns=turns, orders=list(ORDERS))
    return np.abs(amplitude), band_levels(signals, rate_hz)


def numbers(values: np.ndarray) -> str:
    """Return numbers with two significant digits, separated by slashes."""
    return " / ".join("none" if value < NOTHING else f"{value:.2g}" for value in values)


def decibels(simulation: np.ndarray, measurement: np.ndarray, digits: int) -> str:
    """Return simulation over measurement in dB with so many decimals, separated by slashes."""
    ratio = 20 * np.log10(np.maximum(simulation, NOTHING * 1e-3) / measurement)
    shown = zip(simulation, ratio, strict=True)
    return " / ".join("none" if value < NOTHING else f"{one:+.{digits}f}" for value, one in shown)


def is_right(simulation: np.ndarray, measurement: np.ndarray, spread_db: np.ndarray) -> np.ndarray:
    """Return for each value whether it is right."""
    difference = 20 * np.log10(np.maximum(simulation, 1e-12) / measurement)
    return np.abs(difference) <= np.maximum(RIGHT_DB, 2 * spread_db)


def comparison(calibration: Calibration) -> Iterator[str]:
    """Yield the table of lines and bands, and how many are right."""
    records = [measured(speed) for speed in ADI_SPEEDS]
    rig = bench().with_parameters(**calibration.values)
    models: tuple[Callable[[float], tuple[np.ndarray, np.ndarray]], ...] = (
        lambda hz: linear(bench(), hz, calibration.arrangement),
        lambda hz: linear(rig, hz, calibration.arrangement),
        lambda hz: rattling(calibration, hz),
    )
    simulated = [[model(record.shaft_hz) for record in records] for model in models]
    yield (
        f"Healthy, {' / '.join(ADI_SPEEDS)} rpm (found: {' / '.join(f'{60 * one.shaft_hz:.0f}' for one in records)}). "
        "Lines as peak amplitude, bands as rms, m/s2."
    )
    yield ""
    yield (
        "| line or band | axis | measured | spread, dB | before | after | after - measured, dB | right | "
        "with Hertz contacts and play, dB |"
    )
    yield f"|{'---|' * 9}"
    names = [f"{order}X" for order in ORDERS], [f"{low:.0f}-{high:.0f} Hz" for low, high in pairwise(EDGES_HZ)]
    for kind in (0, 1):
        count = total = 0
        for number, name in enumerate(names[kind]):
            for axis, letter in enumerate(AXES):
                truth = np.array([(one.lines, one.bands)[kind][axis, number] for one in records])
                spread = np.array([(one.lines_spread_db, one.bands_spread_db)[kind][axis, number] for one in records])
                before, after, hertz = (np.array([one[kind][axis, number] for one in runs]) for runs in simulated)
                right = is_right(after, truth, spread)
                count, total = count + int(right.sum()), total + right.size
                yield (
                    f"| {name} | {letter} | {numbers(truth)} | {' / '.join(f'{one:.1f}' for one in spread)} | "
                    f"{numbers(before)} | {numbers(after)} | {decibels(after, truth, 1)} | "
                    f"{' / '.join('yes' if one else 'no' for one in right)} | {decibels(hertz, truth, 0)} |"
                )
        yield f"| {('lines', 'bands')[kind]} right: {count} of {total} |{' |' * 8}"


def seeded(calibration: Calibration) -> Iterator[str]:
    """Yield 1X of the seeded imbalance records: one factor a class, the same at all speeds."""
    where, rig = calibration.arrangement, bench().with_parameters(**calibration.values)
    first = seeded_unbalance_kg_m(bench(), where)
    before = np.array([errors_db(bench(), speed, where, first)[1] for speed in ADI_SPEEDS])
    after = np.array([errors_db(rig, speed, where, calibration.seeded_kg_m)[1] for speed in ADI_SPEEDS])
    yield "Seeded imbalance, 1X, one unknown unbalance a class. Simulated - measured, dB, X / Y / Z:"
    yield ""
    yield f"| class, its unbalance after, g.mm | {' | '.join(f'{one} rpm before | after' for one in ADI_SPEEDS)} |"
    yield f"|{'---|' * (1 + 2 * len(ADI_SPEEDS))}"
    for number, load in enumerate(IMBALANCE):
        cells = [
            " / ".join(f"{x:+.1f}" for x in one[k, number]) for k in range(len(ADI_SPEEDS)) for one in (before, after)
        ]
        yield f"| {load}, {1e6 * calibration.seeded_kg_m[load]:.0f} | {' | '.join(cells)} |"


def parameters(calibration: Calibration) -> Iterator[str]:
    """Yield what was calibrated and what the other arrangements of the sensor would give."""
    before = bench().values
    yield "| parameter | before | after | interval of about 95 % |"
    yield "|---|---|---|---|"
    for name, value in calibration.values.items():
        low, high = calibration.interval(name)
        yield f"| `{name}` | {before[name]:.2g} | {value:.2g} | {low:.2g} to {high:.2g} |"
    yield ""
    costs = [(one, calibrate(one)) for one in ARRANGEMENTS]
    told = [
        f"{one.housing.upper()} with X = {one.directions[0]} {found.cost:.1f} "
        f"({', '.join(f'{found.values[name]:.2g}' for name in (*PLATE, UNBALANCE))})"
        for one, found in costs
    ]
    yield f"Half the sum of squares (and the same values) with the sensor on housing {'; '.join(told)}."


def pickup() -> str:
    """Return the line near 4.17 kHz, mV at each speed."""
    found = []
    for speed in ADI_SPEEDS:
        volts, rate_hz = recorded(speed)
        frequency, amplitude = amplitude_spectrum(volts, rate_hz=rate_hz)
        inside = (frequency > PICKUP_HZ[0]) & (frequency < PICKUP_HZ[1])
        best = frequency[inside][int(np.argmax(amplitude[0, inside]))]
        peaks = " / ".join(f"{1e3 * one:.1f}" for one in amplitude[:, inside].max(axis=1))
        found.append(f"{speed} rpm {peaks} mV at {best:.0f} Hz")
    return f"Line near 4.17 kHz, X / Y / Z: {'; '.join(found)}."


def main() -> None:
    """Print or write the tables."""
    if not DATA.is_dir():
        sys.exit(f"{DATA} is not there: the measured recordings are needed to make the table.")
    calibration = calibrate()
    parts = (parameters(calibration), comparison(calibration), seeded(calibration), (pickup(),))
    text = "\n\n".join("\n".join(part) for part in parts)
    if "--write" not in sys.argv:
        print(text)
        return
    path = HERE.parent / "README.md"
    old = path.read_text(encoding="utf-8")
    head, rest = old.split(MARKS[0])
    path.write_text(f"{head}{MARKS[0]}\n{text}\n{MARKS[1]}{rest.split(MARKS[1])[1]}", encoding="utf-8")


if __name__ == "__main__":
    main()
