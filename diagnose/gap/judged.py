"""From probabilities to the kind of verdict, and to what cannot be told apart."""

from __future__ import annotations

from collections.abc import Mapping

#: A hypothesis less probable than the best by this factor is told apart from it.
TOLD_APART = 20.0
#: Least probability of a verdict, of one hypothesis or of a set that cannot be told apart.
LEAST = 0.5


def judged(
    probabilities: Mapping[tuple[str, ...], float],
) -> tuple[str, tuple[str, ...], list[tuple[str, ...]]]:
    """Return the kind of verdict, the leading hypothesis, and the hypotheses that are not told apart from it."""
    leading = max(probabilities, key=lambda names: probabilities[names])
    together = [names for names, p in probabilities.items() if p * TOLD_APART > probabilities[leading]]
    if leading == ():
        return ("none" if probabilities[leading] >= LEAST else "cannot tell"), leading, [leading]
    if leading == ("unknown",):
        return ("unknown" if probabilities[leading] >= LEAST else "cannot tell"), leading, [leading]
    effects = [names for names in together if names not in ((), ("unknown",))]
    if sum(probabilities[names] for names in effects) < LEAST:
        return "cannot tell", leading, effects
    return ("one cause" if len(leading) == 1 else "several causes"), leading, effects
