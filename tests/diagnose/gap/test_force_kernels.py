"""What unknown forces make of the lines, against effects that are such forces."""

import numpy as np
import pytest
from rotorwise.diagnose.gap.force_kernels import force_kernels
from rotorwise.diagnose.gap.lines import Condition, LineKind
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.simulators import amb_rotor
from rotorwise.simulators.effects.unbalance import Unbalance

SPEEDS_RPM = (1500.0, 2600.0, 3300.0)


def _predictor() -> Predictor:
    probes = tuple(probe.name for probe in amb_rotor.bare_assembly().probes)
    count = len(SPEEDS_RPM)
    conditions = tuple(Condition(speed) for speed in SPEEDS_RPM)
    return Predictor(conditions, probes, (1.0,), (4000.0,) * count, (12_000,) * count, (LineKind(),), (0,))


def _evidence(kernel: np.ndarray, lines: np.ndarray) -> float:
    """Return the log density of lines (conditions, probes) of rms 1 under a kernel of that power, in 1 % of noise."""
    parts = np.concatenate([lines.real.ravel(), lines.imag.ravel()])
    flat, size = parts / np.sqrt((parts**2).mean()), parts.size
    whole = kernel.reshape(size, size)
    covariance = whole * size / np.trace(whole) + 1e-4 * np.eye(size)
    return 0.5 * float(-flat @ np.linalg.solve(covariance, flat) - np.linalg.slogdet(covariance)[1])


def test_what_is_fixed_to_the_shaft_turns() -> None:
    predictor = _predictor()
    unbalances = [Unbalance(at=at, moment_kg_m=1e-4, angle_rad=0.4) for at in ("disc", "coupling_hub", "bearing_1")]
    machine = amb_rotor.with_effects(*unbalances)
    lines = (predictor.amplitudes(machine) - predictor.amplitudes(amb_rotor))[:, :, 0]
    kernels = force_kernels(amb_rotor, predictor)
    best = max(kernels, key=lambda one: _evidence(one.lines(0), lines))
    # First come forces of any direction at all places by four laws, then turning ones; the last law is speed squared.
    assert best is kernels[7]
    assert _evidence(best.lines(0), lines) > _evidence(kernels[3].lines(0), lines) + 3


@pytest.mark.parametrize("place", ["disc", "coupling_hub"])
def test_at_a_place_act_forces_and_moments(place: str) -> None:
    kernels = [one for one in force_kernels(amb_rotor, _predictor()) if one.at == place]
    assert len(kernels) == 8
    # In one condition all real and imaginary parts follow from those of two complex amplitudes, in x and in y.
    own = [one.lines(0)[:, 0, :, :, 0].reshape(2 * [2 * one.moved.shape[3]]) for one in kernels]
    assert {int(np.linalg.matrix_rank(one, tol=1e-9 * np.abs(one).max())) for one in own} == {4}
