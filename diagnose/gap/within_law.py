"""An effect that explains the lines within its law is not passed by something unknown for being a little tighter.

Something unknown takes the size of each order, and how it grows, from the data; the width of an effect's law is given.
Where the lines are clear, a wide law costs an effect evidence that speaks for nothing else: a force at the place of a
loose support describes what a loose support does more tightly than a law that may be wrong by a tenth at every probe.
What tells the two apart is whether more than noise is left. An effect of another name leaves far more, see
"Within its law" in the README of this package. An effect that takes the size and angle of each of its lines from the
data, as the forces of a misaligned coupling, passes a crack in the same way: the two are then level.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .null_distribution import chance_of_residual
from .own_angles import have_own_angles
from .refine import Fit

#: Evidence over nothing at all that an effect needs: of faint lines any effect leaves only noise.
CLEAR = 100.0
#: Share of that which something unknown may be ahead by, and most that it may.
SHARE, MOST_BEHIND = 0.02, 100.0
#: Most of the squared residual that an idealised effect, without the tolerance of its law, may leave: 10 dB, which
#: contacts and cracks of other simulators, whose law is another one, reach. Sizes are predicted to a factor, and may
#: leave more than was there.
LEFT = 0.1
#: Share of d2 below which lines with phase do not tell an effect: sizes do.
LOCKED = 0.1
#: How much less probable than such an effect something unknown is.
LESS_PROBABLE = 20.0
#: A second effect needs this much more evidence than the best single one.
PAIR_MARGIN = 5.0


def within_its_law(fits: Sequence[Fit], none: Fit, unknown: float, *, misfit: float) -> Fit | None:
    """Return the best single effect that leaves only noise and is hardly behind something unknown; None without one.

    Nor behind one that takes any form; it is the best of the others.

    Parameters
    ----------
    fits : sequence of Fit
    none : Fit
        Of no effect.
    unknown : float
        Logarithm of the evidence for something unknown.
    misfit : float
        Chance below which what an effect leaves is more than noise.
    """
    singles = [fit for fit in fits if len(fit.candidates) == 1 and not fit.unknown_beside]
    of_one_form = [fit for fit in singles if not takes_any_form(fit)]
    if not of_one_form:
        return None
    best = max(of_one_form, key=lambda fit: fit.log_evidence)
    gain = best.log_evidence - none.log_evidence
    behind = max(unknown, *(fit.log_evidence for fit in singles)) - best.log_evidence
    if not _is_wide(best) or gain < CLEAR or behind > min(SHARE * gain, MOST_BEHIND):
        return None
    rest = best.residual @ best.residual / (none.residual @ none.residual)
    if best.candidates[0].effect.IDEALISED and rest > LEFT:
        return None
    return best if chance_of_residual(best) > misfit else None


def takes_any_form(fit: Fit) -> bool:
    """Return whether a fit is of one effect that takes size and angle of each of its lines from the data."""
    return len(fit.candidates) == 1 and not fit.unknown_beside and have_own_angles(fit.candidates[0])


def pair_margin(best: Fit, none: Fit, *, misfit: float) -> float:
    """Return how much more evidence than the best single effect two need.

    As much as something unknown where that one's law is wide, as told by sizes or an idealisation, and it leaves only
    noise: what a second one adds may be what the first one's law is off by, and a narrower law is worth evidence by
    itself. Not of the measuring chain, which is exact.
    """
    gain = best.log_evidence - none.log_evidence
    inexact = not any(one.effect.STAGE == "sensor" for one in best.candidates)
    if not (inexact and _is_wide(best)) or gain < CLEAR or chance_of_residual(best) <= misfit:
        return PAIR_MARGIN
    return max(min(SHARE * gain, MOST_BEHIND), PAIR_MARGIN)


def pair_level(best: Fit, none: Fit, *, misfit: float) -> float:
    """Return the evidence that two effects must exceed by `PAIR_MARGIN`, ``best`` being the best single one."""
    return best.log_evidence + pair_margin(best, none, misfit=misfit) - PAIR_MARGIN


def _is_wide(fit: Fit) -> bool:
    """Return whether the law is wide: it is an idealisation, or only sizes of lines tell the effect.

    Of others the evidence is to be believed: a run-out that imitates a sensor put on anew leaves only noise, too.
    """
    idealised = fit.candidates[0].effect.IDEALISED
    if idealised or fit.compared is None:
        return idealised
    phases = np.array([kind.phase for kind in fit.compared.lines.kinds])
    whole, locked = (fit.compared.detectability(own) for own in (fit.response, np.where(phases, fit.response, 0.0)))
    return locked < LOCKED * whole


def loose_law_words(named: Fit, unknown: float) -> list[str]:
    """Return a remark where the single effect that is named fits less tightly than something unknown."""
    if len(named.candidates) != 1 or named.unknown_beside or unknown <= named.log_evidence:
        return []
    name = named.candidates[0].name.replace("_", " ")
    return [
        f"Forces without any law describe the lines more tightly than {name} does: it explains them within the "
        "tolerance of its law, but that law is not quite the one here. Values may lie outside their intervals."
    ]
