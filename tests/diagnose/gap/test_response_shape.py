"""What saves evaluations of the first look: proportional strengths, angles that only turn, small influences."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.coordinates import coordinates_of
from rotorwise.diagnose.gap.hypotheses import Candidate
from rotorwise.diagnose.gap.response_shape import ResponseShape, scaled_strengths
from rotorwise.simulators.effect import effect_catalogue

ORDERS = np.array([1.0, 2.0])


class Made:
    """Lines (conditions, probes, orders) of a made-up effect with a strength and an angle, on two probes."""

    orders = ORDERS

    def __init__(self, second_probe=lambda strength, angle: 0.0, power=1.0):
        self.second_probe, self.power = second_probe, power

    def __call__(self, position):
        strength, angle = ONE.coordinates[0].value(position[0]), ONE.coordinates[1].value(position[1])
        lines = np.zeros((1, 2, 2), dtype=complex)
        lines[0, 0] = strength**self.power * np.exp(1j * ORDERS * angle)
        lines[0, 1] = self.second_probe(strength, angle)
        return lines


def _one() -> Candidate:
    effect = effect_catalogue()["unbalance"]()
    return Candidate(effect, coordinates_of(effect.parameters()))


ONE = _one()
NOISE = np.full((1, 2, 2), 1e-6)


def shape(response) -> ResponseShape:
    centre = np.zeros(2)
    return ResponseShape(ONE, response, centre, response(centre), NOISE)


def test_a_law_of_proportion_is_seen_and_another_is_not():
    assert shape(Made()).is_proportional((0,))
    assert not shape(Made(power=1.3)).is_proportional((0,))


def test_an_angle_that_turns_every_order_is_seen_and_one_that_bends_the_response_is_not():
    assert shape(Made()).only_turns(1)
    middle = ONE.coordinates[0].value(0.0)
    assert not shape(Made(second_probe=lambda strength, angle: 0.5 * middle * np.cos(angle))).only_turns(1)


@pytest.mark.parametrize("multiple", [1, 2, 3, 5])
def test_an_angle_matters_whatever_multiple_of_it_acts(multiple):
    middle = ONE.coordinates[0].value(0.0)
    found = shape(Made(second_probe=lambda strength, angle: 0.5 * middle * np.cos(multiple * angle)))
    assert found.matters(1)


def test_what_is_far_below_the_clearest_probe_is_not_asked():
    # Rounding at a probe that the effect does not reach.
    generator = np.random.default_rng(1)
    middle = ONE.coordinates[0].value(0.0)
    found = shape(Made(second_probe=lambda strength, angle: 1e-4 * middle * generator.normal()))
    assert found.is_proportional((0,))
    assert found.only_turns(1)


def test_strengths_are_scaled_from_where_the_effect_is_absent_and_stay_within_bounds():
    twice = scaled_strengths(ONE, np.zeros(2), (0,), 2.0)
    assert ONE.coordinates[0].value(twice[0]) == pytest.approx(2 * ONE.coordinates[0].value(0.0))
    assert scaled_strengths(ONE, np.zeros(2), (0,), 1e12) is None
