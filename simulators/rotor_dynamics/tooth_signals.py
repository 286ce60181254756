"""What damaged teeth do to a gear mesh at many instants at once: stiffness, error and the error's slope.

Few pairs are damaged. They are found by their whole numbers first, so that the polynomials of `tooth_damage` are
computed only where a damaged pair is in contact.
"""

from __future__ import annotations

import numpy as np


def tooth_signals(
    tooth: np.ndarray, phase: np.ndarray, is_first: np.ndarray, own: np.ndarray, powers: int
) -> np.ndarray:
    """Return what damaged teeth change: stiffness in N/m, error in m and its slope by the pair phase.

    Parameters
    ----------
    tooth : ndarray (instants, lanes)
        Number of the pair that came last into contact, whole numbers.
    phase : ndarray (instants, lanes)
        Pitches since its first contact.
    is_first : ndarray of bool (instants, lanes)
        Whether the pair before it is still in contact.
    own : ndarray (parameters, lanes)
        Compliance of a sound pair, then for each damaged tooth (every, first, compliance, error).
    powers : int
        Length of each of these polynomials.

    Returns
    -------
    ndarray (3, instants, lanes)
    """
    result = np.zeros((3, *phase.shape))
    lowest = tooth.min() - 1
    numbers = lowest + np.arange(int(tooth.max() - lowest) + 1)
    for lane in range(phase.shape[1]):
        mine = own[:, lane] if own.shape[1] > 1 else own[:, 0]
        rows = mine[powers:].reshape(-1, 2 + 2 * powers)
        hit = np.mod(numbers - rows[:, 1:2], rows[:, :1]) == 0
        is_damaged = hit.any(axis=0)
        if not is_damaged.any():
            continue
        last = (tooth[:, lane] - lowest).astype(np.int64)
        for back in (0, 1):
            found = is_damaged[last - back] & is_first[:, lane] if back else is_damaged[last]
            where = np.flatnonzero(found)
            if where.size:
                part = _pair_change(hit[:, last[where] - back], phase[where, lane] + back, rows, mine[:powers])
                result[:, where, lane] += part
    return result


def _pair_change(hit: np.ndarray, phase: np.ndarray, rows: np.ndarray, sound: np.ndarray) -> np.ndarray:
    """Return change of stiffness, error and its slope of pairs at ``phase``; ``hit`` (teeth, phases) says whose."""
    change = np.zeros((3, *phase.shape))
    softer, errors = rows[:, 2 : 2 + sound.size], rows[:, 2 + sound.size :]
    if softer.any():
        values = _polynomials(np.vstack([sound, softer]), phase)
        change[0] = 1 / (values[0] + np.einsum("ij,ij->j", values[1:], hit)) - 1 / values[0]
    if errors.any():
        change[1] = np.einsum("ij,ij->j", _polynomials(errors, phase), hit)
        slopes = errors[:, 1:] * np.arange(1, sound.size)
        change[2] = np.einsum("ij,ij->j", _polynomials(slopes, phase), hit)
    return change


def _polynomials(coefficients: np.ndarray, position: np.ndarray) -> np.ndarray:
    """Return polynomials (polynomials, powers) at positions, shape (polynomials, positions)."""
    highest = np.flatnonzero(coefficients.any(axis=0))[-1]
    values = np.repeat(coefficients[:, highest : highest + 1], position.size, axis=1)
    for power in range(highest - 1, -1, -1):
        values *= position
        values += coefficients[:, power : power + 1]
    return values
