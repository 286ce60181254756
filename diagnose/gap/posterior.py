"""How probable each hypothesis is: nothing, one effect, two effects, something unknown."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from .evidence import Comparison
from .judged import judged
from .null_distribution import chance_of_residual
from .prediction import Predicted
from .refine import Fit
from .two_effects import MISFIT
from .unknown_force import Unknown
from .within_law import LESS_PROBABLE, takes_any_form, within_its_law

#: Probability before any measurement that nothing, one effect, two effects, something unknown, or one effect with
#: something unknown beside it is the cause.
PRIOR = {"none": 0.4, "one": 0.4, "two": 0.1, "unknown": 0.06, "beside": 0.04}
#: Two effects imitate a third that is in no catalogue, where they are hardly ahead of something unknown: three pairs
#: that were ahead by less than 4 were wrong, all of 42 true ones were ahead by 15 or more.
IMITATED = 10.0


@dataclass(frozen=True, eq=False)
class Posterior:
    """What was compared and how probable each hypothesis is.

    Attributes
    ----------
    compared : Comparison
        Without any effect.
    none : Fit
    fits : tuple of Fit
        Hypotheses of one and two effects that were fitted, most probable first.
    unknown : Unknown
    probabilities : mapping of tuple of str to float
        By names of effects: () for nothing, ("unknown",) for something outside the catalogue, ("rub", "unknown") for
        an effect and something else beside it. Sums to 1.
    misfit : float
        Chance of a residual as large as the best hypothesis leaves.
    held_out : mapping of tuple of str to Predicted
        How well hypotheses predict the held-out conditions, where that was looked at.
    opposed : tuple of Fit
        Of two effects that explain the lines by cancelling nearly all that each makes: they do not compete.
    """

    compared: Comparison
    none: Fit
    fits: tuple[Fit, ...]
    unknown: Unknown
    probabilities: Mapping[tuple[str, ...], float]
    misfit: float
    held_out: Mapping[tuple[str, ...], Predicted] = field(default_factory=dict)
    opposed: tuple[Fit, ...] = ()

    def best(self, names: tuple[str, ...]) -> Fit:
        """Return the best fit of effects of these names."""
        return next(fit for fit in (*self.fits, self.none) if fit.names == names)

    @property
    def named(self) -> Fit:
        """The fit whose effects the verdict names: of nothing where it names none."""
        kind, names, _ = judged(self.probabilities)
        fitted = kind in ("one cause", "several causes") or (kind == "unknown" and len(names) > 1)
        return self.best(names) if fitted else self.none


def posterior_of(
    compared: Comparison,
    none: Fit,
    fits: tuple[Fit, ...],
    unknown: Unknown,
    effects: int,
    rest: Sequence[tuple[str, float]],
    unlike: Sequence[Fit] = (),
) -> Posterior:
    """Return the posterior; ``rest`` are names and evidence of effects that were only looked at.

    Of effects beside something unknown, those of ``unlike`` contradict their law: what they explain is unknown.
    """
    logs: dict[tuple[str, ...], list[float]] = {(): [none.log_evidence + math.log(PRIOR["none"])]}
    pairs = max(effects * (effects - 1) / 2, 1.0)
    for fit in fits:
        share = PRIOR["beside"] / effects if fit.unknown_beside else PRIOR["one"] / effects
        prior = math.log(share if len(fit.candidates) == 1 else PRIOR["two"] / pairs)
        logs.setdefault(fit.names, []).append(fit.log_evidence + prior)
    for name, evidence in rest:
        logs.setdefault((name,), []).append(evidence + math.log(PRIOR["one"] / effects))
    logs["unknown",] = [unknown.log_evidence + math.log(PRIOR["unknown"])]
    contradicting: dict[tuple[str, ...], list[float]] = {}
    for fit in unlike:
        contradicting.setdefault(fit.names, []).append(fit.log_evidence + math.log(PRIOR["beside"] / effects))
    totals = {names: _shared(values) for names, values in logs.items()}
    totals["unknown",] = _log_sum([totals["unknown",], *(_shared(values) for values in contradicting.values())])
    within = within_its_law(fits, none, unknown.log_evidence, misfit=MISFIT)
    if within:
        totals["unknown",] = min(totals["unknown",], totals[within.names] - math.log(LESS_PROBABLE))
        for names in {fit.names for fit in fits if takes_any_form(fit)}:
            totals[names] = min(totals[names], totals[within.names])
    top = max(totals, key=lambda names: totals[names])
    if len(top) > 1 and "unknown" not in top:
        totals["unknown",] += IMITATED
        top = max(totals, key=lambda names: totals[names])
    misfit = 1.0
    if "unknown" not in top:
        winner = next((fit for fit in (*fits, none) if fit.names == top), none)
        misfit = chance_of_residual(winner)
        if misfit < MISFIT:
            # The winner leaves more than noise: what it stands for is at best a part of the truth. Its weight passes to
            # whatever holds something unknown, which tells as little for an effect beside it as against one.
            passed = totals[top] + math.log(MISFIT / max(misfit, 1e-300)) - totals["unknown",]
            raised = max(passed, 0.0)
            totals = {names: value + raised * ("unknown" in names) for names, value in totals.items()}
    whole = _log_sum(list(totals.values()))
    probabilities = {names: math.exp(value - whole) for names, value in totals.items()}
    ordered = dict(sorted(probabilities.items(), key=lambda item: -item[1]))
    return Posterior(compared, none, fits, unknown, ordered, misfit)


def _shared(values: Sequence[float]) -> float:
    """Return the logarithm of what an effect at several places is worth: the places share its prior."""
    return _log_sum(values) - math.log(len(values))


def _log_sum(values: Sequence[float]) -> float:
    largest = max(values)
    return largest + math.log(sum(math.exp(value - largest) for value in values))
