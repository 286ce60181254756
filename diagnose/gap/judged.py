"""From probabilities to the kind of verdict, and to what cannot be told apart."""

from __future__ import annotations

from collections.abc import Mapping

#: A hypothesis less probable than the best by this factor is told apart from it.
TOLD_APART = 20.0
#: Least probability of a verdict, of one hypothesis or of a set that cannot be told apart.
LEAST = 0.5
#: Least probability that an effect acts beside something unknown, for the effect to be named.
LEAST_BESIDE = 0.99


def judged(
    probabilities: Mapping[tuple[str, ...], float],
) -> tuple[str, tuple[str, ...], list[tuple[str, ...]]]:
    """Return the kind of verdict, the leading hypothesis, and the hypotheses that are not told apart from it."""
    leading = max(probabilities, key=lambda names: probabilities[names])
    together = [names for names, p in probabilities.items() if p * TOLD_APART > probabilities[leading]]
    if leading == ():
        return ("none" if probabilities[leading] >= LEAST else "cannot tell"), leading, [leading]
    if "unknown" in leading:
        # Whatever else acts, something unknown does; the effects that may act beside it are kept apart.
        certain = sum(p for names, p in probabilities.items() if "unknown" in names) >= LEAST
        named = sum(p for names, p in probabilities.items() if "unknown" in names and len(names) > 1)
        if named < LEAST_BESIDE:
            return ("unknown" if certain else "cannot tell"), ("unknown",), [("unknown",)]
        return "unknown", leading, [names for names in together if "unknown" in names and len(names) > 1]
    effects = [names for names in together if names and "unknown" not in names]
    if sum(probabilities[names] for names in effects) < LEAST:
        return "cannot tell", leading, effects
    return ("one cause" if len(leading) == 1 else "several causes"), leading, effects
