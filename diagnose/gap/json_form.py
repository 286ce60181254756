"""A result as JSON: stable names, SI units, finite numbers only."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..json_output import number
from .lines import Condition, LineKind
from .result import AddedForce, Cause, Estimate, GapResult, ModelForm, ResidualLine, Score
from .words import line_names, mesh_orders, sentence_of


def as_json(result: GapResult) -> dict[str, Any]:
    """Return a result as a dictionary of JSON types; numbers that are not finite become None."""
    measured = result.measured
    conditions = [_condition(one) for one in measured.conditions]
    names = line_names(measured, mesh_orders(result.machine))
    return {
        "verdict": {
            "kind": result.kind,
            "sentence": sentence_of(result),
            "causes": [_cause(one) for one in result.causes],
            "indistinguishable": [list(names) for names in result.indistinguishable],
            "next_measurement": result.next_measurement,
        },
        "empirical": [_force(one) for one in result.empirical],
        "probabilities": [
            {"effects": list(names), "probability": number(value), **_score(result.scores.get(names))}
            for names, value in result.probabilities.items()
        ],
        "residuals": [_residual(one, measured.conditions, names) for one in result.residuals],
        "gain": {
            "held_out_db": number(result.gain.held_out_db),
            "calibration_only_db": number(result.gain.calibration_only_db),
            "wrong_effect_db": number(result.gain.wrong_effect_db),
            "smooth_function_db": number(result.gain.smooth_function_db),
            "held_out": [conditions[i] for i in result.gain.held_out],
        },
        "detectability": number(result.detectability),
        "misfit": number(result.misfit),
        "machine": {"name": result.machine.name, "preset": result.machine.preset_name},
        "calibration": _changed(result),
        "model_form": _form(result.form) if result.form else None,
        "extended": result.extended.to_toml(),
        "conditions": conditions,
        "probes": list(measured.probes),
        "orders": [number(order) for order in measured.orders],
        "lines": [_line(name, kind) for name, kind in zip(names, measured.kinds, strict=True)],
        "not_compared": dict(result.not_compared),
        "detection_limits": [
            {"effect": one.effect, "at": one.at, "parameter": one.parameter, "size": number(one.size), "unit": one.unit}
            for one in result.detection_limits
        ],
        "remarks": list(result.remarks),
    }


def _cause(cause: Cause) -> dict[str, Any]:
    return {
        "effect": cause.effect,
        "at": cause.at,
        "probability": number(cause.probability),
        "parameters": {name: _estimate(one) for name, one in cause.parameters.items()},
        "check": cause.check,
    }


def _score(score: Score | None) -> dict[str, float | None]:
    """Return the figures of a hypothesis that was fitted; none of one that only had a first look."""
    return {
        "log_evidence": number(score.log_evidence) if score else None,
        "log_prediction": number(score.log_prediction) if score else None,
        "log_held_out": number(score.log_held_out) if score else None,
    }


def _form(form: ModelForm) -> dict[str, Any]:
    terms = [
        {
            "effect": one.effect,
            "at": one.at,
            "strength": one.strength,
            "value": _estimate(one.value),
            "speed_exponent": number(one.speed_exponent),
            "reference_speed_rpm": number(one.reference_speed_rpm),
            "order": None if one.order is None else number(one.order),
        }
        for one in form.terms
    ]
    return {"missed_before": number(form.missed_before), "missed": number(form.missed), "terms": terms}


def _force(force: AddedForce) -> dict[str, Any]:
    return {
        "order": number(force.order),
        "at": force.at,
        "or_at": list(force.or_at),
        "direction": force.direction,
        "amplitude": _estimate(force.amplitude),
        "phase": _estimate(force.phase),
        "speed_exponent": _estimate(force.speed_exponent),
        "load_exponent": _estimate(force.load_exponent) if force.load_exponent else None,
        "reference_speed_rpm": number(force.reference_speed_rpm),
        "reference_load": None if force.reference_load is None else number(force.reference_load),
        "share": number(force.share),
    }


def _estimate(one: Estimate) -> dict[str, Any]:
    ends = {"low": number(one.low), "high": number(one.high)}
    return {"value": number(one.value), **ends, "unit": one.unit, "is_told": one.is_told}


def _residual(line: ResidualLine, conditions: Sequence[Condition], names: Sequence[str]) -> dict[str, Any]:
    return {
        "probe": line.probe,
        "line": names[line.column],
        "order": number(line.order),
        "condition": _condition(conditions[line.condition]),
        "measured": _complex(line.measured),
        "simulated": _complex(line.simulated),
        "sigma": number(line.sigma),
    }


def _line(name: str, kind: LineKind) -> dict[str, Any]:
    return {
        "name": name,
        "phase": kind.phase,
        "envelope": kind.envelope,
        "frequency_hz": number(kind.frequency_hz),
    }


def _condition(condition: Condition) -> dict[str, float | None]:
    return {"speed_rpm": number(condition.speed_rpm), "load": number(condition.load)}


def _complex(value: complex) -> dict[str, float | None]:
    return {"real": number(value.real), "imaginary": number(value.imag)}


def _changed(result: GapResult) -> dict[str, dict[str, float | None]]:
    given, fitted, extended = result.machine.values, result.calibrated.values, result.extended.values
    return {
        name: {"given": number(given[name]), "fitted": number(value), "extended": number(extended[name])}
        for name, value in fitted.items()
        if {value, extended[name]} != {given[name]}
    }
