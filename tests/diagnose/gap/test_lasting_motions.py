"""Of which machines it is asked whether their periodic motion lasts."""

import pytest
from rotorwise.diagnose.gap.lines import Condition
from rotorwise.diagnose.gap.periodic import motions_in
from rotorwise.simulators import find_machine
from rotorwise.simulators.effects import EmpiricalStiffness, Looseness
from rotorwise.simulators.solvers.harmonic_balance import NoPeriodicMotionError

CONDITIONS = (Condition(560.0), Condition(980.0))


@pytest.fixture(scope="module")
def driven():
    """Return a machine with more cross-coupled stiffness than its damping holds: c w = 1.3e5 N/m at 40 Hz."""
    return find_machine("rigid_coupling").with_effects(EmpiricalStiffness(at="bearing_2", cross_n_m=4e5))


def test_a_machine_by_itself_has_its_motion_even_if_it_does_not_last(driven):
    # It was recorded, so it runs: a fitted stiffness is a little off, or something else holds the motion.
    (moving,) = motions_in(CONDITIONS, [driven], None, harmonics=8)
    assert isinstance(moving, list)
    assert len(moving) == len(CONDITIONS)


def test_a_machine_with_a_contact_is_asked(driven):
    loose = driven.with_effects(Looseness(at="support_1", loss=0.3))
    (asked,), (told,) = (motions_in(CONDITIONS, [loose], None, harmonics=8, lasting=known) for known in (False, True))
    assert isinstance(asked, NoPeriodicMotionError)
    assert isinstance(told, list)
