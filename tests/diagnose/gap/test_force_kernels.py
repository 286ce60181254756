"""What unknown forces make of the lines, against effects that are such forces."""

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.diagnose.gap.baseline import Baseline
from rotorwise.diagnose.gap.evidence import comparison
from rotorwise.diagnose.gap.force_kernels import force_kernels
from rotorwise.diagnose.gap.lines import Condition, LineKind, OrderLines
from rotorwise.diagnose.gap.predict import Predictor
from rotorwise.diagnose.gap.unknown_force import unexplained
from rotorwise.simulators import amb_rotor
from rotorwise.simulators.effects.empirical_force import EmpiricalForce
from rotorwise.simulators.effects.unbalance import Unbalance

SPEEDS_RPM = (1500.0, 2600.0, 3300.0)


def _predictor() -> Predictor:
    probes = tuple(probe.name for probe in amb_rotor.bare_assembly().probes)
    count = len(SPEEDS_RPM)
    conditions = tuple(Condition(speed) for speed in SPEEDS_RPM)
    return Predictor(conditions, probes, (1.0,), (4000.0,) * count, (12_000,) * count, (LineKind(),), (0,))


def test_sizes_without_phase_have_none() -> None:
    assert force_kernels(amb_rotor, replace(_predictor(), kinds=(LineKind(phase=False),))) == ()


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
    own = [one.lines(0)[:, 0, :, :, 0].reshape(2 * [2 * one.moved.shape[4]]) for one in kernels]
    assert {int(np.linalg.matrix_rank(one, tol=1e-9 * np.abs(one).max())) for one in own} == {4}


def _two_orders() -> tuple[Predictor, tuple[Condition, ...]]:
    one = _predictor()
    kinds = (LineKind(), LineKind())
    return Predictor(one.conditions, one.probes, (1.0, 2.0), one.rates_hz, one.samples, kinds, (0, 0)), one.conditions


def test_a_force_makes_lines_at_other_orders_where_a_stiffness_changes_with_the_angle() -> None:
    predictor, _ = _two_orders()
    place = next(one for one in force_kernels(amb_rotor, predictor) if one.at == "disc")
    for part, phase_rad in enumerate((0.0, np.pi / 2)):
        push = EmpiricalForce(at="disc", force_n=1e-3, order=1.0, direction_rad=0.0, phase_rad=phase_rad)
        lines = (predictor.amplitudes(amb_rotor.with_effects(push)) - predictor.amplitudes(amb_rotor)) / 1e-3
        found = place.moved[part][:, :, 0, :, 0].transpose(0, 2, 1)
        assert found == pytest.approx(lines, rel=1e-3, abs=1e-3 * np.abs(lines[:, :, 1]).max())
        assert np.abs(lines[:, :, 1]).max() > 0.01 * np.abs(lines).max()


def test_what_an_unknown_unbalance_makes_at_twice_the_speed_is_no_further_unknown() -> None:
    predictor, conditions = _two_orders()
    plain = predictor.amplitudes(amb_rotor)
    added = predictor.amplitudes(amb_rotor.with_effects(Unbalance(at="disc", moment_kg_m=3e-5, angle_rad=0.4))) - plain
    noise = np.full(plain.shape, 0.02 * np.abs(added[:, :, 1]).max())
    bare = np.zeros(0)
    own = Baseline(amb_rotor, (), bare, bare, bare.astype(bool), plain, np.zeros((0, *plain.shape)), bare, bare, bare)
    lines = OrderLines(conditions, predictor.probes, predictor.orders, plain + added, noise)
    compared = comparison(lines, own, None, None, np.zeros(plain.shape[1:]))
    kernels = force_kernels(amb_rotor, predictor)
    assert set(unexplained(compared, kernels).kernels) == {0}
    apart = [replace(one, moved=one.moved * np.eye(2)[:, :, None, None]) for one in kernels]
    assert set(unexplained(compared, apart).kernels) == {0, 1}
    # Twice as large as the force at 1X makes it, and of another sign, it is something else.
    other = replace(lines, amplitudes=plain + added * np.array([1.0, -2.0]))
    compared = comparison(other, own, None, None, np.zeros(plain.shape[1:]))
    assert set(unexplained(compared, kernels).kernels) == {0, 1}
