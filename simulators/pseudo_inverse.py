"""The inverse of a matrix as far as it has one."""

from __future__ import annotations

import numpy as np


def pseudo_inverse(matrix: np.ndarray, *, rcond: float) -> np.ndarray:
    """Return the Moore-Penrose inverse of a finite real matrix, singular values below ``rcond`` of the largest cut.

    LAPACK's divide and conquer, which is fast, fails on a matrix now and then; its QR iteration does not.
    """
    try:
        return np.linalg.pinv(matrix, rcond=rcond)
    except np.linalg.LinAlgError:
        from scipy.linalg import svd

        left, sizes, right = svd(matrix, full_matrices=False, lapack_driver="gesvd")
        kept = sizes > rcond * sizes[0]
        return (right[kept].T / sizes[kept]) @ left[:, kept].T
