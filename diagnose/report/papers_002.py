"""Figures of paper 002: spectra of its Figs 4 to 8."""

from __future__ import annotations

from typing import Any

from ...simulators.effects.bolt_loss import BoltLoss
from ...simulators.effects.torque_ripple import TorqueRipple
from ...simulators.machine import find_machine
from .papers_figure import Figure, curve, spectrum

_LOST = BoltLoss(loss=1.0, angle_rad=0.0)
_TORQUE = TorqueRipple(at="rotor_2", torque_n_m=390.0, order=1.0)
_CASES = {
    "Fig 4: 1200 rpm": (1200.0, None),
    "Fig 5: 1200 rpm, torque of 390 N.m at 1X": (1200.0, _TORQUE),
    "Fig 6: 1200 rpm, one bolt lost": (1200.0, _LOST),
    "Fig 7: 1320 rpm, one bolt lost": (1320.0, _LOST),
    "Fig 8: 600 rpm, one bolt lost": (600.0, _LOST),
}
_MODELS = {
    "as printed": "as_printed",
    "corrected, rotor 1 immovable": "paper_reduction",
    "corrected, finite rotor 1, load 500 N.m": "plausible",
}
_RATE_HZ, _RECORD_S, _SHOWN_S = 1000.0, 10.0, 5.0
_LAST_ORDER = 6.0


def figures() -> list[Figure]:
    """Return the figure of the spectra; a few seconds."""
    variants = {name: _spectra(speed_rpm, effect) for name, (speed_rpm, effect) in _CASES.items()}
    return [
        Figure(
            "Figs 4 to 8: vertical displacement of rotor 2",
            f"Last {_SHOWN_S:g} s of a record of {_RECORD_S:g} s that starts in static equilibrium. The corrected "
            "model holds the exact potential of the bolts.",
            "Order of shaft speed",
            "Amplitude (µm)",
            variants,
            log=True,
            y_low=1e-3,
            marks=[(f"{n}X", float(n)) for n in range(1, 6)],
        )
    ]


def _spectra(speed_rpm: float, effect: BoltLoss | TorqueRipple | None) -> list[dict[str, Any]]:
    traces = []
    for name, preset in _MODELS.items():
        machine = find_machine("rigid_coupling").preset(preset)
        if effect is not None:
            machine = machine.with_effects(effect)
        run = machine.simulate(speed_rpm=speed_rpm, duration_s=_RECORD_S, rate_hz=_RATE_HZ, settle_s=0.0)
        last = run.probe("rotor_2.y")[-int(_SHOWN_S * _RATE_HZ) :]
        frequencies, lines = spectrum(last, rate_hz=_RATE_HZ)
        orders = frequencies * 60 / speed_rpm
        kept = orders <= _LAST_ORDER
        traces.append(curve(name, orders[kept], 1e6 * lines[kept]))
    return traces
