"""What an effect is, in words and as plain data: for the command line and for the catalogue's table."""

from __future__ import annotations

import inspect
from collections.abc import Mapping
from typing import Any

from .assembly import MissingPartError
from .effect import Effect, Line
from .machine import Machine
from .parameter import LogNormal, Normal, Parameter, Uniform

#: What each stage changes, in the order in which a simulation comes to it.
STAGE_TITLES = {
    "speed": "Speed of the shaft",
    "structure": "Masses, springs, dampers",
    "force": "Forces",
    "sensor": "Measuring chain",
}


def line_text(line: Line) -> str:
    """Return the place of a line: "2X", "100 Hz", "23X + 5 Hz"."""
    if not line.frequency_hz:
        return f"{line.order:.4g}X" if line.order else "mean"
    if not line.order:
        return f"{abs(line.frequency_hz):.4g} Hz"
    return f"{line.order:.4g}X {'+' if line.frequency_hz > 0 else '-'} {abs(line.frequency_hz):.4g} Hz"


def growth_text(line: Line) -> str:
    """Return how the force behind a line grows: "speed^2, load^1"; empty when no such law is declared."""
    laws = []
    for name, exponent in (("speed", line.speed_exponent), ("load", line.load_exponent)):
        if exponent is not None:
            laws.append(f"not with {name}" if exponent == 0 else f"{name}^{exponent:.3g}")
    return ", ".join(laws)


def prior_text(parameter: Parameter) -> str:
    """Return a prior in words."""
    match parameter.prior:
        case Uniform(low, high):
            return f"anything from {low:.3g} to {high:.3g}"
        case Normal(mean, deviation):
            return f"{mean:.3g} +- {deviation:.3g}"
        case LogNormal(median, factor):
            return f"{median:.3g} within a factor of {factor:.3g}"
    return "given"


def signature_on(effect: type[Effect], machine: Machine) -> tuple[Line, ...] | None:
    """Return the lines of an effect at its defaults on a machine; None when the machine lacks the part."""
    made = effect()
    try:
        made.contribute(machine.bare_assembly())
        return made.signature(machine)
    except MissingPartError:
        return None


def summary(effect: type[Effect]) -> str:
    """Return the effect's docstring as one text: formula, growth, what is left out."""
    return inspect.cleandoc(effect.__doc__ or "")


def effect_data(effect: type[Effect], machines: Mapping[str, Machine]) -> dict[str, Any]:
    """Return everything that an effect declares, with its lines on each machine that has the part."""
    lines = {name: signature_on(effect, machine) for name, machine in machines.items()}
    return {
        "name": effect.NAME,
        "stage": effect.STAGE,
        "acts_on": effect.ROLE,
        "meaning": effect.MEANING,
        "description": summary(effect),
        "check": effect.CHECK,
        "rivals": dict(effect.RIVALS),
        "references": list(effect.REFERENCES),
        "parameters": [_parameter_data(parameter) for parameter in effect.parameters()],
        "lines": {name: [_line_data(line) for line in own] for name, own in lines.items() if own is not None},
    }


def _parameter_data(parameter: Parameter) -> dict[str, Any]:
    return {
        "name": parameter.name,
        "unit": parameter.unit,
        "default": parameter.default,
        "lowest": parameter.bounds[0],
        "highest": parameter.bounds[1],
        "absent_at": parameter.zero,
        "prior": prior_text(parameter),
        "meaning": parameter.meaning,
        "source": parameter.source,
    }


def _line_data(line: Line) -> dict[str, Any]:
    return {
        "text": line_text(line),
        "order": line.order,
        "frequency_hz": line.frequency_hz,
        "direction": line.direction,
        "speed_exponent": line.speed_exponent,
        "load_exponent": line.load_exponent,
    }
