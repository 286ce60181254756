"""All strengths of one effect together: none less than nothing, at one angle for all, best by least squares."""

from __future__ import annotations

import numpy as np

from .evidence import Comparison, Widened, law_columns

#: Angles at which the strengths are solved for, round the circle.
TRIED_ANGLES = 72
#: Share of its responses' power below which a combination of them is rounding, so that no size of it is wanted.
ROUNDING = 1e-9


def together(responses: np.ndarray, compared: Comparison, *, idealised: bool) -> tuple[float, np.ndarray, np.ndarray]:
    """Return the angle and factors of responses that explain most together, and their sum there.

    Responses add up and are proportional to their factors, which is so for small ones. What an angle does to them is
    interpolated round the circle: of a property that varies n times a revolution they hold harmonics of the angle up to
    n. The lines weigh by the law's tolerance about a first solution without it.

    Parameters
    ----------
    responses : ndarray (angles, strengths, conditions, probes, orders), complex
        At angles evenly round the circle from 0 on; one where no angle matters.
    compared : Comparison
    idealised : bool
        Whether the effect's law is a model of a form that no real one has.

    Returns
    -------
    angle : float
        As a share of the circle.
    factors : ndarray (strengths,)
    response : ndarray (conditions, probes, orders), complex
    """
    flat = responses.reshape(-1, *responses.shape[2:])
    white = np.array([compared.whitened(one) for one in flat])
    tried = np.arange(TRIED_ANGLES) / TRIED_ANGLES if len(responses) > 1 else np.zeros(1)
    weights = _interpolation(len(responses), tried)
    law = Widened(np.zeros((0, compared.residual.size)))
    angle, factors, response = 0.0, np.zeros(responses.shape[1]), np.zeros(responses.shape[2:], dtype=complex)
    for _ in range(2):
        solved = law.solve(white)
        power, along = solved @ white.T, solved @ compared.residual
        gain = -1.0
        for at, weight in zip(tried, weights, strict=True):
            mixing = np.kron(weight, np.eye(factors.size))
            found = _not_negative(mixing @ power @ mixing.T, mixing @ along)
            if found[0] > gain:
                gain, angle, factors, response = found[0], float(at), found[1], np.tensordot(found[1] @ mixing, flat, 1)
        law = Widened(law_columns(compared, response, idealised=idealised))
    return angle, factors, response


def _interpolation(count: int, tried: np.ndarray) -> np.ndarray:
    """Return the weights, (tried, count), of a trigonometric polynomial through values evenly round the circle."""
    away = 2 * np.pi * (tried[:, None] - np.arange(count) / count)
    weights = np.ones(away.shape) + 2 * sum(np.cos(n * away) for n in range(1, (count + 1) // 2))
    if count % 2 == 0:
        weights = weights + np.cos(away * count / 2)
    return weights / count


def _not_negative(power: np.ndarray, along: np.ndarray) -> tuple[float, np.ndarray]:
    """Return gain and factors, none negative, that take most from a residual along which responses of a power lie."""
    from scipy.optimize import nnls

    size = np.sqrt(np.diag(power))
    size[size == 0] = 1.0
    lower = np.linalg.cholesky(power / np.outer(size, size) + ROUNDING * np.eye(size.size))
    factors = nnls(lower.T, np.linalg.solve(lower, along / size))[0] / size
    return float(factors @ along - 0.5 * factors @ power @ factors), factors
