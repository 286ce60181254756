"""One effect with something unknown beside it: a real machine seldom does only what one cause makes it do.

Asked only where something unknown is the most probable answer. All orders but one that need a smooth random function
keep it; the one that is left must be made by an effect, in every condition and at every probe, within the tolerance of
its law. Whether it is named, `judged` decides: such a hypothesis must be nearly certain.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from .climb import FIRST_STEPS, climbed
from .evidence import Comparison, Problem, law_columns
from .hypotheses import Candidate
from .lines import OrderLines
from .own_angles import have_own_angles, that_make
from .refine import Fit, nothing, refined
from .screen import Start
from .screening import Screening, few_of_each
from .shown_lines import CLEAR
from .transfer_error import TransferError
from .unknown_force import LEAST_GAIN, Unknown

#: Orders that are tried, those that stand out most, and effects followed at each.
ORDERS, FOLLOWED = 3, 4
#: Chance below which an effect does not make its order: more than noise is left of it; and below which a few steps
#: towards it are enough to say so.
MISFIT, HOPELESS = 1e-3, 1e-30
#: Share of a line beyond which an effect has made it.
MUCH = 0.3
#: Probes and conditions that must clearly show what the effect makes, where there are as many: beside something unknown
#: one line tells no cause, as that may make it as well.
WIDELY = 2

Tell = Callable[[str], None]


def beside_unknown(
    problem: Problem,
    screening: Screening,
    unknown: Unknown,
    fits: Sequence[Fit] = (),
    *,
    tell: Tell = lambda _: None,
) -> tuple[list[Fit], list[Fit]]:
    """Return the effects that make one of the unknown orders, what others need being unknown; the best first.

    And those that make it as well, but contradict another order: such an effect is not the cause as the catalogue has
    it, but one by another law may be, so that what does make the order is not told.

    Parameters
    ----------
    problem : Problem
    screening : Screening
    unknown : Unknown
        Of the lines without any effect.
    fits : sequence of Fit
        Of effects without anything unknown, the best first: those that were fitted together with the machine's own
        unknowns are taken up there.
    """
    found: dict[Candidate, Fit] = {}
    unlike: dict[Candidate, Fit] = {}
    if len(unknown.kernels) < 2:
        return [], []
    singles = [fit for fit in fits if len(fit.candidates) == 1][:FOLLOWED]
    phases = [k for k in unknown.kernels if problem.lines.kinds[k].phase]
    compared = problem.plain()
    for order in sorted(phases, key=lambda k: -unknown.gains[k])[:ORDERS]:
        added, cost = unknown.without(order)
        transfers = compared.transfer.options()
        cost += math.log(len(transfers))
        for transfer in transfers:
            widened = replace(compared.widened(added), transfer=transfer)
            some = widened.select(screening.chosen)
            least = nothing(some).log_evidence + LEAST_GAIN
            every = few_of_each(screening.against(some))
            tried: list[Fit | None] = []
            for options in [one for one in every if one[0].score > least and _repeats(one[0], problem)][:FOLLOWED]:
                tell(f"{options[0].candidate} beside something unknown")
                tried.append(_fitted(options, problem, widened, order))
            tried += [_taken_up(fit, problem, added, transfer, order) for fit in singles]
            others = frozenset(unknown.kernels) - {order}
            for fit in tried:
                if fit is None or not shows_widely(fit.response, compared.lines, order):
                    continue
                fit = replace(fit, log_evidence=fit.log_evidence - cost, unknown_beside=others)
                one, kept = fit.candidates[0], unlike if _contradicted(fit.response, compared, others) else found
                if one not in kept or fit.log_evidence > kept[one].log_evidence:
                    kept[one] = fit
    best, contradicted = (sorted(kept.values(), key=lambda fit: -fit.log_evidence) for kept in (found, unlike))
    return best, contradicted


def _repeats(start: Start, problem: Problem) -> bool:
    """Return whether the motion repeats with the shaft: the lines tried here are the shaft's."""
    return problem.predictor.repeats(start.candidate.on(problem.baseline.machine, start.position))


def _taken_up(fit: Fit, problem: Problem, added: np.ndarray, transfer: TransferError, order: int) -> Fit | None:
    """Return the fit of one effect, found together with the machine's own unknowns, beside a further covariance.

    None where it is of another kind, or does not make the order. Of many strengths that add up, those that make other
    orders are left out: these are unknown here.
    """
    if len(fit.candidates) != 1 or fit.problem is None or fit.compared is None or fit.unknown_beside:
        return None
    machine = fit.problem.baseline.machine
    if not problem.predictor.repeats(fit.machine(machine)):
        return None
    widened = replace(fit.compared.widened(added), transfer=transfer, inexact=fit.compared.inexact)
    one, position = fit.candidates[0], fit.position
    if have_own_angles(one):
        one, position = that_make(order, one, position, fit.slopes)
    found = refined([one], position, widened, machine, problem.predictor)
    makes_it = found and chance_in_order(one, found.response, widened, order) > MISFIT
    return replace(found, problem=fit.problem) if found and makes_it else None


def _fitted(options: Sequence[Start], problem: Problem, widened: Comparison, order: int) -> Fit | None:
    """Return the fit of one effect; None where it does not make the order."""
    one, machine, predictor = options[0].candidate, problem.baseline.machine, problem.predictor
    tried = climbed([one], [start.position for start in options[:1]], widened, machine, predictor, steps=FIRST_STEPS)
    if not tried or chance_in_order(one, tried[0].added, widened, order) < HOPELESS:
        return None
    first = tried[0]
    fit = refined([one], first.position, widened, machine, predictor)
    makes_it = fit and chance_in_order(one, fit.response, widened, order) > MISFIT
    return fit if makes_it else None


def _contradicted(response: np.ndarray, compared: Comparison, others: frozenset[int]) -> bool:
    """Return whether an effect makes a good part of a line that is not as it would make it.

    What it makes of an order counts with that order: who bends 2X as much as is measured, but wrongly, is not the cause
    of 1X with something unknown beside it.
    """
    lacking = np.where(compared.seen, compared.lines.amplitudes - compared.expected, 0.0)
    for order in others:
        made, measured = (float((np.abs(own[:, :, order]) ** 2).sum()) for own in (response, lacking))
        if made > MUCH**2 * measured:
            return True
    return False


def shows_widely(response: np.ndarray, lines: OrderLines, order: int) -> bool:
    """Return whether several probes, in several conditions, clearly show one order of what an effect makes."""
    clear = (np.where(lines.seen, np.abs(response) / lines.deviations, 0.0) > CLEAR)[:, :, order]
    return all(clear.any(axis=axis).sum() >= min(WIDELY, clear.shape[1 - axis]) for axis in (0, 1))


def chance_in_order(candidate: Candidate, response: np.ndarray, compared: Comparison, order: int) -> float:
    """Return the chance that noise, within the law's tolerance, leaves as much of one order as a response does."""
    from scipy.stats import chi2

    law = law_columns(compared, response, idealised=candidate.effect.IDEALISED, directed=candidate.is_directed)
    rows = np.concatenate([np.nonzero(part)[2] == order for part in compared.lines.parts])
    left = (compared.factor @ (compared.residual - compared.whitened(response)))[rows]
    directions = (compared.factor @ law.T)[rows]
    covariance = compared.covariance[np.ix_(rows, rows)] + directions @ directions.T
    power = float(left @ np.linalg.solve(covariance, left))
    return float(chi2.sf(power, max(int(rows.sum()) - len(candidate.coordinates), 1)))
