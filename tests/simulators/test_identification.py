"""Identification of coupling harmonics: response against harmonic balance, what data determine, honest intervals."""

import itertools

import numpy as np
import pytest
from rotorwise.simulators.coupling_response import coupling_response
from rotorwise.simulators.effects import CouplingMisalignment, CouplingStiffnessHarmonics, Unbalance
from rotorwise.simulators.errors import InvalidValueError
from rotorwise.simulators.identification import (
    Condition,
    complex_sensitivity,
    fft_amplitudes,
    identifiability,
    identify_by_least_squares,
    identify_by_swarm,
    summed_sensitivity,
)
from rotorwise.simulators.machine import find_machine
from rotorwise.simulators.particle_swarm import particle_swarm
from rotorwise.simulators.solvers.harmonic_balance import harmonic_balance

RPM = 4000.0
MACHINE = find_machine("amb_rotor")
MISALIGNED = MACHINE.with_effects(CouplingMisalignment(offset_m=5e-4, angle_rad=np.radians(1)))
TRUE = np.tile([0.3, 0.2, 0.05], (4, 1))
NOISE_M = 1e-7


def condition(machine, rpm=RPM, *, orders=4, seed=None, noise_m=NOISE_M):
    response = coupling_response(machine, speed_rpm=rpm)
    amplitudes = response.amplitudes(TRUE)[:, 1 : orders + 1]
    if seed is not None:
        generator = np.random.default_rng(seed)
        amplitudes = amplitudes + noise_m * (
            generator.normal(size=amplitudes.shape) + 1j * generator.normal(size=amplitudes.shape)
        )
    return Condition(response, amplitudes)


def test_coupling_response_equals_harmonic_balance():
    expected = harmonic_balance(MISALIGNED, speed_rpm=RPM).amplitudes
    found = coupling_response(MISALIGNED, speed_rpm=RPM).amplitudes(TRUE)
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


def test_coupling_response_with_sines_equals_harmonic_balance_of_a_turned_coupling():
    generator = np.random.default_rng(3)
    size, angle = generator.uniform(0, 0.2, (4, 3)), 0.8
    names = ("x", "y", "angle_x", "angle_y")
    values = {f"{d}_{n + 1}": size[i, n] for i, d in enumerate(names) for n in range(3)}
    bare = MISALIGNED.with_parameters(harmonic_1=0.0, harmonic_2=0.0, harmonic_3=0.0)
    expected = harmonic_balance(
        bare.with_effects(CouplingStiffnessHarmonics(**values, angle_rad=angle)), speed_rpm=RPM
    ).amplitudes
    turned = np.arange(1, 4) * angle
    found = coupling_response(bare, speed_rpm=RPM).amplitudes(size * np.cos(turned), size * np.sin(turned))
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())


def test_many_sets_at_once_are_the_sets_one_by_one():
    response = coupling_response(MISALIGNED, speed_rpm=RPM)
    sets = np.random.default_rng(0).uniform(0, 1, (5, 4, 3))
    np.testing.assert_allclose(response.amplitudes(sets), [response.amplitudes(one) for one in sets], rtol=1e-10)


def test_harmonics_converge_fast():
    reference = coupling_response(MISALIGNED, speed_rpm=RPM, highest_order=16).amplitudes(TRUE)
    errors = []
    for highest in (3, 4, 6, 8):
        found = coupling_response(MISALIGNED, speed_rpm=RPM, highest_order=highest).amplitudes(TRUE)
        errors.append(np.abs(found - reference[:, : highest + 1]).max() / np.abs(reference).max())
    assert errors[0] < 1e-3
    assert errors[3] < 1e-10
    assert all(later < 0.1 * earlier for earlier, later in itertools.pairwise(errors))


