"""Ranked findings: every rule of ``faults/`` asked, answers merged, weak ones dropped."""

from __future__ import annotations

import importlib
import pkgutil
from dataclasses import replace
from functools import cache
from types import ModuleType

from . import faults
from .observe import Observation
from .result import FAULTS, Finding

#: Findings below this are not shown: nothing evident.
LEAST_PROBABILITY = 0.10
#: Turns of the shaft that a record must have before any line is named.
LEAST_TURNS = 10.0


@cache
def rules() -> tuple[ModuleType, ...]:
    """Return the rule modules of ``faults/``, found by scanning the folder."""
    names = sorted(module.name for module in pkgutil.iter_modules(faults.__path__))
    return tuple(importlib.import_module(f"{faults.__name__}.{name}") for name in names)


def judge(now: Observation, baseline: Observation | None = None) -> tuple[Finding, ...]:
    """Return the findings, likeliest first; empty when nothing is evident.

    Parameters
    ----------
    now : Observation
    baseline : Observation or None
        A record of the same machine when it was healthy; the change is judged then.
    """
    if not now.turning or not now.turns >= LEAST_TURNS:
        # Whatever the sensor shows, it is not the machine running; only the measurement itself can be judged.
        return tuple(one for one in _collect(now, baseline) if one.fault == "sensor_fault")
    return tuple(_collect(now, baseline))


def _collect(now: Observation, baseline: Observation | None) -> list[Finding]:
    found: list[Finding] = []
    for rule in rules():
        found += rule.judge(now, baseline)
    trust = 1.0 if now.speed is None or now.speed.method != "vibration" else now.speed.confidence
    # Every line is named by the speed: where that is in doubt, so is the name.
    found = [one if one.fault == "sensor_fault" else replace(one, probability=one.probability * trust) for one in found]
    return merged([one for one in found if one.probability >= LEAST_PROBABILITY])


def merged(findings: list[Finding]) -> list[Finding]:
    """Return one finding a fault: probabilities join as independent evidence, the likeliest's words stand first."""
    result = []
    for fault in FAULTS:
        same = sorted((one for one in findings if one.fault == fault), key=lambda one: -one.probability)
        if not same:
            continue
        absent = 1.0
        for one in same:
            absent *= 1.0 - one.probability
        lines = tuple(line for one in same for line in one.lines)
        summary = " ".join(dict.fromkeys(one.summary for one in same))
        result.append(replace(same[0], probability=min(1.0 - absent, 0.99), lines=lines, summary=summary))
    return sorted(result, key=lambda one: -one.probability)
