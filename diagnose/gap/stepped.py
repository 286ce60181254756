"""Lines of machines whose motion does not repeat with the shaft: in time, then observed as a recording is.

What sinusoidal forces add to a linear machine is added up, all else is simulated.
"""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from ...simulators.errors import RotorwiseError
from ...simulators.machine import Machine
from ...simulators.sensor_record import SensorRecord
from ...simulators.solvers.harmonic_balance import PeriodicMotion
from ...simulators.solvers.simulate import Simulation, simulate_motion
from ...simulators.solvers.superposed_waves import superposed_waves
from .line_noise import BLACKMAN_HARRIS, carriers_of, weighted_mean
from .line_sizes import line_sizes
from .lines import LineKind
from .wanted_lines import STRUCK

#: Turns of the shaft that are simulated: sidebands and lines of the envelope a tenth of an order from the shaft's own
#: are told apart from these.
TURNS = 24.0
#: Longest step of a smooth motion, in samples of the record and as a multiple of the machine's own, less where parts
#: are struck or touch: sizes that a struck bearing states are then known to 1e-3, other lines to 1e-5 (test rig).
STEPS_OF_SMOOTH, COARSER, COARSER_OF_TOUCHING = 0.5, 8.0, 2.0
#: Longest settling of a motion of which only the difference from a like one counts.
LONGEST_SETTLING_S = 0.4
#: Share of the machine's own settling that all others get: lines are sought to some parts in a thousand. Of the start
#: a gearbox has 7e-6 of any line left by then; with half of its damping 6e-5 of nine in ten, 3e-3 of one.
SHARE_OF_SETTLING = 0.6
#: Distance to a multiple of the shaft's speed within which an order is one.
WHOLE = 1e-6
#: How many bytes of motions are kept that others may be compared with, or seen through another measuring chain.
KEPT_BYTES = 400_000_000
THREADS = min(os.cpu_count() or 1, 4)

#: What is simulated in time: a machine, and how long its records are at least.
Stepped = tuple[str, tuple[float, ...]]


def moving_part(machine: Machine) -> Machine:
    """Return the machine without effects on the measuring chain."""
    return replace(machine, effects=tuple(e for e in machine.effects if e.STAGE != "sensor"))


def stepped_key(machine: Machine, lengths_s: tuple[float, ...]) -> Stepped:
    """Return what the machine's motions are kept under."""
    return moving_part(machine).to_toml(), lengths_s


def by_themselves(runs: Sequence[Simulation | None]) -> list[Simulation | None]:
    """Return motions that hold no memory but their own: they come out of the stepper as parts of all its lanes."""
    return [run and replace(run, signals=run.signals.copy()) for run in runs]


def keep_lately(known: dict[Stepped, list[Simulation | None]], used: Iterable[Stepped]) -> None:
    """Put the motions that were used last at the end, and forget those at the beginning beyond `KEPT_BYTES`."""
    for key in used:
        known[key] = known.pop(key)
    while sum(map(_bytes_of, known.values())) > KEPT_BYTES:
        known.pop(next(iter(known)))


def _bytes_of(runs: Sequence[Simulation | None]) -> int:
    return sum(run.signals.nbytes + 2 * run.phase_rad.nbytes for run in runs if run is not None)


def grows_without_bound(machine: Machine) -> str:
    """Return why a machine has no lines."""
    return (
        f"The motion of {machine.name} grows without bound or becomes not a number; allowed: machines and effects that "
        "can be simulated. Reduce the effect."
    )


@dataclass(frozen=True)
class Run:
    """One machine at one speed, recorded at a rate for at most so many samples.

    ``smooth`` says that longer steps and a short settling will do: the machine's own step is made for meshing teeth and
    contacts, and what settles slowly is the same in the run that it is compared with. ``least_s`` is the
    length that the slowest line needs.
    """

    machine: Machine
    speed_rpm: float
    rate_hz: float
    samples: int
    smooth: bool
    least_s: float = 0.0

    @property
    def duration_s(self) -> float:
        """Length of the record: the same for speeds that are nearly the same, so that they go side by side."""
        enough = max(TURNS * 60 / self.speed_rpm, self.least_s)
        return min(self.samples / self.rate_hz, 2 ** (math.ceil(2 * math.log2(enough)) / 2))

    @property
    def step_s(self) -> float | None:
        """Longest step; None for the machine's own."""
        if not self.smooth:
            return None
        touches = any(effect.ROLE in STRUCK or effect.IDEALISED for effect in self.machine.effects)
        coarser = COARSER_OF_TOUCHING if touches else COARSER
        return min(STEPS_OF_SMOOTH / self.rate_hz, coarser * self.machine.definition.step_s)


def motions(runs: Sequence[Run]) -> list[Simulation | None]:
    """Return every run's motion at the machine's probes; None where the simulation fails.

    Runs of like machines go side by side, those of other lengths and steps at the same time.
    """
    found: list[Simulation | None] = [None] * len(runs)
    kinds = [(run.rate_hz, run.smooth, run.step_s, run.duration_s) for run in runs]
    parts: list[list[int]] = []
    for kind in dict.fromkeys(kinds):
        members = [i for i, own in enumerate(kinds) if own == kind]
        size = math.ceil(len(members) / THREADS)
        parts += [members[first : first + size] for first in range(0, len(members), size)]
    parts.sort(key=lambda part: -len(part) * runs[part[0]].duration_s)
    with ThreadPoolExecutor(THREADS) as pool:
        for part, own in zip(parts, pool.map(lambda part: _side_by_side([runs[i] for i in part]), parts), strict=True):
            for i, motion in zip(part, own, strict=True):
                found[i] = motion
    return found


