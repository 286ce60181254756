"""Results of the gap engine made by hand, one of every kind, for the tests of words, files and pages."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from rotorwise.diagnose.gap.lines import Condition, OrderLines
from rotorwise.diagnose.gap.result import Cause, Estimate, Gain, GapResult, ResidualLine
from rotorwise.simulators.effect import Effect
from rotorwise.simulators.effects.shaft_bow import ShaftBow
from rotorwise.simulators.effects.unbalance import Unbalance
from rotorwise.simulators.machine import find_machine

CONDITIONS = (Condition(1500.0), Condition(2600.0), Condition(3300.0), Condition(4000.0))
PROBES = ("path_1", "path_2", "path_4")
ORDERS = (0.5, 1.0, 2.0, 3.0)
GAIN = Gain(11.84, 0.62, 1.1, -0.4, (1,))
NO_GAIN = Gain(math.nan, math.nan, math.nan, math.nan, ())
UNBALANCE = Unbalance(moment_kg_m=1.1e-4, angle_rad=0.7, at="disc")
PROBABILITIES = {
    "none": {(): 0.96, ("unknown",): 0.03, ("unbalance",): 0.01},
    "one cause": {("unbalance",): 0.97, ("shaft_bow",): 0.02, (): 0.01, ("unknown",): 1e-7},
    "several causes": {("shaft_bow", "unbalance"): 0.9, ("unbalance",): 0.08, ("unknown",): 0.02},
    "unknown": {("unknown",): 0.93, ("unbalance",): 0.05, (): 0.02},
    "cannot tell": {(): 0.4, ("unbalance",): 0.35, ("shaft_bow",): 0.25},
}


def cause_of(effect: Effect, *, probability: float, spread: float = 0.2) -> Cause:
    """Return the cause that a fit of an effect gives, its intervals a share of each value."""
    units = {one.name: one.unit for one in effect.parameters()}
    estimates = {
        name: Estimate(value, value - spread * abs(value), value + spread * abs(value), units[name])
        for name, value in effect.values().items()
    }
    return Cause(effect.NAME, effect.at, probability, estimates, effect.CHECK)


def made(kind: str, *, effects: Sequence[Effect] | None = None, seed: int = 0) -> GapResult:
    """Return a result of a kind: lines at random, 1X raised where there is something to find."""
    random = np.random.default_rng(seed)
    shape = (len(CONDITIONS), len(PROBES), len(ORDERS))
    before = 1e-6 * (random.normal(size=shape) + 1j * random.normal(size=shape))
    measured, deviations = before.copy(), np.full(shape, 2e-8)
    residuals: tuple[ResidualLine, ...] = ()
    if kind != "none":
        measured[:, :, 1] *= 4
        residuals = tuple(
            ResidualLine(PROBES[p], 1.0, c, 1, complex(measured[c, p, 1]), complex(before[c, p, 1]), 90.0 - 10 * c - p)
            for c in (0, 2, 3)
            for p in range(len(PROBES))
        )
    deviations[0, 0, 3] = np.inf
    found = {"one cause": [UNBALANCE], "several causes": [UNBALANCE, ShaftBow()]}.get(kind, [])
    acting = list(effects) if effects is not None else found
    machine = find_machine("amb_rotor")
    calibrated = machine.with_parameters(coupling_stiffness_n_m=81010.2)
    return GapResult(
        kind=kind,
        causes=tuple(cause_of(one, probability=0.97 - 0.1 * i) for i, one in enumerate(acting)),
        probabilities=PROBABILITIES[kind],
        indistinguishable=(("unbalance", "shaft_bow+unbalance"),) if kind == "one cause" else (),
        next_measurement="A recording at 1200 rpm would separate them" if kind in ("one cause", "cannot tell") else "",
        sentence="",
        residuals=residuals,
        gain=NO_GAIN if kind == "cannot tell" else GAIN,
        detectability=140.0,
        misfit=0.2,
        measured=OrderLines(CONDITIONS, PROBES, ORDERS, measured, deviations),
        before=before,
        after=before if kind == "none" else measured + 1e-8,
        machine=machine,
        calibrated=calibrated,
        extended=calibrated.with_effects(*acting),
        not_compared={"speed_wander": "nothing at constant speed", "rub": "nothing at constant speed"},
        remarks=("No healthy recording.",),
    )


def with_residuals(result: GapResult, *lines: ResidualLine) -> GapResult:
    """Return the result with other residuals."""
    return replace(result, residuals=lines)
