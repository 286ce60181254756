"""Standard coordinates: values and priors there and back."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rotorwise.diagnose.gap.coordinates import Coordinate, log_prior
from rotorwise.simulators.parameter import LogNormal, Normal, Parameter, Uniform


def _coordinate(prior, unit="", bounds=(-1e9, 1e9), period=2 * math.pi) -> Coordinate:
    return Coordinate(Parameter("p", unit, prior.median, bounds, "a number", "test", prior, period=period))


PRIORS = [LogNormal(2.0, 3.0), Normal(-1.0, 0.5), Uniform(2.0, 5.0)]


@pytest.mark.parametrize("prior", PRIORS)
@settings(deadline=None)
@given(z=st.floats(-3, 3))
def test_value_and_back(prior, z):
    one = _coordinate(prior)
    assert one.coordinate(one.value(z)) == pytest.approx(z, abs=1e-6)


@pytest.mark.parametrize("prior", PRIORS)
def test_the_prior_in_the_coordinate_is_the_prior_of_the_value(prior):
    # p(z) = p(value) |d value / d z|, by central differences.
    one = _coordinate(prior)
    for z in (-1.3, 0.0, 0.7):
        slope = (one.value(z + 1e-5) - one.value(z - 1e-5)) / 2e-5
        expected = prior.log_density(one.value(z)) + math.log(slope)
        assert log_prior([one], np.array([z])) == pytest.approx(expected, abs=1e-6)


def test_a_strength_may_be_of_another_size():
    one = Coordinate(Parameter("p", "N", 2.0, (0.0, 1e9), "a number", "test", LogNormal(2.0, 3.0), zero=0.0))
    z = np.linspace(-40, 40, 80_001)
    density = np.exp([log_prior([one], np.array([at])) for at in z])
    assert density.sum() * (z[1] - z[0]) == pytest.approx(1.0, abs=1e-6)
    # A thousand times the median: one machine in some thousands, not in 10^9.
    assert log_prior([one], np.array([6.3])) > -7.0
    assert log_prior([one], np.array([0.0])) == pytest.approx(-0.5 * math.log(2 * math.pi), abs=0.1)


def test_an_angle_has_no_ends():
    one = _coordinate(Uniform(-math.pi, math.pi), unit="rad", bounds=(-2 * math.pi, 2 * math.pi))
    assert one.is_angle
    assert one.value(0.3 + 4 * math.pi) == pytest.approx(0.3)
    assert log_prior([one], np.array([17.0])) == pytest.approx(-math.log(2 * math.pi))
    assert not _coordinate(Uniform(0.0, math.pi), unit="rad").is_angle


def test_an_angle_that_repeats_within_a_turn_is_known_to_its_period():
    one = _coordinate(Uniform(-math.pi, math.pi), unit="rad", bounds=(-math.pi, math.pi), period=math.pi / 2)
    assert one.is_angle
    assert one.value(0.3 + math.pi / 2) == pytest.approx(0.3)
    assert one.coordinate(0.3 - math.pi) == pytest.approx(0.3)
    # All the places that do the same are one: its density is that of a flat prior over one period.
    assert log_prior([one], np.array([0.3])) == pytest.approx(-math.log(math.pi / 2))
    assert one.least_precision == pytest.approx(1 / (math.pi / 2 / math.sqrt(12)) ** 2)
    assert max(one.quantiles(8)) < math.pi / 2


@pytest.mark.parametrize("prior", PRIORS)
def test_quantiles_are_equally_likely(prior):
    from scipy.special import ndtr

    assert ndtr(_coordinate(prior).quantiles(5)) == pytest.approx([0.1, 0.3, 0.5, 0.7, 0.9])


def test_values_stay_within_bounds():
    assert _coordinate(LogNormal(1.0, 3.0), bounds=(0.5, 2.0)).value(5.0) == 2.0
