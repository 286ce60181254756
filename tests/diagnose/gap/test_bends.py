"""Lines near a resonance between the healthy speeds: as uncertain as the machines that the healthy lines leave open."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.baseline import again
from rotorwise.diagnose.gap.bends import with_bends
from rotorwise.diagnose.gap.calibration import calibrated, residual_error
from rotorwise.diagnose.gap.evidence import comparison
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.simulators.effects.residual_coupling_harmonic import ResidualCouplingHarmonic
from rotorwise.simulators.machine import Machine, find_machine

from .made_campaigns import altered

#: 3X along the shaft passes a resonance of the rig on its mounts between the healthy speeds.
PUSHED = find_machine("test_rig").with_effects(
    ResidualCouplingHarmonic(order=3.0, x_cosine_n=0.0, axial_cosine_n=0.05, y_sine_n=0.05)
)
HEALTHY_RPM, BETWEEN_RPM = (1080.0, 1380.0, 1740.0, 2190.0, 2670.0, 3060.0), (1560.0, 2430.0, 2940.0)
ORDERS, NOISE = (1.0, 2.0, 3.0), 1e-4


def _predictor(speeds: tuple[float, ...]) -> Predictor:
    probes = tuple(one.name for one in PUSHED.bare_assembly().probes if one.quantity == "acceleration")
    conditions, count = tuple(Condition(speed) for speed in speeds), len(speeds)
    kinds = (LineKind(),) * len(ORDERS)
    return Predictor(conditions, probes, ORDERS, (5e3,) * count, (25_000,) * count, kinds, (0,) * len(ORDERS))


def _lines(machine: Machine, speeds: tuple[float, ...], seed: int) -> OrderLines:
    predictor, generator = _predictor(speeds), np.random.default_rng(seed)
    lines = predictor.amplitudes(machine)
    noise = NOISE * (generator.normal(size=lines.shape) + 1j * generator.normal(size=lines.shape))
    return OrderLines(predictor.conditions, predictor.probes, ORDERS, lines + noise, np.full(lines.shape, NOISE))


def _misfits(seed: int) -> list[float]:
    """Return the mean square of the whitened lines of a healthy machine between its healthy speeds.

    By its slopes alone, and with its bends.
    """
    real = altered(PUSHED, share=0.06, seed=seed)
    healthy, lines = _lines(real, HEALTHY_RPM, 3), _lines(real, BETWEEN_RPM, 4)
    there, here = _predictor(HEALTHY_RPM), _predictor(BETWEEN_RPM)
    plain = calibrated(PUSHED, healthy, there)
    baseline = again(plain, plain.machine, here)
    bent = with_bends(plain, healthy, [(baseline, here), (plain, there)])
    sets = ((baseline, plain), bent)
    found = [comparison(lines, at, healthy, known, residual_error(known, healthy)) for at, known in sets]
    return [float(np.mean(one.residual**2)) for one in found]


def test_lines_near_a_resonance_that_no_healthy_speed_met_are_less_surprising() -> None:
    # Of eight machines so made the slopes tell two wrongly; this is the first.
    plain, bent = _misfits(2)
    assert plain > 10
    assert bent < 0.5 * plain


def test_lines_that_the_slopes_tell_stay_as_certain() -> None:
    plain, bent = _misfits(1)
    assert plain < 1.5
    assert bent == pytest.approx(plain, rel=0.1)
