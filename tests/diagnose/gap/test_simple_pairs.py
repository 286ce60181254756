"""A pair of causes that a contact imitates: alone it is ahead of both, so that neither leads a pair."""

from typing import Any

import pytest
from rotorwise.datasets.recording import Campaign
from rotorwise.diagnose.gap.refine import Fit, nothing, refined
from rotorwise.diagnose.gap.simple_pairs import simple_pairs
from rotorwise.simulators import rigid_coupling
from rotorwise.simulators.effects.bolt_loss import BoltLoss
from rotorwise.simulators.effects.unbalance import Unbalance

from .made_campaigns import recorded, search_inputs

BOLT, UNBALANCE = (
    BoltLoss(at="flange", loss=0.6, angle_rad=3.1),
    Unbalance(at="rotor_1", moment_kg_m=0.04, angle_rad=1.2),
)
RIVALS = ("bolt_loss", "unbalance", "looseness")


@pytest.fixture(scope="module")
def begun() -> tuple[Any, ...]:
    """Return what the search is given: problem, screening."""
    real = rigid_coupling.with_parameters(support_2_n_m=1.04 * rigid_coupling.values["support_2_n_m"])
    speeds = (600.0, 850.0, 1050.0, 1450.0, 1750.0)
    options = {"rate_hz": 500.0, "duration_s": 5.0, "settle_s": 40.0}
    hidden, healthy = real.with_effects(BOLT, UNBALANCE), recorded(real, speeds[::2], seed=1, **options)
    campaign = Campaign(recorded(hidden, speeds, seed=11, **options), healthy)
    return search_inputs(campaign, rigid_coupling, only=frozenset(RIVALS))


def _single(begun: tuple[Any, ...], name: str) -> Fit:
    """Return the fit of an effect from its best start of the first look."""
    problem, screening, *_ = begun
    best = next(o[0] for o in screening.best() if o[0].candidate.name == name)
    found = refined([best.candidate], best.position, problem.plain(), problem.baseline.machine, problem.predictor)
    assert found is not None
    return found


def test_both_are_found_although_a_contact_is_ahead_of_each(begun):
    problem, screening, *_ = begun
    bolt, unbalance, contact = (_single(begun, name) for name in RIVALS)
    assert contact.log_evidence > max(bolt.log_evidence, unbalance.log_evidence) + 100
    none = nothing(problem.plain())
    found = simple_pairs([bolt, unbalance, contact], screening, problem, none, contact.log_evidence)
    assert found[0].names == ("bolt_loss", "unbalance")
    assert found[0].log_evidence > contact.log_evidence + 100
    values = {name: value for one in found[0].values() for name, value in one.items()}
    assert values["loss"] == pytest.approx(BOLT.loss, rel=0.1)
    assert values["moment_kg_m"] == pytest.approx(UNBALANCE.moment_kg_m, rel=0.1)
    # Contacts are in none of these pairs.
    assert all("looseness" not in fit.names for fit in found)
