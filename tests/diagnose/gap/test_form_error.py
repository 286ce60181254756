"""Errors with the shape of what a model lacks: the machine between its healthy speeds is told better by them."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.baseline import Baseline, again
from rotorwise.diagnose.gap.calibration import calibrated, residual_error
from rotorwise.diagnose.gap.evidence import Comparison, comparison
from rotorwise.diagnose.gap.form_error import form_errors
from rotorwise.diagnose.gap.lacking_terms import lacking_terms
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.simulators import amb_rotor
from rotorwise.simulators.machine import Machine

from .made_campaigns import altered

HEALTHY_RPM, BETWEEN_RPM, TOP_RPM = (1200.0, 1700.0, 2300.0, 2900.0, 3500.0, 4100.0), (1450.0, 2600.0, 3800.0), 4100.0
ORDERS, NOISE_M = (1.0, 2.0, 3.0), 2e-8


def _predictor(speeds: tuple[float, ...]) -> Predictor:
    probes = tuple(one.name for one in amb_rotor.bare_assembly().probes)
    conditions, count = tuple(Condition(speed) for speed in speeds), len(speeds)
    kinds = (LineKind(),) * len(ORDERS)
    return Predictor(conditions, probes, ORDERS, (1e4,) * count, (20_000,) * count, kinds, (0,) * len(ORDERS))


def _lines(machine: Machine, speeds: tuple[float, ...], seed: int) -> OrderLines:
    predictor, generator = _predictor(speeds), np.random.default_rng(seed)
    lines = predictor.amplitudes(machine)
    noise = NOISE_M * (generator.normal(size=lines.shape) + 1j * generator.normal(size=lines.shape))
    return OrderLines(predictor.conditions, predictor.probes, ORDERS, lines + noise, np.full(lines.shape, NOISE_M))


def _with_many_small_springs(machine: Machine, share: float, seed: int) -> Machine:
    """Return the machine with all terms at once, each a small share of a standard deviation."""
    predictor, generator = _predictor(HEALTHY_RPM), np.random.default_rng(seed)
    terms = lacking_terms(calibrated(machine, _lines(machine, HEALTHY_RPM, 1), predictor), predictor,
                          reference_rpm=TOP_RPM)  # fmt: skip
    # Within what each allows: a weight pulls down.
    strengths = [{c.parameter.name: c.value(share * generator.normal()) for c in term.coordinates(0)} for term in terms]
    return machine.with_effects(*(one.effect.with_values(**own) for one, own in zip(terms, strengths, strict=True)))


def _compared(real: Machine, *, shaped: bool) -> Comparison:
    """Return lines of the machine between its healthy speeds against what those let expect."""
    healthy, lines = _lines(real, HEALTHY_RPM, 3), _lines(real, BETWEEN_RPM, 4)
    there, here = _predictor(HEALTHY_RPM), _predictor(BETWEEN_RPM)
    at_healthy: Baseline = calibrated(amb_rotor, healthy, there)
    baseline = again(at_healthy, at_healthy.machine, here)
    if shaped:
        errors = form_errors(at_healthy, healthy, there, reference_rpm=TOP_RPM)
        assert errors is not None
        assert 0.01 < errors.strength < 0.3
        baseline, at_healthy = errors.joined_to(baseline, here), errors.joined_to(at_healthy, there)
    return comparison(lines, baseline, healthy, at_healthy, residual_error(at_healthy, healthy))


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.slow
def test_lines_between_the_healthy_speeds_are_told_better_and_as_well_as_is_said(seed: int) -> None:
    real = _with_many_small_springs(altered(amb_rotor, share=0.03, seed=seed), 0.05, seed)
    plain, shaped = (_compared(real, shaped=one) for one in (False, True))
    away = [np.linalg.norm(one.lines.amplitudes - one.expected) for one in (plain, shaped)]
    assert away[1] < 0.5 * away[0]
    assert 0.3 < np.mean(shaped.residual**2) < 1.7


@pytest.mark.parametrize("seed", range(4))
def test_a_model_that_is_right_has_none(seed: int) -> None:
    healthy = _lines(altered(amb_rotor, share=0.03, seed=seed), HEALTHY_RPM, seed)
    predictor = _predictor(HEALTHY_RPM)
    found = calibrated(amb_rotor, healthy, predictor)
    assert form_errors(found, healthy, predictor, reference_rpm=TOP_RPM) is None


def test_two_healthy_speeds_tell_no_shape() -> None:
    healthy, predictor = _lines(amb_rotor, HEALTHY_RPM[:2], 1), _predictor(HEALTHY_RPM[:2])
    assert form_errors(calibrated(amb_rotor, healthy, predictor), healthy, predictor, reference_rpm=TOP_RPM) is None
