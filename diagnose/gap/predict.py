"""What a machine would show: its lines in the conditions that were measured.

A periodic motion is balanced in the frequency domain. Effects on the measuring chain act on that motion as a record,
which is then observed as the measurement is. Motions that do not repeat with the shaft are simulated in time; where the
machine without the effects that spoil the repetition has a periodic motion, only what those effects change is taken
from the simulation.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...simulators.assembly import Probe
from ...simulators.effect import Effect
from ...simulators.errors import InvalidValueError, RotorwiseError
from ...simulators.machine import Machine
from ...simulators.sensor_run import lines_of_chain, sensor_effects
from ...simulators.solvers.harmonic_balance import PeriodicMotion
from ...simulators.solvers.simulate import Simulation
from .chain_record import chained, rate_enough
from .lines import Condition, LineKind, phase_orders, turned_to_reference
from .periodic import Moving, at_condition, motions_in
from .size_scale import to_scale
from .stepped import (
    Run,
    Stepped,
    by_themselves,
    grows_without_bound,
    keep_lately,
    lines_of_record,
    motions,
    moving_part,
    stepped_key,
    superposed,
)
from .wanted_lines import least_lengths, unstated_beside

#: Harmonics above the highest order looked at: parametric effects couple neighbours.
FURTHER_HARMONICS = 2
#: Turns, and fewest samples, of a periodic motion on which effects of the measuring chain act.
CHAIN_TURNS, CHAIN_SAMPLES = 24.0, 1000
KEPT_MOTIONS = 8
#: Machines times conditions that are balanced side by side.
LANES = 64
#: The same of simulations in time.
RUNS = 128


class UnpredictableError(InvalidValueError):
    """A machine whose lines cannot be computed."""


@dataclass
class Predictor:
    """Lines of a machine and its variants; what was computed once is kept.

    Attributes
    ----------
    conditions : tuple of Condition
    probes : tuple of str
        Names of the machine's probes.
    orders : tuple of float
    rates_hz : tuple of float
        Sampling rate of the recording in each condition.
    samples : tuple of int
        Its length.
    kinds : tuple of LineKind
        Of the orders.
    reference : tuple of int
        For each order, the probe whose phase counts as 0 in conditions that are not tied.
    noise : ndarray (conditions, probes), optional
        Standard deviation of what the recordings hold of noise in the band of the envelope; none when not given.
    full_scale : ndarray (probes,), optional
        Measuring range of each probe, one for all conditions; that of each motion when not given.
    knees : ndarray (probes, orders), optional
        Of the scale of sizes (`size_scale.py`); in units when not given.
    """

    conditions: tuple[Condition, ...]
    probes: tuple[str, ...]
    orders: tuple[float, ...]
    rates_hz: tuple[float, ...]
    samples: tuple[int, ...]
    kinds: tuple[LineKind, ...]
    reference: tuple[int, ...]
    noise: np.ndarray | None = None
    full_scale: np.ndarray | None = None
    knees: np.ndarray | None = None
    evaluations: int = 0
    _known: dict[str, np.ndarray] = field(default_factory=dict)
    _failed: dict[str, str] = field(default_factory=dict)
    _motions: dict[str, Moving] = field(default_factory=dict)
    _stepped: dict[Stepped, list[Simulation | None]] = field(default_factory=dict)
    _spoiling: dict[str, bool] = field(default_factory=dict)
    _added_up: set[str] = field(default_factory=set)

    @property
    def phase_orders(self) -> np.ndarray:
        """By how much each line's phase turns with the shaft's angle: its order, 0 for lines without phase."""
        return phase_orders(self.orders, self.kinds)

    @functools.cached_property
    def _whole_orders(self) -> dict[int, int]:
        """Lines at multiples of the shaft's speed: their number, and the multiple."""
        plain = [i for i, kind in enumerate(self.kinds) if not kind.envelope and not kind.frequency_hz]
        return {i: round(self.orders[i]) for i in plain if abs(self.orders[i] - round(self.orders[i])) < 1e-9}

    def amplitudes(self, machine: Machine) -> np.ndarray:
        """Return the lines, shape (conditions, probes, orders), complex.

        Raises
        ------
        UnpredictableError
            When neither a periodic motion nor a simulation in time gives them.
        """
        key = machine.to_toml()
        if key not in self._known:
            self.prepare([machine])
        if key in self._failed:
            raise UnpredictableError(self._failed[key])
        return self._known[key]

    def prepare(
        self,
        machines: Sequence[Machine],
        *,
        most_in_time: int | None = None,
        near: Machine | None = None,
        lasting: bool = False,
    ) -> list[bool]:
        """Compute the lines of several machines, side by side where they are simulated in time.

        Of those that are simulated in time at most ``most_in_time``, evenly spread; returns which were computed.
        Motions are sought from that of the machine ``near``, if given; ``lasting`` where that lasts and they are
        so close that they do as well.
        """
        in_time: list[tuple[str, Machine, Machine | None]] = []
        keyed = {machine.to_toml(): machine for machine in machines}
        new = {key: one for key, one in keyed.items() if key not in self._known and key not in self._failed}
        self.evaluations += len(new)
        parts = [moving_part(machine) for machine in new.values()]
        moving = self._all_moving(parts, near and moving_part(near), lasting=lasting)
        for (key, machine), own in zip(new.items(), moving, strict=True):
            if isinstance(own, RotorwiseError):
                in_time.append((key, machine, self._repeating(machine)))
                continue
            balanced = self._balanced(own, machine)
            if balanced is None:
                balanced = np.stack([self._seen(machine, motion, i) for i, motion in enumerate(own)])
            self._keep(key, balanced)
        if most_in_time is not None and len(in_time) > most_in_time:
            in_time = [in_time[i] for i in np.linspace(0, len(in_time) - 1, most_in_time).round().astype(int)]
        in_time = [one for one in in_time if not self._superposed(*one)]
        for smooth in (True, False):
            self._simulate([one for one in in_time if (one[2] is not None) == smooth], smooth=smooth)
        return [key in self._known or key in self._failed for key in map(Machine.to_toml, machines)]

    def _keep(self, key: str, lines: np.ndarray) -> None:
        self._known[key] = to_scale(turned_to_reference(lines, self.conditions, self.reference), self.knees)

    def select(self, chosen: Sequence[int]) -> Predictor:
        """Return the predictor of some of the conditions; it knows what this one knows."""
        rows = list(chosen)
        return replace(
            self,
            conditions=tuple(self.conditions[i] for i in rows),
            rates_hz=tuple(self.rates_hz[i] for i in rows),
            samples=tuple(self.samples[i] for i in rows),
            noise=None if self.noise is None else self.noise[rows],
            _known={key: lines[rows] for key, lines in self._known.items()},
            _failed=dict(self._failed),
            _motions={},
            _added_up=set(self._added_up),
            _stepped={
                (key, tuple(lengths[i] for i in rows)): [own[i] for i in rows]
                for (key, lengths), own in self._stepped.items()
            },
            _spoiling=self._spoiling,
        )

    def at(self, conditions: Sequence[Condition]) -> Predictor:
        """Return a predictor for other conditions, recorded as the longest and finest of these."""
        count = len(conditions)
        noise = None if self.noise is None else np.repeat(self.noise.mean(axis=0, keepdims=True), count, axis=0)
        recorded = (max(self.rates_hz),) * count, (max(self.samples),) * count, self.kinds, self.reference
        seen = tuple(conditions), self.probes, self.orders, *recorded
        return Predictor(*seen, noise, self.full_scale, self.knees, _spoiling=self._spoiling)

    def repeats(self, machine: Machine) -> bool:
        """Return whether the machine's motion repeats with the shaft."""
        return not isinstance(self._all_moving([machine])[0], RotorwiseError)

    def steps(self, machine: Machine) -> bool:
        """Return whether the machine's lines, which are known, cost a simulation in time."""
        return not self.repeats(machine) and machine.to_toml() not in self._added_up

    def _repeating(self, machine: Machine) -> Machine | None:
        """Return the machine without the effects that spoil its repetition; None when it does not repeat at all."""
        if self._spoils(machine, None):
            return None
        kept = tuple(e for e in machine.effects if e.STAGE == "sensor" or not self._spoils(machine, e))
        rest = replace(machine, effects=kept)
        if len(kept) < len(machine.effects) and self.repeats(rest):
            return rest
        return replace(machine, effects=tuple(e for e in machine.effects if e.STAGE == "sensor"))

    def _spoils(self, machine: Machine, effect: Effect | None) -> bool:
        key = "" if effect is None else f"{effect.NAME} at {effect.at}"
        if key not in self._spoiling:
            one = replace(machine, effects=() if effect is None else (effect,))
            self._spoiling[key] = not self.repeats(one)
        return self._spoiling[key]

    def _all_moving(
        self, machines: Sequence[Machine], near: Machine | None = None, *, lasting: bool = False
    ) -> list[Moving]:
        """Return the motion of each machine in each condition; of the last few it is kept for their sensors' sake.

        ``near`` is a machine that is nearly the same as all of them.
        """
        keyed = {machine.to_toml(): machine for machine in machines}
        found: dict[str, Moving] = {key: self._motions[key] for key in keyed if key in self._motions}
        new = [key for key in keyed if key not in found]
        together = max(LANES // len(self.conditions), 1)
        highest = max(self._whole_orders.values(), default=1) + FURTHER_HARMONICS
        beside = self._all_moving([near])[0] if new and near is not None else None
        for some in (new[i : i + together] for i in range(0, len(new), together)):
            own = motions_in(self.conditions, [keyed[key] for key in some], beside, harmonics=highest, lasting=lasting)
            found |= zip(some, own, strict=True)
        for key in new[-KEPT_MOTIONS:]:
            self._motions[key] = found[key]
        while len(self._motions) > KEPT_MOTIONS:
            self._motions.pop(next(iter(self._motions)))
        return [found[machine.to_toml()] for machine in machines]

    def _seen(self, machine: Machine, motion: PeriodicMotion, index: int) -> np.ndarray:
        """Return the lines of a motion whose chain does more than mix them, (probes, orders), from a record of it."""
        speed, rate_hz = motion.speed_rad_s, self.rates_hz[index]
        least_s = max(CHAIN_TURNS * 2 * math.pi / speed, *least_lengths(machine, self.conditions[index : index + 1]))
        least_s = min(max(least_s, CHAIN_SAMPLES / rate_hz), self.samples[index] / rate_hz)
        top = {"speed_rad_s": speed, "highest_order": motion.orders[-1], "least_s": least_s, "rate_hz": rate_hz}
        rate_hz = rate_enough(machine, motion.probes, **top)
        # Rounding makes no further sample.
        phase = speed * np.arange(math.ceil(least_s * rate_hz - 1e-6)) / rate_hz
        untouched = self._balanced([motion], moving_part(machine))
        how = {"untouched": None if untouched is None else untouched[0], "rate_hz": rate_hz}
        return self._recorded(machine, motion.probes, motion.waveform(phase), phase, index, **how)

    def _balanced(self, motions: Sequence[PeriodicMotion], machine: Machine) -> np.ndarray | None:
        """Return the lines of motions as the machine's chain shows them, (motions, probes, orders).

        None where the chain makes others.
        """
        rows = [row for row, probe in enumerate(motions[0].probes) if probe.name in self.probes]
        channels = [motions[0].probes[row] for row in rows]
        columns, orders = [*self._whole_orders], [*self._whole_orders.values()]
        moving = np.stack([motion.amplitudes[np.array(rows)[:, None], orders] for motion in motions])
        amplitudes = lines_of_chain(machine, channels, moving, orders)
        if amplitudes is None:
            return None
        number = {channel.name: i for i, channel in enumerate(channels)}
        amplitudes = amplitudes[:, [number[name] for name in self.probes]]
        result = np.zeros((len(motions), len(self.probes), len(self.orders)), dtype=complex)
        phase = np.array([self.kinds[column].phase for column in columns], dtype=bool)
        result[:, :, columns] = np.where(phase, amplitudes, np.abs(amplitudes))
        return result

    def _recorded(
        self,
        machine: Machine,
        probes: Sequence[Probe],
        signals: np.ndarray,
        phase_rad: np.ndarray,
        index: int,
        *,
        untouched: np.ndarray | None = None,
        rate_hz: float | None = None,
    ) -> np.ndarray:
        """Return the lines of what the machine's chain leaves of a motion (all probes, samples).

        ``untouched`` (probes, orders) are the lines of channels that the chain leaves as they are, where known without
        a record; ``rate_hz`` is the recording's when not given. At another one the envelope is that of nothing.
        """
        known = [i for i, probe in enumerate(probes) if probe.name in self.probes]
        channels, signals = tuple(probes[i] for i in known), signals[known]
        own, rate_hz = self.rates_hz[index], rate_hz or self.rates_hz[index]
        numbers = [self.probes.index(one.name) for one in channels]
        ranges = None if self.full_scale is None else self.full_scale[numbers]
        how = {"speed_rad_s": 2 * math.pi * self.conditions[index].speed_rpm / 60, "rate_hz": rate_hz}
        record = chained(machine, channels, signals, phase_rad, **how, full_scale=ranges)
        shape = len(self.probes), len(self.orders)
        found, rows = np.zeros(shape, dtype=complex) if untouched is None else untouched, np.arange(shape[0])
        if untouched is not None and np.array_equal(record.phase_rad, phase_rad):
            changed = {one.name for one, a, b in zip(channels, record.signals, signals, strict=True) if (a != b).any()}
            rows = np.array([row for row in rows if self.probes[row] in changed], dtype=int)
        if rows.size:
            seen = np.array([i for i, kind in enumerate(self.kinds) if rate_hz == own or not kind.envelope])
            found[np.ix_(rows, seen)] = lines_of_record(
                record,
                probes=[self.probes[row] for row in rows],
                orders=[self.orders[i] for i in seen],
                kinds=[self.kinds[i] for i in seen],
                missing_noise=None if self.noise is None else self.noise[index][rows],
            )
        # A simulation is shorter than a record: its wider band there holds sidebands of gears as well.
        found[:, unstated_beside(machine, self.orders, self.kinds)] = 0.0
        return found

    def _superposed(self, key: str, machine: Machine, base: Machine | None) -> bool:
        """Keep the lines of a linear machine to whose repeating motion sinusoidal forces add theirs; whether it is one.

        ``base`` is the machine without what spoils its repetition.
        """
        if base is None:
            return False
        moving, rest = moving_part(machine), moving_part(base)
        (balanced,) = self._all_moving([rest])
        if isinstance(balanced, RotorwiseError):
            return False
        lengths = least_lengths(machine, self.conditions)
        records = superposed(self._runs(moving, lengths), self._runs(rest, lengths), balanced)
        if records is None:
            return False
        probes = balanced[0].probes
        self._keep(key, np.stack([self._recorded(machine, probes, *own, i) for i, own in enumerate(records)]))
        self._added_up.add(key)
        return True

    def _runs(self, machine: Machine, lengths_s: Sequence[float], *, smooth: bool = True) -> list[Run]:
        """Return the machine in every condition."""
        return [
            Run(at_condition(machine, c), c.speed_rpm, rate, samples, smooth, least_s)
            for c, rate, samples, least_s in zip(self.conditions, self.rates_hz, self.samples, lengths_s, strict=True)
        ]

    def _simulate(self, wanted: Sequence[tuple[str, Machine, Machine | None]], *, smooth: bool) -> None:
        """Simulate machines in every condition and keep their lines; not all at once, as waveforms fill the memory.

        With each machine comes the one without what spoils its repetition, or None.
        """
        together = max(RUNS // len(self.conditions), 1)
        for first in range(0, len(wanted), together):
            self._simulate_side_by_side(wanted[first : first + together], smooth=smooth)

    def _simulate_side_by_side(self, wanted: Sequence[tuple[str, Machine, Machine | None]], *, smooth: bool) -> None:
        machines: dict[Stepped, Machine] = {}
        recurring: set[Stepped] = set()
        for _, machine, base in wanted:
            lengths = least_lengths(machine, self.conditions)
            machines[stepped_key(machine, lengths)] = moving_part(machine)
            if sensor_effects(machine):
                # Others will look at the same motion through another measuring chain.
                recurring.add(stepped_key(machine, lengths))
            if base is not None:
                # As long as the run that it is taken off from.
                recurring.add(stepped_key(base, lengths))
                machines[stepped_key(base, lengths)] = moving_part(base)
        new = {key: one for key, one in machines.items() if key not in self._stepped}
        runs = [run for (_, lengths), one in new.items() for run in self._runs(one, lengths, smooth=smooth)]
        found, count = motions(runs) if runs else [], len(self.conditions)
        now = {key: found[i * count : (i + 1) * count] for i, key in enumerate(new)}
        for kept in recurring & now.keys():
            self._stepped[kept] = by_themselves(now[kept])
        for key, machine, base in wanted:
            lengths = least_lengths(machine, self.conditions)
            own = now.get(stepped_key(machine, lengths)) or self._stepped[stepped_key(machine, lengths)]
            without = self._stepped[stepped_key(base, lengths)] if base is not None else None
            lines = self._lines_in_time(machine, base, own, without)
            if lines is None:
                self._failed[key] = grows_without_bound(machine)
            else:
                self._keep(key, lines)
        keep_lately(self._stepped, recurring)

    def _lines_in_time(
        self,
        machine: Machine,
        base: Machine | None,
        runs: Sequence[Simulation | None],
        without: Sequence[Simulation | None] | None,
    ) -> np.ndarray | None:
        found = []
        (balanced,) = self._all_moving([moving_part(base)]) if base is not None else (None,)
        if isinstance(balanced, RotorwiseError):
            raise UnpredictableError(str(balanced))
        for index, run in enumerate(runs):
            less = without[index] if without is not None else None
            if run is None or (without is not None and less is None):
                return None
            signals = run.signals
            if less is not None and balanced is not None:
                signals = signals - less.signals + balanced[index].waveform(run.phase_rad)
            found.append(self._recorded(machine, run.probes, signals, run.phase_rad, index))
        return np.stack(found)
