"""Angles of effects: a period further on they do the same, half a period further on they do not."""

import math

import numpy as np
import pytest
from rotorwise.simulators.assembly import MissingPartError
from rotorwise.simulators.effect import effect_catalogue, make_effect
from rotorwise.simulators.machine import Machine, machine_catalogue
from rotorwise.simulators.parameter import Uniform

ANGLES = [
    (name, declared)
    for name, effect in effect_catalogue().items()
    for declared in effect.parameters()
    if declared.unit == "rad" and isinstance(declared.prior, Uniform)
]


def recorded(machine: Machine, name: str, **values: float) -> np.ndarray:
    changed = machine.with_effects(make_effect(name, values))
    signals = changed.simulate(speed_rpm=2400.0, duration_s=0.06, rate_hz=4000.0, seed=1, settle_s=0.0).signals
    # A shaft that nothing twists does not twist.
    return signals / np.maximum(np.abs(signals).max(axis=1, keepdims=True), 1e-300)


@pytest.mark.parametrize(("name", "declared"), ANGLES, ids=[f"{name} {p.name}" for name, p in ANGLES])
def test_an_angle_repeats_after_its_period_and_not_before(name, declared):
    start, changes = 0.3 - declared.period / 2, False
    for machine in machine_catalogue().values():
        values = [{declared.name: start + share * declared.period} for share in (0.0, 1.0, 0.5)]
        try:
            here, again, between = (recorded(machine, name, **own) for own in values)
        except MissingPartError:
            continue
        assert np.allclose(again, here, rtol=0, atol=1e-6)
        changes = not np.allclose(between, here, rtol=0, atol=1e-6)
        # A part that only twists, or carries no load, has no direction: another machine's does.
        if changes:
            break
    assert changes
    assert 2 * math.pi / declared.period == pytest.approx(round(2 * math.pi / declared.period))
