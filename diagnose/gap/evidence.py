"""Gaussian comparison of lines: what the healthy recordings leave uncertain, and how probable a residual is under it.

The lines of the healthy conditions and of the conditions to explain share the machine's unknowns and the model error:
they are one Gaussian vector, and what the healthy lines say is conditioned on. A hypothesis adds a response u. Each of
its orders but the strongest may be wrong by a complex factor of standard deviation `LAW_TOLERANCE`, as no law holds
exactly; the factor of the strongest is its strength, to `STRENGTH_TOLERANCE`. At each probe each order may be wrong by
`PROBE_TOLERANCE` more, and, smoothly in speed and load, by the share by which the calibrated machine misses its own
healthy lines. Of a law that is an idealisation, as that of a contact is, each of these is larger.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .baseline import Baseline, shifted
from .line_covariance import line_covariance, noisy
from .lines import OrderLines, dense, from_blocks, in_blocks, seen_in, stacked, unstacked
from .model_error import ModelError, error_blocks, error_covariance
from .predict import Predictor
from .record_scatter import directions
from .size_scale import at_most_once
from .transfer_error import TransferError, none_of
from .whitening import Whitening, factor_of, lower_solved

#: Of lines with phase, and of sizes of lines without: transfer paths at high frequencies are known to a factor.
LAW_TOLERANCE, LAW_TOLERANCE_OF_SIZES = 0.15, 0.5
#: Of the real and the imaginary part of the strongest order: a law is right to 10 %, sizes to a factor.
STRENGTH_TOLERANCE, STRENGTH_TOLERANCE_OF_SIZES = 0.1 / math.sqrt(2), 0.5 / math.sqrt(2)
PROBE_TOLERANCE, PROBE_TOLERANCE_OF_SIZES = 0.02, 0.3
#: Of lines with phase where the law's form is an idealisation: of each order, at each probe, and smoothly in speed.
IDEALISED_LAW, IDEALISED_PROBE, IDEALISED_TRANSFER = 0.3, 0.05, 0.1
#: Of one size in one condition at one probe: a resonance on the way from the bearing to a sensor lies elsewhere in a
#: real machine, and passes other multiples of the line at other speeds. Below this share of the noise it says nothing.
TOLERANCE_OF_A_SIZE, LEAST_SCATTER = 0.5, 0.1
THRICE, LEAST_OF_MEAN = 3.0, 0.1


@dataclass(frozen=True, eq=False)
class Comparison:
    """Lines to explain against what is expected without any effect.

    Attributes
    ----------
    lines : OrderLines
    expected : ndarray (conditions, probes, orders), complex
    covariance : ndarray (reals, reals)
        Of the stacked residual without any effect.
    factor : ndarray (reals, reals)
        Its lower Cholesky factor.
    residual : ndarray (reals,)
        Stacked, whitened: a unit normal vector when nothing is wrong.
    log_constant : float
        Logarithm of the density of the residual at zero.
    known : ndarray (unknowns,)
        The machine's unknowns as the healthy lines have them, relative to where the machine is linearised.
    learnt : ndarray (unknowns, reals)
        What one whitened residual adds to them.
    transfer : TransferError
    inexact : float
        Factor by which the law of an effect whose form is an idealisation is less exact than usual.
    """

    lines: OrderLines
    expected: np.ndarray
    covariance: np.ndarray
    factor: np.ndarray
    residual: np.ndarray
    log_constant: float
    known: np.ndarray
    learnt: np.ndarray
    transfer: TransferError
    inexact: float = 1.0

    @property
    def seen(self) -> np.ndarray:
        """Where lines are compared."""
        return self.lines.seen

    def whitened(self, response: np.ndarray) -> np.ndarray:
        """Return responses (..., conditions, probes, orders) as whitened real vectors (..., reals)."""
        return self.whitening.whole(response)

    @cached_property
    def whitening(self) -> Whitening:
        """How lines become vectors of unit variance here."""
        return Whitening(self.factor, self.lines.parts)

    def widened(self, added: np.ndarray) -> Comparison:
        """Return the comparison with a further covariance (reals, reals) of the stacked lines."""
        left, cross = self.factor @ self.residual, self.learnt @ self.factor.T
        found = _compared(self.lines, self.expected, self.covariance + added, left, self.known, cross)
        return replace(found, transfer=self.transfer)

    def select(self, conditions: Sequence[int]) -> Comparison:
        """Return the comparison of these conditions only, which must be in order."""
        rows = np.concatenate([np.isin(np.nonzero(part)[0], conditions) for part in self.lines.parts])
        left, cross = (self.factor @ self.residual)[rows], (self.learnt @ self.factor.T)[:, rows]
        lines, expected = self.lines.select(conditions), self.expected[list(conditions)]
        found = _compared(lines, expected, self.covariance[np.ix_(rows, rows)], left, self.known, cross)
        return replace(found, transfer=self.transfer)

    def detectability(self, response: np.ndarray) -> float:
        """Return d2: the squared length of a response in standard deviations of everything uncertain."""
        white = self.whitened(response)
        return float(white @ white)


@dataclass(frozen=True, eq=False)
class Problem:
    """Everything that hypotheses are compared on.

    Attributes
    ----------
    lines : OrderLines
        To explain.
    baseline : Baseline
        The calibrated machine in their conditions.
    healthy : OrderLines, optional
    at_healthy : Baseline, optional
        The calibrated machine in the healthy conditions.
    error : ndarray (probes, orders) or ModelError
        The baseline's model error.
    transfer : TransferError
    predictor, healthy_predictor : Predictor
        For the conditions to explain, and for the healthy ones (the same where there are none).
    """

    lines: OrderLines
    baseline: Baseline
    healthy: OrderLines | None
    at_healthy: Baseline | None
    error: np.ndarray | ModelError
    transfer: TransferError
    predictor: Predictor
    healthy_predictor: Predictor

    def plain(self) -> Comparison:
        """Return the lines against what is expected without any effect."""
        return self._plain

    @cached_property
    def _plain(self) -> Comparison:
        plain = comparison(self.lines, self.baseline, self.healthy, self.at_healthy, self.error)
        return replace(plain, transfer=self.transfer)

    def moved(self, change: np.ndarray) -> Problem:
        """Return the problem about a machine whose own coordinates are changed."""
        machine = self.baseline.machine
        there = self.at_healthy
        if there is not None and change[there.active].any():
            there = shifted(there, machine, change, self.healthy_predictor)
        return replace(self, baseline=shifted(self.baseline, machine, change, self.predictor), at_healthy=there)

    def around(self, baseline: Baseline, response: np.ndarray) -> Comparison:
        """Return the lines against a machine with effects, linearised with them, that add ``response``.

        What they add may be wrong by a share of what they should add, or of thrice what they do: were it a share of the
        response itself, a hypothesis would gain certainty by making less than was measured.
        """
        share = np.maximum(_tolerances(self.lines)[1], self.transfer.share)
        lacking = np.where(self.lines.seen, self.lines.amplitudes - self.plain().expected, 0.0)
        own = share * np.minimum(_size_in_each(lacking), THRICE * _size_in_each(response))
        wrong = error_covariance(self.lines.conditions, own, self.lines.parts, length=self.transfer.length)
        found = comparison(self.lines, baseline, self.healthy, self.at_healthy, self.error, wrong)
        return replace(found, transfer=self.transfer)


def comparison(
    lines: OrderLines,
    baseline: Baseline,
    healthy: OrderLines | None,
    at_healthy: Baseline | None,
    error: np.ndarray | ModelError,
    further: np.ndarray | None = None,
) -> Comparison:
    """Return the lines against what the machine, and its healthy lines if there are any, let expect.

    Parameters
    ----------
    lines : OrderLines
        To explain.
    baseline, at_healthy : Baseline
        The machine in these conditions, and in the healthy ones: with the same unknowns.
    healthy : OrderLines, optional
    error : ndarray (probes, orders) or ModelError
        Standard deviation of the model error.
    further : ndarray (reals, reals), optional
        Covariance of a further model error that the healthy lines do not share.
    """
    parts, prior = lines.parts, baseline.prior
    within, across, errors = model_errors(healthy, lines, error)
    known, spread, drift = baseline.prior_mean, np.diag(prior), np.zeros(prior.size)
    slopes, own = in_blocks(baseline.slopes, parts), noisy(errors, lines)
    learnt = np.zeros(slopes.shape[1:])
    if healthy is not None and at_healthy is not None:
        there = line_covariance(healthy, within, at_healthy.slopes, prior)
        left = healthy.amplitudes - at_healthy.lines
        change, root = there.told(left - np.tensordot(known, at_healthy.slopes, 1))
        known, spread = known + prior * change, prior[:, None] * root
        # What the model misses of a healthy line it misses of the same line in conditions that are like it.
        across = across * (seen_in(parts)[..., :, None] & seen_in(healthy.parts)[..., None, :])
        alike = across @ np.swapaxes(there.inverse, -1, -2) @ there.inverse
        shared = (alike @ in_blocks(np.stack([left, *at_healthy.slopes]), healthy.parts)[..., None])[..., 0]
        learnt = shared[0] - np.tensordot(known, shared[1:], 1)
        slopes = slopes - shared[1:]
        own = own - alike @ np.swapaxes(across, -1, -2)
        # The machine has been stopped and started in between: its own parameters are not quite the same.
        drift = baseline.drift
    flat, moved = stacked(baseline.slopes, parts), spread.T @ from_blocks(slopes, parts)
    drifted = drift[:, None] ** 2 * flat
    covariance = dense(own, parts) + moved.T @ moved + flat.T @ drifted
    if further is not None:
        covariance = covariance + further
    expected = baseline.lines + np.tensordot(known, baseline.slopes, 1) + unstacked(from_blocks(learnt, parts), parts)
    left = stacked(lines.amplitudes - expected, parts)
    return _compared(lines, expected, covariance, left, known, spread @ moved + drifted)


def model_errors(
    healthy: OrderLines | None, lines: OrderLines, error: np.ndarray | ModelError
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return `error_blocks` in the healthy conditions, of the others with these, and in the others.

    From one matrix: how alike two conditions are depends on the range of loads of all.
    """
    before = healthy.conditions if healthy is not None else ()
    whole, count = error_blocks(before + lines.conditions, error), len(before)
    return whole[..., :count, :count], whole[..., count:, :count], whole[..., count:, count:]


