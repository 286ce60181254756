"""What something unknown makes passes through the machine no more exactly than what an effect makes."""

from dataclasses import replace

import numpy as np
import pytest
from rotorwise.diagnose.gap.evidence import PROBE_TOLERANCE, comparison
from rotorwise.diagnose.gap.lines import Condition, OrderLines
from rotorwise.diagnose.gap.model_error import similarity
from rotorwise.diagnose.gap.transfer_error import TransferError
from rotorwise.diagnose.gap.unknown_force import _as_it_passes, unexplained

from .test_gap_evidence import _baseline

SHARE = np.array([[0.3, 0.0], [0.2, 0.0]])
LENGTH = 0.1


def test_a_covariance_of_lines_grows_as_that_of_lines_with_wrong_ways():
    generator = np.random.default_rng(2)
    shape = (3, 2, 2)
    conditions = tuple(Condition(speed) for speed in (600.0, 700.0, 1300.0))
    lines = OrderLines(conditions, ("a", "b"), (1.0, 2.0), np.ones(shape, dtype=complex), np.ones(shape))
    plain = comparison(lines, _baseline(3, np.array([0.5]), np.zeros(1)), None, None, np.full((2, 2), 0.3))
    compared = replace(plain, transfer=TransferError(SHARE, np.eye(2, dtype=bool), length=LENGTH))
    draws = 200_000

    def normal(*size: int) -> np.ndarray:
        return generator.normal(size=(draws, *size)) + 1j * generator.normal(size=(draws, *size))

    way = generator.normal(size=shape[:2]) + 1j * generator.normal(size=shape[:2])
    smooth = np.linalg.cholesky(similarity(conditions, LENGTH))
    wrong = PROBE_TOLERANCE * normal(1, 2) + np.einsum("cd,ndp->ncp", smooth, normal(3, 2)) * SHARE[:, 0]
    made = normal(1, 1) * way * (1 + wrong)
    parts = np.concatenate([made.real, made.imag], axis=1).reshape(draws, -1)
    exact = np.einsum("xcp,yeq->xcpyeq", *2 * [np.stack([way.real, way.imag])])
    exact += np.einsum("xcp,yeq->xcpyeq", *2 * [np.stack([-way.imag, way.real])])
    expected = (_as_it_passes(compared, 0) * exact).reshape(parts.shape[1], -1)
    sizes = np.sqrt(np.diag(expected))
    # Of so many draws a covariance is known to about a share of 1 / sqrt(draws).
    np.testing.assert_allclose(
        parts.T @ parts / draws / np.outer(sizes, sizes), expected / np.outer(sizes, sizes), atol=0.015
    )
    # Where the machine misses nothing, at each probe as an effect.
    np.testing.assert_allclose(
        np.diag(_as_it_passes(compared, 1)[0, :, :, 0].reshape(6, 6)), 1 + 2 * PROBE_TOLERANCE**2
    )


def _with_an_error(at: tuple[int, ...], beside: np.ndarray) -> tuple[float, float]:
    """Return how much evidence something unknown has over nothing where some of six probes show a line that is off.

    And how much it would have as independent lines of the likeliest size at those probes alone, at no price.
    """
    probes, conditions = tuple("abcdef"), tuple(Condition(speed) for speed in (600.0, 900.0, 1300.0, 1900.0))
    generator = np.random.default_rng(3)
    seen = generator.normal(size=(2, 4, 6, 1))
    amplitudes = seen[0] + 1j * seen[1]
    amplitudes[:, list(at)] += 10.0 * np.exp(1j * np.arange(4))[:, None, None]
    # At 2X all probes show what the machine makes.
    known = np.zeros((4, 6, 2), dtype=complex)
    known[:, :, 1] = 10.0
    both = np.concatenate([amplitudes, known[:, :, 1:]], axis=2)
    lines = OrderLines(conditions, probes, (1.0, 2.0), both, np.ones(both.shape))
    empty = _baseline(4, np.array([0.5]), np.zeros(1))
    empty = replace(empty, lines=known, slopes=np.zeros((len(empty.prior), *known.shape), dtype=complex))
    plain = comparison(lines, empty, None, None, np.full((6, 2), 1e-3))
    compared = replace(plain, transfer=TransferError(np.zeros((6, 2)), beside))
    nothing = plain.log_constant - 0.5 * float(plain.residual @ plain.residual)
    power, sizes = float((np.abs(amplitudes[:, list(at)]) ** 2).sum()), np.geomspace(1.0, 1e3, 50)
    alone = 0.5 * power * sizes / (1 + sizes) - 0.5 * 8 * len(at) * np.log1p(sizes)
    return unexplained(compared, ()).log_evidence - nothing, float(alone.max())


def test_what_one_probe_or_one_place_shows_alone_does_not_pay_for_the_others():
    apart = np.eye(6, dtype=bool)
    pairs = np.kron(np.eye(3, dtype=bool), np.ones((2, 2), dtype=bool))
    found = [_with_an_error(at, own) for at, own in (((0,), apart), ((0, 1), pairs))]
    for evidence, alone in found:
        # The price: one of 17 sizes, and half of the probability shared by the groups; and the grid of sizes.
        groups = 6 if evidence is found[0][0] else 9
        assert evidence == pytest.approx(alone - np.log(17 / (0.5 / groups)), abs=2.0)
    # Lines at all probes would pay for those of the others as well.
    assert found[1][0] > _with_an_error((0, 1), apart)[0] + 5
