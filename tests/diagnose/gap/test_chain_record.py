"""A chain that adds lines of low frequency shows the same lines at a lower rate."""

import math
from dataclasses import replace

import numpy as np
import pytest
from rotorwise.diagnose.gap import predict
from rotorwise.diagnose.gap.chain_record import rate_enough
from rotorwise.diagnose.gap.lines import Condition, LineKind
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.simulators import test_rig
from rotorwise.simulators.effect import make_effect

RATE_HZ, SPEED_RPM = 25_600.0, 1483.0
HUM = {"amplitude": 0.02, "supply_hz": 50.0, "second": 0.3, "third": 0.5, "angle_rad": 0.3}
KINDS = (
    LineKind(),
    LineKind(),
    LineKind(phase=False, frequency_hz=50.0),
    LineKind(phase=False, frequency_hz=150.0),
    LineKind(phase=False, frequency_hz=5000.0),
    LineKind(phase=False, envelope=True),
)
ORDERS = (1.0, 2.0, 0.0, 0.0, 0.0, 4.94)


def _predictor() -> Predictor:
    probes = tuple(one.name for one in test_rig.bare_assembly().probes if one.quantity == "acceleration")
    samples = (round(8 * RATE_HZ),)
    return Predictor((Condition(SPEED_RPM),), probes, ORDERS, (RATE_HZ,), samples, KINDS, (0,) * len(ORDERS))


@pytest.mark.parametrize("more", [(), (("remounted_sensor", {"gain_change": 0.1}),)])
def test_hum_makes_the_same_lines_at_a_lower_rate(monkeypatch: pytest.MonkeyPatch, more: tuple) -> None:
    effects = [make_effect("mains_hum", HUM, at="housing_a_x"), *(make_effect(*one, at="housing_b_y") for one in more)]
    machine, rates = test_rig.with_effects(*effects), []

    def noted(*chain, **of_motion):
        rates.append(rate_enough(*chain, **of_motion))
        return rates[-1]

    monkeypatch.setattr(predict, "rate_enough", noted)
    lower = _predictor().amplitudes(machine)
    monkeypatch.setattr(predict, "rate_enough", lambda *_, rate_hz, **__: rate_hz)
    full = _predictor().amplitudes(machine)
    assert max(rates) < RATE_HZ / 20
    row = _predictor().probes.index("housing_a_x")
    changed = np.abs(full - _predictor().amplitudes(test_rig))[0, row]
    assert changed[2] > 0
    assert changed[3] > 0
    np.testing.assert_allclose(lower, full, atol=1e-3 * float(changed[2]))


@pytest.mark.parametrize(
    ("name", "values", "rate_hz"),
    [
        # What it does depends on each sample.
        ("clipping", {"lost_range": 0.5}, RATE_HZ),
        # A band of the envelope that the motion's own orders reach into.
        ("mains_hum", HUM, 1000.0),
    ],
)
def test_others_are_sampled_as_they_were_recorded(name: str, values: dict[str, float], rate_hz: float) -> None:
    machine = test_rig.with_effects(make_effect(name, values, at="housing_a_x"))
    speed_rad_s = SPEED_RPM * math.pi / 30
    how = {"speed_rad_s": speed_rad_s, "highest_order": 20.0, "least_s": 1.0, "rate_hz": rate_hz}
    assert rate_enough(machine, machine.bare_assembly().probes, **how) == rate_hz


def test_it_holds_what_the_chain_adds_and_the_motion_has() -> None:
    machine = test_rig.with_effects(make_effect("mains_hum", HUM, at="housing_a_x"))
    how = {"speed_rad_s": 2 * math.pi * 20, "least_s": 2.0, "rate_hz": RATE_HZ}
    probes = machine.bare_assembly().probes
    of_hum, of_motion = (rate_enough(machine, probes, highest_order=top, **how) for top in (2.0, 40.0))
    assert 150 / 0.4 < of_hum < 200 / 0.4
    assert 800 / 0.4 < of_motion < 900 / 0.4
    without = replace(machine, effects=())
    assert rate_enough(without, probes, highest_order=2.0, **how) < 60 / 0.4
