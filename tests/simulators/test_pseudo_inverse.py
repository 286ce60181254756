"""The inverse of what has none, also where the fast decomposition gives up."""

import numpy as np
import pytest
from rotorwise.simulators.pseudo_inverse import pseudo_inverse


@pytest.mark.parametrize("fails", [False, True])
def test_penrose_s_conditions_hold(fails: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if fails:

        def give_up(*_: object, **__: object) -> None:
            raise np.linalg.LinAlgError("SVD did not converge")

        monkeypatch.setattr(np.linalg, "pinv", give_up)
    generator = np.random.default_rng(1)
    # Of rank 4, and with one direction that counts as none.
    matrix = generator.normal(size=(7, 4)) @ generator.normal(size=(4, 7))
    tiny = 1e-12 * np.outer(generator.normal(size=7), generator.normal(size=7))
    found = pseudo_inverse(matrix + tiny, rcond=1e-9)
    np.testing.assert_allclose(matrix @ found @ matrix, matrix, atol=1e-8)
    np.testing.assert_allclose(found @ matrix @ found, found, atol=1e-8)
    np.testing.assert_allclose(matrix @ found, (matrix @ found).T, atol=1e-8)
    assert np.abs(found).max() < 1e3
