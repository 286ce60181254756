"""A pair of causes that a contact imitates: alone it is ahead of both, so that neither leads a pair."""

import pytest
from rotorwise.datasets.recording import Campaign
from rotorwise.diagnose.gap.explain import explain_gap
from rotorwise.simulators import rigid_coupling
from rotorwise.simulators.effects.bolt_loss import BoltLoss
from rotorwise.simulators.effects.unbalance import Unbalance

from .made_campaigns import recorded

BOLT, UNBALANCE = (
    BoltLoss(at="flange", loss=0.6, angle_rad=3.1),
    Unbalance(at="rotor_1", moment_kg_m=0.04, angle_rad=1.2),
)
RIVALS = frozenset(("bolt_loss", "unbalance", "looseness"))


@pytest.fixture(scope="module")
def both() -> Campaign:
    real = rigid_coupling.with_parameters(support_2_n_m=1.04 * rigid_coupling.values["support_2_n_m"])
    speeds = (600.0, 850.0, 1050.0, 1450.0, 1750.0)
    options = {"rate_hz": 500.0, "duration_s": 5.0, "settle_s": 40.0}
    hidden, healthy = real.with_effects(BOLT, UNBALANCE), recorded(real, speeds[::2], seed=1, **options)
    return Campaign(recorded(hidden, speeds, seed=11, **options), healthy)


def test_both_are_found(both):
    answer = explain_gap(both, rigid_coupling, only=RIVALS)
    assert {cause.effect for cause in answer.causes} == {"bolt_loss", "unbalance"}
    found = {name: value for cause in answer.causes for name, value in cause.parameters.items()}
    assert found["loss"].low < BOLT.loss < found["loss"].high
    assert found["moment_kg_m"].low < UNBALANCE.moment_kg_m < found["moment_kg_m"].high
    assert answer.gain.held_out_db > answer.gain.calibration_only_db + 6
