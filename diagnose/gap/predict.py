"""What a machine would show: its order amplitudes in the conditions that were measured.

The periodic motion is balanced in the frequency domain. Effects on the measuring chain act on that motion as a record,
which is then observed as the measurement is.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ...simulators.errors import InvalidValueError
from ...simulators.machine import Machine
from ...simulators.sensor_record import SensorRecord
from ...simulators.sensor_run import run_chain, sensor_effects
from ...simulators.solvers.harmonic_balance import NoPeriodicMotionError, PeriodicMotion, harmonic_balance
from .lines import Condition
from .observe import weighted_amplitudes

#: Harmonics above the highest order looked at: parametric effects couple neighbours.
FURTHER_HARMONICS = 2
#: Longest record on which effects of the measuring chain act.
MOST_SAMPLES = 40_000
KEPT_MOTIONS = 8


class UnpredictableError(InvalidValueError):
    """A machine whose order amplitudes cannot be computed by harmonic balance."""


@dataclass
class Predictor:
    """Order amplitudes of a machine and its variants; what was computed once is kept.

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
    """

    conditions: tuple[Condition, ...]
    probes: tuple[str, ...]
    orders: tuple[float, ...]
    rates_hz: tuple[float, ...]
    samples: tuple[int, ...]
    evaluations: int = 0
    _known: dict[str, np.ndarray] = field(default_factory=dict)
    _motions: dict[str, list[PeriodicMotion]] = field(default_factory=dict)

    def amplitudes(self, machine: Machine) -> np.ndarray:
        """Return the amplitudes, shape (conditions, probes, orders), complex.

        Raises
        ------
        UnpredictableError
            When the motion is not periodic, or was not found.
        """
        key = machine.to_toml()
        if key not in self._known:
            motions = self._moving(replace(machine, effects=tuple(e for e in machine.effects if e.STAGE != "sensor")))
            self._known[key] = np.stack([self._seen(machine, motion, i) for i, motion in enumerate(motions)])
            self.evaluations += 1
        return self._known[key]

    def select(self, chosen: Sequence[int]) -> Predictor:
        """Return the predictor of some of the conditions; it knows what this one knows."""
        part = Predictor(
            tuple(self.conditions[i] for i in chosen),
            self.probes,
            self.orders,
            tuple(self.rates_hz[i] for i in chosen),
            tuple(self.samples[i] for i in chosen),
        )
        part._known.update({key: lines[list(chosen)] for key, lines in self._known.items()})
        return part

    def _moving(self, machine: Machine) -> list[PeriodicMotion]:
        """Return the motion in each condition; that of the last few machines is kept for their sensors' sake."""
        key = machine.to_toml()
        if key not in self._motions:
            while len(self._motions) > KEPT_MOTIONS:
                self._motions.pop(next(iter(self._motions)))
            highest = max((round(order) for order in self.orders if _is_whole(order)), default=1) + FURTHER_HARMONICS
            try:
                self._motions[key] = [
                    harmonic_balance(at_condition(machine, c), speed_rpm=c.speed_rpm, harmonics=highest)
                    for c in self.conditions
                ]
            except (NoPeriodicMotionError, InvalidValueError) as problem:
                raise UnpredictableError(
                    f"The motion of {machine.name} does not repeat with its shaft, or was not found; allowed: machines "
                    f"and effects with a periodic motion. ({problem})"
                ) from None
        return self._motions[key]

    def _seen(self, machine: Machine, motion: PeriodicMotion, index: int) -> np.ndarray:
        rows = [probe.name for probe in motion.probes]
        chosen = [rows.index(name) for name in self.probes]
        if sensor_effects(machine):
            return self._behind_chain(machine, motion, self.rates_hz[index], self.samples[index])[chosen]
        result = np.zeros((len(self.probes), len(self.orders)), dtype=complex)
        for column, order in enumerate(self.orders):
            if _is_whole(order):
                result[:, column] = motion.amplitudes[chosen, round(order)]
        return result

    def _behind_chain(self, machine: Machine, motion: PeriodicMotion, rate_hz: float, samples: int) -> np.ndarray:
        """Return what the machine's chain leaves of the motion, shape (all probes, orders)."""
        speed = motion.speed_rad_s
        samples = min(samples, MOST_SAMPLES)
        phase = speed * np.arange(samples) / rate_hz
        signals = motion.waveform(phase)
        middle = signals.mean(axis=1)
        record = SensorRecord(
            signals=signals,
            rate_hz=rate_hz,
            output_rate_hz=rate_hz,
            phase_rad=phase,
            speed_rad_s=np.full(samples, speed),
            channels=motion.probes,
            shaft_ratios=(1.0,) * len(motion.probes),
            full_scale=np.abs(signals - middle[:, None]).max(axis=1),
            middle=middle,
            leak=np.zeros(len(motion.probes)),
        )
        finished = run_chain(record, sensor_effects(machine), samples=samples, seed=0)
        turns = finished.phase_rad / (2 * np.pi)
        return weighted_amplitudes(finished.signals, turns=turns, orders=np.array(self.orders))


def _is_whole(order: float) -> bool:
    return abs(order - round(order)) < 1e-9


def at_condition(machine: Machine, condition: Condition) -> Machine:
    """Return the machine under the condition's load, where it has a load parameter and the load is known."""
    name = machine.definition.load_parameter
    if not name or condition.load is None:
        return machine
    return machine.with_parameters(**{name: condition.load})
