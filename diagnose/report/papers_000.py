"""Figures of paper 000: order lines of its four cases, run-up, threshold maps."""

from __future__ import annotations

import math

import numpy as np

from ...simulators.effects.coupling_misalignment import CouplingMisalignment
from ...simulators.machine import Machine, find_machine
from ...simulators.papers.paper_000 import ANGLE_RAD, CLEARANCE_M, CRITICAL_RPM, OFFSET_M, RATED_RPM
from ...simulators.speed_profile import ramp
from ...simulators.threshold_map import ZONE_LIMITS, threshold_map
from .encode import numbers
from .papers_figure import Figure, curve, heights

_CASES = {
    "1 unbalance only": (0.0, 0.0),
    "2 offset 0.5 mm": (OFFSET_M, 0.0),
    "3 angle 1 degree": (0.0, ANGLE_RAD),
    "4 both": (OFFSET_M, ANGLE_RAD),
}
_FIRST_RPM, _LAST_RPM, _RAMP_S = 50.0, 4500.0, 10.0
_CELLS = 101
_BIN_RPM = 10.0


def figures() -> list[Figure]:
    """Return the figures; about 5 s."""
    machine = find_machine("amb_rotor")
    return [_cases(machine), _run_up(machine), _map(machine, CRITICAL_RPM), _map(machine, RATED_RPM)]


def _cases(machine: Machine) -> Figure:
    from ...simulators.solvers.harmonic_balance import harmonic_balance

    variants: dict[str, list[dict[str, object]]] = {}
    bare = machine.with_parameters(harmonic_1=0.0, harmonic_2=0.0, harmonic_3=0.0)
    for name, chosen in (("with stiffness harmonics", machine), ("without stiffness harmonics", bare)):
        variants[name] = []
        for case, (offset_m, angle_rad) in _CASES.items():
            effect = CouplingMisalignment(
                offset_m=offset_m, angle_rad=angle_rad, offset_phase_rad=0.0, angle_phase_rad=0.0
            )
            motion = harmonic_balance(chosen.with_effects(effect), speed_rpm=RATED_RPM)
            lines = 1e6 * np.abs(motion.amplitudes[:, 1:6]).max(axis=0)
            variants[name].append(heights(case, [f"{n}X" for n in range(1, 6)], lines.tolist()))
    return Figure(
        "Figs 5 to 8: the four cases at 4000 rpm",
        "Steady motion by harmonic balance, each line at the path where it is largest. It is exactly periodic: between "
        "these lines there is nothing. In case 4 offset and angle have the same phase. Above 125 µm the rotor touches.",
        "Order of shaft speed",
        "Amplitude (µm)",
        variants,
        log=True,
        y_low=1e-3,
        kind="bars",
    )


def _run_up(machine: Machine) -> Figure:
    profile = ramp(start_rpm=_FIRST_RPM, stop_rpm=_LAST_RPM, duration_s=_RAMP_S)
    run = machine.simulate(speed_rpm=profile, duration_s=_RAMP_S, rate_hz=1000.0)
    speed = run.speed_rad_s * 30 / math.pi
    edges = np.arange(100.0, _LAST_RPM, _BIN_RPM)
    # A turn at 100 rpm takes longer than one step of this grid; the largest of the turn so far is kept.
    peaks = [np.abs(run.signals[:, (speed >= low - 50) & (speed < low + _BIN_RPM)]).max(axis=1) for low in edges]
    traces = [curve(f"path {i + 1}", edges + _BIN_RPM / 2, 1e6 * np.array(peaks)[:, i]) for i in range(len(run.probes))]
    return Figure(
        "Fig 9: run-up of case 1",
        f"{_FIRST_RPM:g} to {_LAST_RPM:g} rpm in {_RAMP_S:g} s; largest displacement over the last 50 rpm.",
        "Shaft speed (rpm)",
        "Displacement (µm)",
        {"": traces},
        marks=[("2580 rpm", CRITICAL_RPM), ("4000 rpm", RATED_RPM)],
    )


def _map(machine: Machine, speed_rpm: float) -> Figure:
    offsets, angles = np.linspace(0, OFFSET_M, _CELLS), np.linspace(0, 2 * ANGLE_RAD, _CELLS)
    made = threshold_map(machine, speed_rpm, offsets, angles)
    clearance_um = 1e6 * CLEARANCE_M
    panels = [
        {
            "name": f"path {i + 1}",
            "x": numbers(1e3 * offsets),
            "y": numbers(np.degrees(angles)),
            "z": [numbers(row) for row in 1e6 * made.peaks[i].T],
            "limits": [share * clearance_um for share in ZONE_LIMITS],
            "contact": clearance_um,
        }
        for i in range(len(made.probes))
    ]
    limits = ", ".join(f"{share * clearance_um:g}" for share in ZONE_LIMITS)
    return Figure(
        f"Figs 10 to 12: how much misalignment the rotor bears at {speed_rpm:g} rpm",
        f"Largest displacement in a turn. Zones A to D of ISO 14839-2 with limits at {limits} µm; beyond the thick "
        f"line, {clearance_um:g} µm, the rotor touches its retainer bearing and the model no longer holds. Offset and "
        "angle have the same phase.",
        "Offset (mm)",
        "Angle (degrees)",
        {"": panels},
        kind="zones",
    )
