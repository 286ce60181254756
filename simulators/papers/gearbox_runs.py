"""Runs of the gearbox of paper 001 under the paper's conditions, and the spectral lines it names.

Records hold whole numbers of turns and of teeth, so that a Hann window keeps the strong mesh lines out of the small
ones. The step is much shorter than the motion asks for: the mesh frequency and the step have a common measure, so that
the error of a longer step falls on the multiples of f_r1, where the paper sees its lines.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..effects.coupling_misalignment import CouplingMisalignment
from ..effects.gear_eccentricity import GearEccentricity
from ..effects.rotating_coupling_force import RotatingCouplingForce
from ..effects.unbalance import Unbalance
from ..machine import Machine, find_machine
from ..machines.gearbox import BEARING_6304, PINION_TEETH
from ..solvers.simulate import Simulation, simulate_batch

RATE_HZ = 10000.0
#: How the claims are simulated. Half the length would not part f_m - f_r1 from 7 f_o1 + 4 f_r1, 0.5 Hz beside it.
PLAUSIBLE_RECORD = {"duration_s": 4.0, "settle_s": 0.7, "step_s": 1 / 120000}
PRINTED_RECORD = {"duration_s": 4.0, "settle_s": 0.4, "step_s": 1 / 240000}
#: Amplitudes below this, in m/s2, count as absent: numerical error and leakage stay below it, a sensor does not see it.
ABSENT = 2e-4
#: A line that its neighbourhood does not let stand out by this factor is noise of an irregular motion.
PROMINENCE = 3.0
_ANGLE_RAD = float(np.radians(1.0))
_OUTER = BEARING_6304.defect_orders().outer_race
#: Orders of the reference shaft by the paper's names.
ORDERS = {
    "f_r1": 1.0,
    "2f_r1": 2.0,
    "f_o1": _OUTER,
    "2f_o1": 2 * _OUTER,
    "3f_o1": 3 * _OUTER,
    "4f_o1": 4 * _OUTER,
    "f_o1-f_r1": _OUTER - 1,
    "f_o1+f_r1": _OUTER + 1,
    "f_o1-2f_r1": _OUTER - 2,
    "f_o1+2f_r1": _OUTER + 2,
    "f_m": float(PINION_TEETH),
    "f_m-f_r1": PINION_TEETH - 1.0,
    "f_m+f_r1": PINION_TEETH + 1.0,
    "f_m-2f_r1": PINION_TEETH - 2.0,
    "f_m+2f_r1": PINION_TEETH + 2.0,
    "2f_m": 2.0 * PINION_TEETH,
    "2f_m-2f_r1": 2.0 * PINION_TEETH - 2,
    "2f_m+2f_r1": 2.0 * PINION_TEETH + 2,
}
ROTOR_SIDEBANDS = ("f_r1", "f_o1-f_r1", "f_o1+f_r1", "f_m-f_r1", "f_m+f_r1")


@dataclass(frozen=True)
class Case:
    """Conditions of one run: parallel misalignment (mm), load, rotor frequency, and the strengths of extra effects."""

    misalignment_mm: float = 0.1
    load_n_m: float = 30.0
    rotor_hz: float = 30.0
    unbalance_kg_m: float = 0.0
    coupling_force_n: float = 0.0
    run_out_m: float = 0.0
    transmission_error_m: float | None = None

    def machine(self, preset: str) -> Machine:
        """Return the gearbox; every effect is present, at zero where unused, so that all run side by side."""
        offset_m = self.misalignment_mm * 1e-3
        # The paper writes its misalignment as 0.1 + 0.1 tan(1 deg) mm: gap and offset have the same number.
        machine = find_machine("gearbox").preset(preset)
        machine = machine.with_parameters(coupling_gap_m=offset_m, load_torque_n_m=self.load_n_m)
        if self.transmission_error_m is not None:
            machine = machine.with_parameters(transmission_error_m=self.transmission_error_m)
        return machine.with_effects(
            CouplingMisalignment(offset_m=offset_m, angle_rad=_ANGLE_RAD if offset_m else 0.0),
            Unbalance(moment_kg_m=self.unbalance_kg_m),
            RotatingCouplingForce(force_n=self.coupling_force_n),
            # Of the teeth alone: that of the mass is the unbalance above.
            GearEccentricity(run_out_m=self.run_out_m, mass_share=0.0),
        )


@dataclass(frozen=True)
class Spectrum:
    """Amplitudes of the named lines, rms and peak-to-peak, in m/s2; share of the time that the teeth are apart.

    The last one holds for the plausible preset without eccentricity.
    """

    lines: dict[str, float]
    rms: float
    peak_to_peak: float
    apart: float


Results = dict[Case, Spectrum]
#: Runs of this process by preset, duration, settling time, step and case.
_made: dict[tuple[str, float, float, float, Case], Simulation] = {}


def line_amplitude(signal: np.ndarray, *, frequency_hz: float, rate_hz: float) -> float:
    """Return the amplitude of a sine of known frequency in a record, through a Hann window; 0 where it is only noise.

    Noise: it does not stand out by the factor `PROMINENCE` from the median of the bins 6 to 20 places away.
    """
    count = signal.size
    window = np.hanning(count + 1)[:-1]
    weighted = (signal - signal.mean()) * window * 2 / window.sum()
    amplitude = float(abs(weighted @ np.exp(-2j * np.pi * frequency_hz / rate_hz * np.arange(count))))
    away = np.concatenate([np.arange(-20, -5), np.arange(6, 21)]) * rate_hz / count + frequency_hz
    bins = np.clip(np.rint(away * count / rate_hz).astype(int), 1, count // 2)
    floor = float(np.median(np.abs(np.fft.rfft(weighted)[bins])))
    return amplitude if amplitude > PROMINENCE * floor else 0.0


def simulate_cases(
    preset: str, cases: Sequence[Case], *, duration_s: float, settle_s: float, step_s: float
) -> dict[Case, Simulation]:
    """Simulate the distinct ones among ``cases`` side by side; what this process has simulated before is not repeated.

    The claims and the curves of the report share most of their cases, and a run's bits do not depend on the runs
    beside it.
    """
    conditions = (preset, duration_s, settle_s, step_s)
    missing = [case for case in dict.fromkeys(cases) if (*conditions, case) not in _made]
    if missing:
        runs = simulate_batch(
            [(case.machine(preset), case.rotor_hz * 60) for case in missing],
            duration_s=duration_s,
            rate_hz=RATE_HZ,
            settle_s=settle_s,
            step_s=step_s,
        )
        _made.update({(*conditions, case): run for case, run in zip(missing, runs, strict=True)})
    return {case: _made[*conditions, case] for case in cases}


def run_cases(preset: str, cases: Sequence[Case], *, duration_s: float, settle_s: float, step_s: float) -> Results:
    """Simulate the distinct ones among ``cases`` side by side and return their spectra."""
    runs = simulate_cases(preset, cases, duration_s=duration_s, settle_s=settle_s, step_s=step_s)
    return {case: _spectrum(case, run) for case, run in runs.items()}


def _spectrum(case: Case, run: Simulation) -> Spectrum:
    signal = run.probe("accelerometer")
    lines = {
        name: line_amplitude(signal, frequency_hz=order * case.rotor_hz, rate_hz=run.rate_hz)
        for name, order in ORDERS.items()
    }
    values = find_machine("gearbox").values
    error_m = values["transmission_error_m"] if case.transmission_error_m is None else case.transmission_error_m
    angle = PINION_TEETH * run.phase_rad + values["transmission_error_angle_rad"]
    gap = run.probe("transmission error") - values["mean_transmission_error_m"] - error_m * np.sin(angle)
    return Spectrum(lines, float(signal.std()), float(np.ptp(signal)), float(np.mean(gap < 0)))
