"""Lines simulated in time against those balanced in the frequency domain."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.lines import Condition, LineKind
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.simulators.effect import make_effect
from rotorwise.simulators.machine import find_machine

ORDERS = (1.0, 2.0, 3.0)


def _predictor(name: str, speeds_rpm: tuple[float, ...], rate_hz: float) -> Predictor:
    probes = [
        p.name for p in find_machine(name).bare_assembly().probes if p.quantity in ("displacement", "acceleration")
    ]
    count = len(speeds_rpm)
    kinds = (*(LineKind(),) * 3, LineKind(phase=False, frequency_hz=100.0))
    return Predictor(
        tuple(Condition(speed) for speed in speeds_rpm),
        tuple(probes),
        (*ORDERS, 0.0),
        (rate_hz,) * count,
        (40_000,) * count,
        kinds,
        (0,) * 4,
    )


@pytest.mark.parametrize(("name", "rate_hz"), [("test_rig", 4000.0), ("amb_rotor", 2000.0)])
def test_what_is_simulated_in_time_agrees_with_the_balance(name, rate_hz):
    predictor = _predictor(name, (1300.0, 1900.0), rate_hz)
    machine = find_machine(name)
    faulty = machine.with_effects(make_effect("unbalance", {"moment_kg_m": 1e-3}))
    balanced = predictor.amplitudes(faulty) - predictor.amplitudes(machine)
    in_time = _predictor(name, (1300.0, 1900.0), rate_hz)
    # As if the unbalance spoilt the repetition.
    in_time._spoiling[f"unbalance at {faulty.effects[0].at}"] = True
    in_time._simulate([("faulty", faulty, machine)], smooth=True)
    found = in_time._known["faulty"] - predictor.amplitudes(machine)
    assert np.abs(found - balanced).max() < 0.01 * np.abs(balanced).max()


def test_a_force_of_the_supply_leaves_the_shaft_s_orders_alone():
    predictor = _predictor("test_rig", (1300.0, 1900.0), 4000.0)
    machine = find_machine("test_rig")
    faulty = machine.with_effects(make_effect("twice_line_force", {"force_n": 5.0, "torque_n_m": 0.0}))
    change = predictor.amplitudes(faulty) - predictor.amplitudes(machine)
    assert np.abs(change[:, :, 3]).max() > 20 * np.abs(change[:, :, :3]).max()