def _compared(
    lines: OrderLines,
    expected: np.ndarray,
    covariance: np.ndarray,
    left: np.ndarray,
    known: np.ndarray,
    cross: np.ndarray,
) -> Comparison:
    """Return the comparison of stacked lines that leave ``left`` (reals,) of what is expected."""
    # Rounding may leave a tiny negative direction where slopes and errors are far larger than the noise.
    covariance = (covariance + covariance.T) / 2 + np.diag(1e-12 * np.diag(covariance))
    factor = factor_of(covariance)
    residual = lower_solved(factor, left)
    learnt = lower_solved(factor, cross.T).T
    constant = -float(np.log(np.diag(factor)).sum()) - 0.5 * residual.size * math.log(2 * math.pi)
    return Comparison(lines, expected, covariance, factor, residual, constant, known, learnt, none_of(lines))


def _tolerances(lines: OrderLines, inexact: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return the tolerance of a law at each order, and at each order at one probe, both (orders,).

    ``inexact`` is 0 for a law whose form is known.
    """
    phase = np.array([kind.phase for kind in lines.kinds])
    return (
        np.where(phase, inexact * IDEALISED_LAW or LAW_TOLERANCE, LAW_TOLERANCE_OF_SIZES),
        np.where(phase, inexact * IDEALISED_PROBE or PROBE_TOLERANCE, PROBE_TOLERANCE_OF_SIZES),
    )


def law_columns(compared: Comparison, response: np.ndarray, *, idealised: bool, directed: bool = True) -> np.ndarray:
    """Return the whitened directions in which a response's law may be wrong, shape (directions, reals).

    ``idealised`` says whether the form of the effect's law is an idealisation, ``directed`` whether it has an angle
    that makes up for a wrong phase of the strongest order, as its strength does for a wrong size.
    """
    present = np.flatnonzero(np.abs(response).max(axis=(0, 1)) > 0)
    if not present.size:
        return np.zeros((0, compared.residual.size))
    law, apart = _tolerances(compared.lines, compared.inexact if idealised else 0.0)
    response = at_most_once(response, compared.lines.knees)
    each = compared.whitening.of_probes(response)[:, present]
    whole = each.sum(axis=2)
    power = (whole**2).sum(axis=2)
    weaker = power > 1e-3
    weaker[: 2 if directed else 1, int(np.argmax(power[0]))] = False
    orders = (law[present, None] * whole)[weaker]
    probes = (apart[present, None, None] * each).reshape(-1, each.shape[-1])
    scattered = compared.whitening.of_each(_scattered_sizes(compared.lines, response))
    transfer = compared.transfer.at_least(compared.inexact * IDEALISED_TRANSFER if idealised else 0.0)
    wrongly = compared.whitening.at_places(*transfer.directions(response, compared.lines.conditions))
    by_record = directions(response, compared.whitening, transfer.by_record)
    columns = np.concatenate([orders, probes, scattered, wrongly, by_record])
    return columns[(columns**2).sum(axis=1) > 1e-3]


def _scattered_sizes(lines: OrderLines, response: np.ndarray) -> np.ndarray:
    """Return by how much each line without phase may be wrong in one condition at one probe alone; 0 for others."""
    phase = np.array([kind.phase for kind in lines.kinds])
    size = np.where(phase | ~lines.seen, 0.0, TOLERANCE_OF_A_SIZE * np.abs(response))
    return np.where(size > LEAST_SCATTER * lines.deviations, size, 0.0)


def strength_columns(compared: Comparison, response: np.ndarray) -> np.ndarray:
    """Return the whitened directions in which the strongest order of a response may be wrong, shape (2, reals).

    They look like another strength, and cost no fit anything; the strength's interval has to hold them.
    """
    each = compared.whitening.of_orders(response)
    return STRENGTH_TOLERANCE * each[:, int(np.argmax((each[0] ** 2).sum(axis=1)))]


def _size_in_each(lines: np.ndarray) -> np.ndarray:
    """Return the size of the real part, or the imaginary part, of lines, (conditions, probes, orders).

    Where a line passes through a minimum, at least `LEAST_OF_MEAN` of its rms over the conditions.
    """
    power = np.abs(lines) ** 2 / 2
    return np.sqrt(np.maximum(power, LEAST_OF_MEAN**2 * power.mean(axis=0, keepdims=True)))


@dataclass(frozen=True, eq=False)
class Widened:
    """The unit covariance of whitened lines, widened by directions: I + D' D.

    Attributes
    ----------
    directions : ndarray (directions, reals)
    """

    directions: np.ndarray

    @cached_property
    def _is_many(self) -> bool:
        """Whether there are more directions than reals."""
        return self.directions.shape[0] > self.directions.shape[1]

    @cached_property
    def _lower(self) -> np.ndarray:
        """Lower Cholesky factor of I + D' D, or of I + D D', whichever is smaller; not numbers where D holds none."""
        d = self.directions
        inner = d.T @ d if self._is_many else d @ d.T
        try:
            return np.linalg.cholesky(np.eye(inner.shape[0]) + inner)
        except np.linalg.LinAlgError:
            return np.full(inner.shape, np.nan)

    def solve(self, vectors: np.ndarray) -> np.ndarray:
        """Return (I + D' D)^-1 v for vectors (..., reals)."""
        from scipy.linalg import cho_solve

        if not self.directions.size:
            return vectors
        flat = vectors.reshape(-1, vectors.shape[-1]).T
        if self._is_many:
            return cho_solve((self._lower, True), flat, check_finite=False).T.reshape(vectors.shape)
        inside = cho_solve((self._lower, True), self.directions @ flat, check_finite=False)
        return vectors - (inside.T @ self.directions).reshape(vectors.shape)

    def standardised(self, vector: np.ndarray, factor: np.ndarray) -> np.ndarray:
        """Return each real less what the others let expect of it, over its deviation then, (reals,).

        Of a whitened ``vector``; ``factor`` is the Cholesky factor by which it was whitened, so that each real is a
        part of one line again.
        """
        back = lower_solved(factor, np.eye(vector.size))
        precision = np.einsum("rn,rn->r", back.T, self.solve(back.T))
        return back.T @ self.solve(vector) / np.sqrt(np.maximum(precision, 1e-300))

    @property
    def log_determinant(self) -> float:
        """Return ln |I + D' D|."""
        return 2 * float(np.log(np.diag(self._lower)).sum()) if self.directions.size else 0.0


def log_density(compared: Comparison, residual: np.ndarray, widened: Widened) -> float:
    """Return the logarithm of the density of a whitened residual under a widened covariance."""
    return compared.log_constant - 0.5 * float(residual @ widened.solve(residual)) - 0.5 * widened.log_determinant
