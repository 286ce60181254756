"""Figures of paper 001: spectra of the gearbox, and its lines against misalignment, speed and load."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...simulators.papers.gearbox_runs import (
    ABSENT,
    ORDERS,
    PLAUSIBLE_RECORD,
    RATE_HZ,
    Case,
    line_amplitude,
    simulate_cases,
)
from .papers_figure import Figure, curve, points, spectrum

if TYPE_CHECKING:
    from ...simulators.solvers.simulate import Simulation

_HEALTHY, _BASE = Case(misalignment_mm=0.0), Case()
_MISALIGNMENTS, _SPEEDS, _LOADS = (0.0, 0.05, 0.1, 0.2), (20.0, 30.0, 40.0, 50.0), (10.0, 30.0, 50.0, 70.0)
_UNBALANCE_KG_M, _FORCE_N_PER_MM = 1e-4, 80.0
#: Cases of each picture by the name of the variant.
_BY_MISALIGNMENT = {
    "the paper's model": [Case(misalignment_mm=value) for value in _MISALIGNMENTS],
    "with a coupling force turning at 1X, 80 N/mm": [
        Case(misalignment_mm=value, coupling_force_n=_FORCE_N_PER_MM * value) for value in _MISALIGNMENTS
    ],
}
_BY_SPEED = {"the paper's model": [Case(rotor_hz=value) for value in _SPEEDS]}
_BY_LOAD = {
    "the paper's model": [Case(load_n_m=value) for value in _LOADS],
    "with unbalance 1e-4 kg.m": [Case(load_n_m=value, unbalance_kg_m=_UNBALANCE_KG_M) for value in _LOADS],
}
_SHOWN = ("f_r1", "2f_r1", "f_o1", "f_o1+f_r1", "f_m", "f_m-f_r1", "f_m+f_r1", "f_m+2f_r1")
_MARKED = ("f_r1", "2f_r1", "f_o1", "2f_o1", "f_m", "f_m-f_r1", "f_m+f_r1", "2f_m")


def figures() -> list[Figure]:
    """Return the figures; the simulations take about half a minute, nothing after the claims."""
    groups = (*_BY_MISALIGNMENT.values(), *_BY_SPEED.values(), *_BY_LOAD.values())
    cases = [_HEALTHY, *(case for group in groups for case in group)]
    runs = simulate_cases("plausible", cases, **PLAUSIBLE_RECORD)
    absent = f"Lines below {ABSENT:g} m/s² or drowned in noise are left out."
    return [
        _spectra(runs),
        _series("Fig 9: against the misalignment", "Misalignment (mm)", _BY_MISALIGNMENT, _MISALIGNMENTS, runs, absent),
        _series(
            "Fig 11: against the speed",
            "Rotor frequency (Hz)",
            _BY_SPEED,
            _SPEEDS,
            runs,
            f"Misalignment 0.1 mm. {absent}",
        ),
        _series(
            "Figs 12 and 13: against the load",
            "Load (N.m)",
            _BY_LOAD,
            _LOADS,
            runs,
            f"Misalignment 0.1 mm. {absent} At 10 N.m the motion is irregular: its values move by a few per cent, f_o1 "
            "by a tenth, from one stretch of time to the next.",
        ),
    ]


def _spectra(runs: Mapping[Case, Simulation]) -> Figure:
    unbalanced = Case(unbalance_kg_m=_UNBALANCE_KG_M)
    named = {"healthy": _HEALTHY, "misaligned 0.1 mm": _BASE, "misaligned and unbalance 1e-4 kg.m": unbalanced}
    traces = {}
    for name, case in named.items():
        frequencies, lines = spectrum(runs[case].probe("accelerometer"), rate_hz=RATE_HZ)
        kept = frequencies <= 0.4 * RATE_HZ
        traces[name] = curve(name, frequencies[kept] / case.rotor_hz, lines[kept])
    healthy, misaligned, both = traces.values()
    return Figure(
        "Figs 7 and 8: spectrum of the accelerometer on bearing 1",
        "1800 rpm, 30 N.m, record of 4 s. The paper's coupling force acts at twice the shaft speed: it makes 2 f_r1 "
        "and sidebands 2 f_r1 away, not f_r1. A click on a name hides its curve.",
        "Order of the pinion shaft",
        "Acceleration (m/s²)",
        {"healthy and misaligned": [misaligned, healthy], "misaligned, and with unbalance": [both, misaligned]},
        log=True,
        y_low=1e-4,
        x_range=(0.0, 30.0),
        marks=[(name, ORDERS[name]) for name in _MARKED],
    )


def _series(
    title: str,
    axis: str,
    variants: Mapping[str, Sequence[Case]],
    values: Sequence[float],
    runs: Mapping[Case, Simulation],
    note: str,
) -> Figure:
    made: dict[str, list[dict[str, Any]]] = {}
    for variant, cases in variants.items():
        signals = [runs[case].probe("accelerometer") for case in cases]
        traces = [
            points("rms", values, [float(signal.std()) for signal in signals]),
            points("peak to peak", values, [float(np.ptp(signal)) for signal in signals]),
        ]
        for name in _SHOWN:
            lines = [
                line_amplitude(signal, frequency_hz=ORDERS[name] * case.rotor_hz, rate_hz=RATE_HZ)
                for case, signal in zip(cases, signals, strict=True)
            ]
            seen = [line if line > ABSENT else np.nan for line in lines]
            if np.isfinite(seen).any():
                traces.append(points(name, values, seen))
        made[variant] = traces
    return Figure(title, note, axis, "Acceleration (m/s²)", made, log=True)
