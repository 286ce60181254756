"""The pictures of a gap report: order lines measured, simulated before and simulated after, ready for ``gap.js``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ..gap.result import GapResult
from ..gap.words import line_names, mesh_orders, readable_unit
from .encode import numbers
from .figures import figure
from .text import escape

_LEGEND = (
    '<p class="legend gap-legend"><span class="key-measured">measured</span>'
    '<span class="key-before">simulated before</span><span class="key-after">simulated after</span></p>'
)


def gap_payload(result: GapResult) -> dict[str, Any]:
    """Return what the script draws: amplitudes in readable units by probe, condition and order.

    ``left`` is the distance from the measured line, phase included where it has one.
    """
    measured = result.measured
    return {
        "conditions": [
            {"name": str(one), "speed": one.speed_rpm, "load": one.load, "heldOut": i in result.gain.held_out}
            for i, one in enumerate(measured.conditions)
        ],
        "orders": line_names(measured, mesh_orders(result.machine)),
        "phased": [kind.phase for kind in measured.kinds],
        "probes": [_probe(result, number) for number in range(len(measured.probes))],
    }


def _probe(result: GapResult, number: int) -> dict[str, Any]:
    measured = result.measured
    unit = {one.name: one.unit for one in result.machine.bare_assembly().probes}.get(measured.probes[number], "")
    seen = measured.seen[:, number]
    lines = np.where(seen, measured.amplitudes[:, number], np.nan)
    before, after = result.before[:, number], result.after[:, number]
    largest = np.nanmax(np.abs(np.concatenate([lines[seen], before.ravel(), after.ravel()])), initial=0.0)
    factor, name = readable_unit(unit, largest=float(largest))
    noise = np.where(seen, measured.deviations[:, number], np.nan)
    phased = np.array([kind.phase for kind in measured.kinds])

    def rows(values: np.ndarray, form: Callable[[np.ndarray], np.ndarray] = np.abs) -> list[Any]:
        return [numbers(one) for one in factor * form(values)]

    return {
        "name": measured.probes[number],
        "unit": _printed(name),
        "measured": rows(lines),
        "noise": rows(noise),
        "before": rows(before),
        "after": rows(after),
        "leftBefore": rows(lines - before),
        "leftAfter": rows(lines - after),
        "phases": [
            [numbers(one) for one in np.where(phased, np.degrees(np.angle(values)), np.nan)]
            for values in (np.where(seen, lines, 0.0), before, after)
        ],
    }


def gap_figures(result: GapResult) -> str:
    """Return the two figures as HTML; the script fills them."""
    if not result.measured.conditions:
        return "<p>No condition was compared.</p>"
    first, worst = _worst(result)
    names = line_names(result.measured, mesh_orders(result.machine))
    probes = _chooser("channel", "Probe", list(result.measured.probes), first)
    views = _chooser("series", "Show", ["amplitudes", "what is left"], 0)
    scale = (
        '<label>Scale <select data-role="scale"><option value="log">logarithmic</option>'
        '<option value="linear">linear</option></select></label>'
    )
    spectra = figure(
        "gap-orders",
        "Order lines in every condition",
        probes + views + scale + _LEGEND,
        "Peak amplitudes. Before: the calibrated machine without any effect, with what healthy recordings say of its "
        "errors. After: the extended machine. Thin lines through the measured points are two standard deviations of "
        "the noise.",
        3,
    )
    lines = _chooser("series", "Line", names, worst)
    axes = (
        '<label>Show <select data-role="axis"><option value="amplitude">amplitude</option>'
        '<option value="phase">phase</option></select></label>'
    )
    over = figure(
        "gap-conditions",
        "One line over the conditions",
        probes + lines + axes + _LEGEND,
        "Rings are conditions that were held out from the fit.",
        3,
    )
    return spectra + over


def _worst(result: GapResult) -> tuple[int, int]:
    """Return the numbers of the probe and the order of the largest residual."""
    measured = result.measured
    for line in result.residuals[:1]:
        return measured.probes.index(line.probe), line.column
    return 0, min(range(len(measured.orders)), key=lambda k: abs(measured.orders[k] - 1))


def _chooser(role: str, label: str, names: list[str], chosen: int) -> str:
    options = "".join(
        f'<option value="{i}"{" selected" if i == chosen else ""}>{escape(name)}</option>'
        for i, name in enumerate(names)
    )
    return f'<label>{label} <select data-role="{role}">{options}</select></label>'


def _printed(text: str) -> str:
    return {"um": "µm", "urad": "µrad", "m/s2": "m/s²"}.get(text, text)
