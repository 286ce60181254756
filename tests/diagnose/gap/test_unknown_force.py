"""What something unknown makes passes through the machine no more exactly than what an effect makes."""

from dataclasses import replace

import numpy as np
from rotorwise.diagnose.gap.baseline import similarity
from rotorwise.diagnose.gap.evidence import PROBE_TOLERANCE, comparison
from rotorwise.diagnose.gap.lines import Condition, OrderLines
from rotorwise.diagnose.gap.transfer_error import TransferError
from rotorwise.diagnose.gap.unknown_force import _as_it_passes

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