@pytest.mark.parametrize("method", ["sensitivity", "sensitivity_to_sin"])
def test_sensitivity_is_the_derivative(method):
    response = coupling_response(MISALIGNED, speed_rpm=RPM)
    found = getattr(response, method)(TRUE)
    width = 1e-4
    for direction, n in ((0, 0), (1, 2), (2, 1), (3, 0)):
        step = np.zeros_like(TRUE)
        step[direction, n] = width
        if method == "sensitivity":
            both = [response.amplitudes(TRUE + sign * step) for sign in (1, -1)]
        else:
            both = [response.amplitudes(TRUE, sign * step) for sign in (1, -1)]
        difference = (both[0] - both[1]) / (2 * width)
        np.testing.assert_allclose(found[:, :, direction, n], difference, atol=1e-6 * np.abs(difference).max())


def test_a_time_periodic_rotor_beside_the_coupling_is_refused():
    with pytest.raises(InvalidValueError, match="only the coupling"):
        coupling_response(_with_periodic_spring(), speed_rpm=RPM)


def _with_periodic_spring():
    from dataclasses import replace

    from rotorwise.simulators.law import InterfaceForce, Law

    def signals(timeline, parameters):
        cos, _ = timeline.cos_sin(2.0)
        return np.stack([np.zeros_like(cos), parameters[0] * cos])

    inner = MACHINE.definition

    def build(assembly, values, switches):
        inner.build(assembly, values, switches)
        across = assembly.places["disc"].directions["x"]
        assembly.forces.append(InterfaceForce("crack", Law("crack", signals), (1e4,), (across,), (across,)))

    return replace(MACHINE, definition=replace(inner, build=build))


def test_summed_amplitudes_determine_no_more_than_their_number():
    """Eq (14) makes M numbers of everything; 12 unknowns cannot follow. The complex amplitudes reach all of them."""
    for orders in (2, 3, 4):
        one = [condition(MISALIGNED, orders=orders)]
        summed = identifiability(summed_sensitivity(one, TRUE), noise_m=NOISE_M)
        assert summed.rank == orders
        assert summed.unknowns == 12
    assert identifiability(complex_sensitivity(one, TRUE), noise_m=NOISE_M).rank == 12


def test_summed_sensitivity_is_the_derivative_of_the_sums():
    one = condition(MISALIGNED)
    found = summed_sensitivity([one], TRUE)
    width = 1e-4
    for column in (0, 5, 7):
        step = np.zeros(12)
        step[column] = width
        sums = [
            np.abs(one.response.amplitudes(TRUE + sign * step.reshape(4, 3))[:, 1:5]).sum(axis=0) for sign in (1, -1)
        ]
        np.testing.assert_allclose(found[:, column], (sums[0] - sums[1]) / (2 * width), atol=1e-6 * np.abs(found).max())


def test_swarm_of_the_paper_fits_the_sums_and_finds_other_coefficients():
    one = [condition(MISALIGNED, orders=3)]
    results = [identify_by_swarm(one, harmonics=3, seed=seed) for seed in (1, 2)]
    size = np.abs(one[0].amplitudes).sum()
    for result in results:
        assert result.value < 1e-3 * size
        assert np.all((result.best >= 0) & (result.best <= 1))
    # As good a fit, another coupling: more than 0.3 apart from each other and from the truth.
    assert np.abs(results[0].best - results[1].best).max() > 0.3
    assert min(np.abs(result.best - TRUE.ravel()).max() for result in results) > 0.3


def test_least_squares_finds_the_truth_and_its_intervals_hold_it():
    conditions = [
        lambda seed: condition(MISALIGNED, seed=seed),
        lambda seed: condition(MACHINE.with_effects(CouplingMisalignment(offset_m=5e-4, angle_rad=0.0)), seed=seed),
        lambda seed: condition(MISALIGNED, 2580.0, seed=seed),
    ]
    inside = []
    for seed in range(12):
        found = identify_by_least_squares(
            [make(100 * seed + i) for i, make in enumerate(conditions)], harmonics=3, noise_m=NOISE_M
        )
        inside.append(np.abs(found.coefficients - TRUE) <= found.half_width_95)
        assert found.residual_m == pytest.approx(NOISE_M, rel=0.35)
    # 144 intervals of 95 %: fewer than 128 or all of 144 inside by chance has probability below 1e-3.
    assert 128 <= np.sum(inside) < 144
    # Translation is seen, rotation hardly: 140 N.m/rad is soft against 81 kN/m on the rotor's lever.
    assert found.half_width_95[:2].max() < 0.05
    assert found.half_width_95[2:].max() > 5 * found.half_width_95[:2].max()