def _side_by_side(runs: Sequence[Run]) -> list[Simulation | None]:
    first = runs[0]
    own = first.machine.definition.settle_s
    settle = min(own, LONGEST_SETTLING_S) if first.smooth else SHARE_OF_SETTLING * own
    try:
        cases = [(run.machine, run.speed_rpm) for run in runs]
        return list(
            simulate_motion(
                cases,
                duration_s=first.duration_s,
                rate_hz=first.rate_hz,
                step_s=first.step_s,
                settle_s=settle,
            )
        )
    except RotorwiseError:
        if len(runs) == 1:
            return [None]
        # One that fails takes the others with it: in halves, until it stands alone.
        half = len(runs) // 2
        return _side_by_side(runs[:half]) + _side_by_side(runs[half:])


def superposed(
    runs: Sequence[Run], without: Sequence[Run], balanced: Sequence[PeriodicMotion]
) -> list[tuple[np.ndarray, np.ndarray]] | None:
    """Return signals (all probes, samples) and shaft angles of every run: a repeating motion and what is added to it.

    Parameters
    ----------
    runs, without : sequence of Run
        With and without the forces that spoil the repetition; these must be sinusoidal and the machine linear.
    balanced : sequence of PeriodicMotion
        Of the runs without.

    Returns
    -------
    list of tuple, or None
        None where the motions do not add up: to be simulated.
    """
    found = []
    for run, rest, motion in zip(runs, without, balanced, strict=True):
        try:
            waves = superposed_waves(run.machine, rest.machine, speed_rpm=run.speed_rpm)
        except RotorwiseError:
            return None
        if waves is None:
            return None
        time_s = np.arange(round(run.duration_s * run.rate_hz)) / run.rate_hz
        phase = motion.speed_rad_s * time_s
        found.append((sum((wave.waveform(phase, time_s) for wave in waves), motion.waveform(phase)), phase))
    return found


def lines_of_record(
    record: SensorRecord,
    *,
    probes: Sequence[str],
    orders: Sequence[float],
    kinds: Sequence[LineKind],
    missing_noise: np.ndarray | None = None,
) -> np.ndarray:
    """Return the lines of a record, shape (probes, orders), complex: those with phase, and sizes of the others.

    ``missing_noise`` (probes,) is what measured records have in the envelope's band, see `line_sizes`.
    """
    names = [probe.name for probe in record.channels]
    rows = [names.index(name) for name in probes]
    signals, turns = record.signals[rows], record.phase_rad / (2 * np.pi)
    with_phase = np.array([kind.phase for kind in kinds])
    result = np.zeros((len(rows), len(orders)), dtype=complex)
    # Simulated records are shorter than measured ones: what lies beside an order must not leak into it for that.
    centred = signals - signals.mean(axis=1, keepdims=True)

    def at_orders(chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        carriers = carriers_of(chosen, turns)
        return chosen, weighted_mean(centred, turns, carriers, BLACKMAN_HARRIS), carriers

    *locked, carriers = at_orders(np.array(orders)[with_phase])
    result[:, with_phase] = locked[1]
    meshes, beside = _meshes(orders, kinds, lambda chosen: at_orders(chosen)[1])
    groups = [(~with_phase & ~beside, (locked[0], locked[1]), carriers)]
    if beside.any():
        # Nor may a mesh leak into its sidebands.
        *both, of_both = at_orders(np.append(locked[0], meshes))
        groups.append((beside, (both[0], both[1]), of_both))
    for lines, taken_off, own in groups:
        if lines.any():
            result[:, lines] = line_sizes(
                signals,
                rate_hz=record.output_rate_hz,
                turns=turns,
                locked=taken_off,
                orders=np.array(orders)[lines].tolist(),
                kinds=[kind for kind, is_one in zip(kinds, lines, strict=True) if is_one],
                accelerations=[record.channels[row].quantity == "acceleration" for row in rows],
                missing_noise=missing_noise,
                doubted=False,
                carriers=own,
            )[0]
    return result


def _meshes(
    orders: Sequence[float], kinds: Sequence[LineKind], amplitudes: Callable[[np.ndarray], np.ndarray]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the whole orders without phase that are larger than those beside them, and which lines stand beside such.

    The latter are all other lines without phase but those of the envelope, bool; none without such an order.
    """
    plain = np.array([not kind.phase and not kind.envelope for kind in kinds])
    at_order = np.array([kind.frequency_hz == 0 for kind in kinds]) & plain
    whole = at_order & (np.abs(np.array(orders) - np.rint(orders)) < WHOLE) & (np.array(orders) > 0)
    if not whole.any() or not (plain & ~whole).any():
        return np.zeros(0), np.zeros(len(orders), dtype=bool)
    chosen = np.array(orders)[whole]
    size = np.abs(amplitudes(chosen))
    size = np.linalg.norm(size / np.maximum(size.max(axis=1, keepdims=True), 1e-300), axis=0)
    near = np.abs(chosen[:, None] - chosen) < 1 + WHOLE
    return chosen[size >= np.where(near, size, 0.0).max(axis=1)], plain & ~whole
