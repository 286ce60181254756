"""Damping matrices of shafts, made from damping ratios.

The matrices multiply velocities. Damping of the shaft material or of a press fit turns with the shaft; in the fixed
frame it then needs ``circulatory_matrix`` as well, which can make the rotor unstable above its critical speed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..errors import InvalidValueError
from .shaft_parts import require_positive

# Modes closer than this (relative) are one mode in two planes: round-off splits such pairs by about 1e-10.
_SAME_FREQUENCY = 1e-6
# Squared frequencies below this share of the highest one are round-off of a rigid-body motion.
_RIGID_BODY = 1e-12


def modal_damping(mass: np.ndarray, stiffness: np.ndarray, *, ratios: float | Sequence[float]) -> np.ndarray:
    """Return the damping matrix that gives each undamped, non-rotating mode its damping ratio.

    C = M Phi diag(2 zeta_k omega_k) Phi^T M with mass-normalised mode shapes Phi.

    Parameters
    ----------
    mass, stiffness : numpy.ndarray
        Symmetric, shape (n, n), mass positive definite: of the free rotor, or with its supports added.
    ratios : float or sequence of float
        Damping ratios, at least 0, of the elastic modes from the lowest frequency on. The two modes of an isotropic
        rotor with one frequency count once, since only then is the matrix unique. The last ratio holds for all
        higher modes. Rigid-body motions stay undamped.

    Returns
    -------
    numpy.ndarray
        Symmetric positive semidefinite, shape (n, n), in N s/m and N m s/rad.

    References
    ----------
    E. L. Wilson and J. Penzien, "Evaluation of orthogonal damping matrices", Int. J. Num. Meth. Eng. 4 (1972) 5-10.
    """
    from scipy.linalg import eigh

    wanted = np.atleast_1d(np.asarray(ratios, dtype=float))
    if wanted.ndim != 1 or not wanted.size or not np.all(np.isfinite(wanted) & (wanted >= 0)):
        raise InvalidValueError(f"Damping ratios {ratios}; allowed: one number or more, each at least 0. 0.01 is 1 %.")
    squares, shapes = eigh(stiffness, mass)
    elastic = squares > _RIGID_BODY * squares[-1]
    frequencies, shapes = np.sqrt(squares[elastic]), shapes[:, elastic]
    new_mode = np.diff(frequencies, prepend=-np.inf) > _SAME_FREQUENCY * frequencies
    number = np.minimum(np.cumsum(new_mode) - 1, wanted.size - 1)
    momenta = mass @ shapes
    damping = (momenta * (2 * wanted[number] * frequencies)) @ momenta.T
    return (damping + damping.T) / 2


def stiffness_proportional_damping(stiffness: np.ndarray, *, ratio: float, at_frequency_rad_s: float) -> np.ndarray:
    """Return C = (2 ratio / omega) K: damping ratio ``ratio`` at one frequency, in proportion to frequency elsewhere.

    Parameters
    ----------
    stiffness : numpy.ndarray
        Shape (n, n).
    ratio : float
        Damping ratio at ``at_frequency_rad_s``, at least 0.
    at_frequency_rad_s : float
        Frequency omega in rad/s, above 0.
    """
    require_positive("Frequency in rad/s", at_frequency_rad_s)
    if not (np.isfinite(ratio) and ratio >= 0):
        raise InvalidValueError(f"Damping ratio {ratio}; allowed: at least 0. 0.01 is 1 %.")
    return 2 * ratio / at_frequency_rad_s * np.asarray(stiffness)


def circulatory_matrix(rotating_damping: np.ndarray) -> np.ndarray:
    """Return the matrix that joins the stiffness, times the speed in rad/s, when damping turns with the shaft.

    A damper on the shaft sees the velocities x' + speed y and y' - speed x (angles alike), so its force in the fixed
    frame is -C q' - speed C J q with J turning each pair (x, y) by a quarter.

    Parameters
    ----------
    rotating_damping : numpy.ndarray
        Isotropic damping matrix in the order x, y, angle_x, angle_y a node, shape (4 nodes, 4 nodes).

    References
    ----------
    G. Genta, "Dynamics of Rotating Systems", Springer 2005, section 2.4: unstable above the critical speed times
    (1 + fixed damping / rotating damping).
    """
    size = len(rotating_damping)
    if size % 4:
        raise InvalidValueError(f"Damping matrix has {size} rows; allowed: a multiple of 4, four a node.")
    quarter_turn = np.kron(np.eye(size // 2), np.array([[0.0, 1.0], [-1.0, 0.0]]))
    return rotating_damping @ quarter_turn