def test_without_excitation_nothing_is_known():
    """Exact limit: no vibration leaves every coefficient open."""
    response = coupling_response(MACHINE.with_parameters(unbalance_kg_m=0.0), speed_rpm=RPM)
    assert not response.amplitudes(TRUE).any()
    assert not response.sensitivity(TRUE).any()


def test_noise_free_data_give_the_truth_back():
    one = condition(MISALIGNED.with_effects(Unbalance(at="coupling_hub", moment_kg_m=1e-4, angle_rad=1.0)))
    found = identify_by_least_squares([one], harmonics=3, noise_m=NOISE_M)
    np.testing.assert_allclose(found.coefficients, TRUE, atol=1e-6)


def test_fft_amplitude_reads_too_low_between_lines():
    """A record of T seconds has lines 1 / T apart; a third of a line off reads sinc(1/3) = 0.827."""
    time = np.arange(20_000) / 20_000
    signals = np.array([2.0 + 3.0 * np.cos(2 * np.pi * 4000 / 60 * time), 5 * np.sin(2 * np.pi * 200 * time)])
    found = fft_amplitudes(signals, rate_hz=20_000, speed_rpm=4000, orders=3)
    # Leakage of the mirror line at -66.7 Hz adds up to 1 / (2 pi 67).
    assert found[0, 0] == pytest.approx(3 * np.sinc(1 / 3), rel=0.01)
    assert found[1, 2] == pytest.approx(5, rel=1e-9)


def test_fft_amplitude_of_an_order_beyond_the_record_is_refused():
    with pytest.raises(InvalidValueError, match="order 3"):
        fft_amplitudes(np.zeros((1, 200)), rate_hz=200, speed_rpm=2400, orders=3)


def test_swarm_finds_the_minimum_of_a_known_function():
    target = np.array([0.2, -0.7, 0.5])
    result = particle_swarm(
        lambda points: ((points - target) ** 2).sum(axis=1), low=-np.ones(3), high=np.ones(3), seed=5
    )
    np.testing.assert_allclose(result.best, target, atol=1e-4)
    assert np.all(np.diff(result.history) <= 0)
    corner = particle_swarm(lambda points: points.sum(axis=1), low=-np.ones(2), high=np.ones(2), seed=5)
    np.testing.assert_allclose(corner.best, [-1, -1], atol=1e-9)


def test_swarm_depends_on_its_seed_only():
    def rosenbrock(points):
        return (1 - points[:, 0]) ** 2 + 100 * (points[:, 1] - points[:, 0] ** 2) ** 2

    bounds = {"low": np.array([-2.0, -2.0]), "high": np.array([2.0, 2.0])}
    first, same, other = (particle_swarm(rosenbrock, seed=seed, iterations=20, **bounds) for seed in (1, 1, 2))
    assert np.array_equal(first.history, same.history)
    assert not np.array_equal(first.history, other.history)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: Condition(coupling_response(MACHINE, speed_rpm=RPM), np.zeros((3, 2))), "4 probes"),
        (lambda: identify_by_swarm([], harmonics=3, seed=0), "0 conditions"),
        (lambda: identify_by_least_squares([condition(MACHINE)], harmonics=3, noise_m=0.0), "Noise"),
        (lambda: coupling_response(MACHINE, speed_rpm=RPM, highest_order=2).amplitudes(TRUE), "highest_order"),
        (lambda: particle_swarm(lambda p: p[:, 0], low=np.ones(1), high=np.ones(1), seed=0), "low below high"),
    ],
)
def test_wrong_values_are_refused(call, words):
    with pytest.raises(InvalidValueError, match=words):
        call()
