"""A change of the measuring chain that a single line tells.

A sensor of another gain changes all lines by one factor, and no fault of a machine does. Where only one of its lines
is large enough to show that, a support or a part beside the sensor that has changed makes that line all the same, by
as few values: the two are not told apart, and what no effect of the catalogue is, is as likely.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from .refine import Fit
from .result import Cause
from .words import line_words

#: Share of what an effect changes, in powers of the noise, from which on one line tells it.
NEARLY_ALL = 0.9
#: Share of its probability that such a cause keeps; the rest is something unknown's.
KEPT = 0.5
#: What tells them apart.
TO_TELL = "Swap that sensor with one of another place, or knock beside both, and record again"

Hypotheses = Mapping[tuple[str, ...], float]


def told_by_one_line(
    fit: Fit, causes: tuple[Cause, ...], probabilities: Hypotheses
) -> tuple[tuple[Cause, ...], Hypotheses, tuple[str, ...], str]:
    """Return causes, hypotheses, what else it may be, and what would tell it, where one line tells the cause.

    Causes and hypotheses as they are, nothing and no words where more than one line tells it.
    """
    if not one_line_words(fit) or len(causes) != 1:
        return causes, probabilities, (), ""
    (cause,), names = causes, fit.names
    told = dict(probabilities)
    told[names] = KEPT * probabilities[names]
    told["unknown",] = probabilities.get(("unknown",), 0.0) + (1 - KEPT) * probabilities[names]
    less = replace(cause, probability=cause.probability - (1 - KEPT) * probabilities[names])
    ranked = dict(sorted(told.items(), key=lambda item: (-item[1], item[0] != names)))
    return (less,), ranked, ("unknown",), TO_TELL


def one_line_words(fit: Fit) -> tuple[str, ...]:
    """Return a warning where one line tells a single cause on the measuring chain; else nothing."""
    if len(fit.candidates) != 1 or fit.unknown_beside or fit.candidates[0].effect.STAGE != "sensor":
        return ()
    assert fit.compared is not None
    lines = fit.compared.lines
    power = np.where(lines.seen, np.abs(fit.response / lines.deviations) ** 2, 0.0).sum(axis=0)
    probe, number = (int(i) for i in np.unravel_index(int(np.argmax(power)), power.shape))
    kind = lines.kinds[number]
    if not power[probe, number] > NEARLY_ALL * power.sum() or kind.frequency_hz or kind.envelope:
        return ()
    name, line = fit.candidates[0].name.replace("_", " "), line_words(lines.orders[number])
    return (
        f"{name[0].upper()}{name[1:]} is told by {line} at {lines.probes[probe]} nearly alone: a support or a part "
        "beside that sensor that has changed may do the same. Look at both.",
    )
