"""Which known effect comes closest to what is unknown, with which values, and whether they stand at their bounds."""

from __future__ import annotations

from collections.abc import Sequence

from ...simulators.parameter import Parameter, Uniform
from .evidence import Widened
from .hypotheses import Candidate
from .refine import Fit
from .result import Estimate
from .words import parameter_label, value_words

#: Share of what differs that an effect must explain to be told, and from which on it explains nearly all.
WORTH_TELLING, NEARLY_ALL = 0.5, 0.99
#: So near to a bound, as a share of it, a value stands at it.
AT_BOUND = 0.01


def closest_words(fits: Sequence[Fit], none: Fit) -> tuple[str, ...]:
    """Return in words which known effects explain most; nothing where none explains half of what differs.

    Parameters
    ----------
    fits : sequence of Fit
        Of one and two effects.
    none : Fit
        Of no effect.
    """
    best, share = closest(fits, none)
    if best is None or share < WORTH_TELLING:
        return ()
    named = " and ".join(str(candidate).replace("_", " ") for candidate in best.candidates)
    explains = "nearly all" if share > NEARLY_ALL else f"{share:.0%}"
    does = "comes closest: it explains" if len(best.candidates) == 1 else "come closest: together they explain"
    said = f"Of the known effects {named} {does} {explains} of what differs, not the rest."
    return (" ".join([said, *_values(best)]),)


def closest(fits: Sequence[Fit], none: Fit) -> tuple[Fit | None, float]:
    """Return the likeliest fit of known effects alone, and the share of what differs that it explains."""
    best = max((fit for fit in fits if not fit.unknown_beside), key=lambda fit: fit.log_evidence, default=None)
    if best is None:
        return None, 0.0
    left = float(best.residual @ Widened(best.law).solve(best.residual))
    return best, 1 - left / max(float(none.residual @ none.residual), 1e-300)


def _values(fit: Fit) -> list[str]:
    """Return the strengths of each effect in words, and what stands at the end of what is allowed."""
    found, at_bound = [], []
    for candidate, values in zip(fit.candidates, fit.values(), strict=True):
        strengths = [candidate.coordinates[number].parameter for number in candidate.strengths]
        found += [_said(one, values[one.name]) for one in strengths if values[one.name] != one.zero]
        at_bound += _at_bounds(candidate, values)
    said = [f"Fitted to it all the same: {', '.join(found)}."] if found else []
    if at_bound:
        said.append(f"At the end of what the effect allows: {', '.join(at_bound)}; more of it may be the cause.")
    return said


def _at_bounds(candidate: Candidate, values: dict[str, float]) -> list[str]:
    found = []
    for number in candidate.strengths:
        parameter = candidate.coordinates[number].parameter
        prior = parameter.prior
        usual = (prior.low, prior.high) if isinstance(prior, Uniform) else ()
        # The end where the effect is absent says nothing.
        ends = [end for end in dict.fromkeys((*parameter.bounds, *usual)) if end != parameter.zero]
        found += [_said(parameter, end) for end in ends if abs(values[parameter.name] - end) <= AT_BOUND * abs(end)]
    return found


def _said(parameter: Parameter, value: float) -> str:
    """Return the name of a parameter and its value in a readable unit."""
    label = parameter_label(parameter.name, parameter.unit)
    return f"{label} {value_words(value, Estimate(value, value, value, parameter.unit))}"
