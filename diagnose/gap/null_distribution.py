"""What a hypothesis that is true would leave: by simulation, the fit of its values to noise included.

Residuals are drawn as the hypothesis says (noise, what the machine leaves open, the tolerance of its law), its values
are fitted to each draw as to the data, and the squared residuals that stay are counted. Priors hold values that the
data do not tell, so that the degrees of freedom that a table of chi-squared asks for are not known beforehand.
"""

from __future__ import annotations

import numpy as np

from .evidence import Widened
from .refine import Fit

DRAWS = 1000
#: Fewer draws than this above a residual do not tell its chance: the tail of a gamma distribution through all does.
FEW = 20


def chance_of_residual(fit: Fit, *, seed: int = 0) -> float:
    """Return the chance that a true hypothesis leaves as large a residual as ``fit`` does."""
    left = null_of(fit, seed=seed)
    above = int((left >= fit.power).sum())
    if above >= FEW:
        return above / left.size
    from scipy.stats import gamma

    mean, variance = float(left.mean()), float(left.var())
    return float(gamma.sf(fit.power, mean**2 / variance, scale=variance / mean))


def null_of(fit: Fit, *, seed: int) -> np.ndarray:
    """Return squared residuals that a true hypothesis leaves, shape (draws,)."""
    generator, law = np.random.default_rng(seed), Widened(fit.law)
    drawn = generator.normal(size=(DRAWS, fit.residual.size))
    drawn += generator.normal(size=(DRAWS, fit.law.shape[0])) @ fit.law
    if fit.candidates and fit.compared is not None:
        slopes = fit.compared.whitened(fit.slopes)
        held = np.array([c.least_precision for c in fit.coordinates])
        information = slopes @ law.solve(slopes).T + np.diag(held)
        values = np.linalg.solve(information, slopes @ law.solve(drawn).T)
        drawn -= values.T @ slopes
    return np.einsum("dr,dr->d", drawn, law.solve(drawn))
